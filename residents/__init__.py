# SPDX-License-Identifier: GPL-3.0-or-later
"""The people of a home: their bodies, their routines, and the simulation of their days.

`body`, `acting`, `routine` and `days` work without Blender. `blender`, `operators` and `panels` use
them in the open blend file. The sensors import nothing of residents: parts.py at the root registers
both.
"""
