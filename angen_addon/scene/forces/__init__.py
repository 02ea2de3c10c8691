# SPDX-License-Identifier: GPL-3.0-or-later
"""The bodies that press on pads of pressure sensors: their shapes, motion and supports."""
