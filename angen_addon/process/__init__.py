# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs Blender as a module of a Python process: loads the extension, silences Blender, ends it."""
