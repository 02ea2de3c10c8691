# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers for Python processes that use Blender as a module.

The modules load the extension, suppress Blender's messages, and clean up before the process ends.
"""
