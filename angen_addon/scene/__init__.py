# SPDX-License-Identifier: GPL-3.0-or-later
"""The only code that reads the Blender scene: turns the evaluated depsgraph into arrays."""
