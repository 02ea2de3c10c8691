# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles, rays and moving rays."""
