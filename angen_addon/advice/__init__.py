# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds what in a file keeps sensors from reading what its user expects, with ways to mend it."""
