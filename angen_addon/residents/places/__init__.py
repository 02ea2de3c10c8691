# SPDX-License-Identifier: GPL-3.0-or-later
"""What a home's objects are marked as for its residents: places, doors, lamps."""
