# SPDX-License-Identifier: GPL-3.0-or-later
"""Read from the scene the bodies that press on pads: their shapes, motion and supports."""
