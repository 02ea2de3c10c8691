# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of ambient sensors, and their logs: numpy and the standard library, no Blender."""
