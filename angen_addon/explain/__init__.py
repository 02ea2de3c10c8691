# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain why a sensor reads what it reads: by which object, which ray, and by how much.

An explanation goes back to the frame of the update, and to the frame of the update that it is
compared with. There it uses the same rays, noise and model as the run. It changes the frame, so it
never runs in `draw` or in a handler.
"""
