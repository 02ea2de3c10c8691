# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the bodies that press on pads from the scene: their shapes, motion and supports."""
