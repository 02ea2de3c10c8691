# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python package `angen_sensors` for scripts and notebooks: homes, their sensors, recordings.

`recording` needs no Blender, so that a process without it can read recordings of its workers.
"""
