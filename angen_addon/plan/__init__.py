# SPDX-License-Identifier: GPL-3.0-or-later
"""The floor plan of a home: storeys, rooms, walls, furniture and sensors."""
