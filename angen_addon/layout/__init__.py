# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply a layout file to the open home.

`measured` reads the places of sensors, `plan` finds what a layout changes, and `apply` makes all
changes or none.
"""
