# SPDX-License-Identifier: GPL-3.0-or-later
"""Render the light at sensors: by `probe`, when `scene.changes` finds that it may have changed."""
