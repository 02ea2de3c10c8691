# SPDX-License-Identifier: GPL-3.0-or-later
"""What knows Blender: properties, the scene probes, the simulation, handlers, command line."""
