# SPDX-License-Identifier: GPL-3.0-or-later
"""The people of a home: their bodies, their routines, and days that they live.

`body`, `acting`, `routine` and `days` work without Blender; `blender`, `operators` and `panels`
bring that into the open file. The sensors know nothing of residents: parts.py at the root registers
both.
"""
