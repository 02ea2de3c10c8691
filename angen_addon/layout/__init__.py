# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply a layout file, which lists the sensors of a home, to the open home.

`measured` reads the poses of sensors, `plan` finds what a layout changes in sensors and `marks` in
the marks of objects, and `apply` makes all changes or none.
"""
