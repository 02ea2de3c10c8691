# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulation over time: steps, stored frames, sensor runners and the playhead.

`simulation` runs over frames. `stage` has what runs, live readings and explanations share.
"""
