# SPDX-License-Identifier: GPL-3.0-or-later
"""Where motion detectors notice what moves, and where to put them: numbers alone, no scene."""
