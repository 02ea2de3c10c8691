# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays and bodies that move, in numpy."""
