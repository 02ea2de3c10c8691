# SPDX-License-Identifier: GPL-3.0-or-later
"""The physics and bookkeeping of ambient sensors: numpy and the standard library, no Blender."""
