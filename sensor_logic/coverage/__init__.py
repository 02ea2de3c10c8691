# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage maps: where on the floor a motion is detected, and by which detectors."""
