# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes where motion detectors notice motion and where to place them: numbers only, no scene."""
