# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the light at sensors. `probe` does it, once `scene.changes` found that it may differ."""
