# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a resident: bones, poses as arrays, and the shapes of the skin.

It needs only numpy. The first axis of each array, n, counts poses, one for each time. Lengths are
in metres, angles in radians. A rotation turns a bone from rest to its pose: a unit quaternion (w,
x, y, z) in world axes. Side 0 is the left one.
"""
