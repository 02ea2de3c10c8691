# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of each kind of sensor in Blender.

Each module or package of this folder is named after a kind, and defines its `APPEARANCE`. A kind
without a module has the defaults of `Appearance`. `appearance_of` finds the appearance of a kind.
"""
