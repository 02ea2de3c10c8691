# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the sensors of a layout file into the open home: `measured` reads where sensors stand,
`plan` finds what a layout changes, `apply` does all of it or nothing."""
