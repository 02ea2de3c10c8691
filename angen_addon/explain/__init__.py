# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain a sensor's reading: which object and ray caused it, and by how much.

For this the scene is set to the frame of the update, and to the frame of an earlier update for
comparison. There the sensor uses the same rays, noise and model as in the run. Since the frame
changes, no explanation is made in `draw` or in a handler.
"""
