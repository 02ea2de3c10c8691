# SPDX-License-Identifier: GPL-3.0-or-later
"""Add sensors: their presets, their housings, and their poses on surfaces."""
