# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain why a sensor reads what it reads: by which object, which ray, and by how much.

To explain an update, the scene goes back to its frame, and to the frame of the update that it is
compared with. There the sensor uses the same rays, noise and model as in the run. Since the frame
changes, no explanation is made in `draw` or in a handler.
"""
