# SPDX-License-Identifier: GPL-3.0-or-later
"""Where motion detectors detect motion, and where to place them: numbers only, without a scene."""
