# SPDX-License-Identifier: GPL-3.0-or-later
"""All code that needs Blender: properties, probes, simulation, handlers and commands."""
