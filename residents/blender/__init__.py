# SPDX-License-Identifier: GPL-3.0-or-later
"""The residents of a home in Blender: their bodies, the places that they use, and keyframes."""
