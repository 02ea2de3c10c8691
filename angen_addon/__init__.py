# SPDX-License-Identifier: GPL-3.0-or-later
"""The code of the sensors that needs Blender."""
