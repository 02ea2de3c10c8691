# SPDX-License-Identifier: GPL-3.0-or-later
"""Helps Python processes that have Blender as a module.

The modules load the extension, silence Blender, and clean up before the process ends.
"""
