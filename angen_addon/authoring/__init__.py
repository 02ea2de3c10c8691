# SPDX-License-Identifier: GPL-3.0-or-later
"""Make new sensors: presets of parts, housings, and placing on surfaces."""
