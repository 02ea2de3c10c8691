# SPDX-License-Identifier: GPL-3.0-or-later
"""How residents move: the ways that they take, without Blender."""
