# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulation over time: steps, captured frames, sensor runners and the playhead.

`simulation` runs over a range of frames. `stage` evaluates the scene at each step of a run.
"""
