# SPDX-License-Identifier: GPL-3.0-or-later
"""What rays meet, as exact as Blender's own caster and many times as fast."""
