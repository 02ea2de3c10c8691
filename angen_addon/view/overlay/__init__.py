# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw sensors in 3D views: fields of view, signs, names and readings.

- `figures` makes lines and surfaces from the hits of rays, for the kinds of sensors.
- `picture` gives these shapes the colours of the sensors' states.
- `draw` draws them on the screen, and `labels` adds names and readings if there is room.
- `hover` finds the sensor below the mouse.
- `refresh` decides when the shapes are made anew.

Only `draw` and `labels` use the GPU.
"""
