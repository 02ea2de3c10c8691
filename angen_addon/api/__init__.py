# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python package `angen_sensors` for scripts and notebooks: homes, their sensors, recordings.

The module `recording` does not need Blender. So a process without Blender can unpickle recordings
that worker processes made with Blender.
"""
