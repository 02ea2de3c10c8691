# SPDX-License-Identifier: GPL-3.0-or-later
"""Intersections of triangles with rays, at rest and in motion."""
