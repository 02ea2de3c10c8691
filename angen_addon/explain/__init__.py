# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a sensor reads what it reads: the object, the ray and by how much.

The facts are gathered by going back to the update's frame and the one that it was compared with,
with the same rays, noise and model as in the run. Never in `draw` or in a handler.
"""
