# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the light at light sensors: `probe` measures it when `changes` finds changes."""
