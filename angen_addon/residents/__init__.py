# SPDX-License-Identifier: GPL-3.0-or-later
"""Who lives in a home, as Blender has it: bodies, the places that they use, their keys."""
