# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the sensors of a layout file into the open home: `told` says where sensors stand, `plan`
what a layout changes, `apply` does it, all of it or nothing."""
