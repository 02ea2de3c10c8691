# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: one file for each place in the interface."""
