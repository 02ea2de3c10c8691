# SPDX-License-Identifier: GPL-3.0-or-later
"""Cast rays through the scene as exactly as Blender's ray caster, and many times as fast."""
