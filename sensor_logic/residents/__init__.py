# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes how residents live and move: days, ways, bodies; without Blender."""
