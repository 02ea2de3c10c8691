# SPDX-License-Identifier: GPL-3.0-or-later
"""The residents of a home in Blender: bodies, the places that they use, their keys."""
