# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender as a module of a Python process: loaded, kept quiet, ended."""
