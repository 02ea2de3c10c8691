# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a resident: its bones, its poses for whole arrays of times, its skin as shapes.

Everything is numpy; a leading axis n counts moments. Lengths are metres, angles radians; a turn is
a unit quaternion (w, x, y, z) from a bone's rest to its pose, in world axes; left is side 0.
"""
