# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw sensors in 3D views: fields of view, signs, names and readings.

`figures` has what the kinds of sensors draw with: lines and surfaces from the hits of the rays.
`picture` gives them the colours of the sensors' states. `draw` puts them on the screen, and
`labels` adds names and readings if there is room. `hover` finds the sensor below the mouse.
`refresh` decides when all this is brought up to date. Only `draw` and `labels` use the GPU.
"""
