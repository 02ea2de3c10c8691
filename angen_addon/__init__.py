# SPDX-License-Identifier: GPL-3.0-or-later
"""All code of the sensors that needs Blender."""
