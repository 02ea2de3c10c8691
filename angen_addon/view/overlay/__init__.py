# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw sensors in 3D views: fields of view, signs, names and readings.

`picture` makes coloured lines and surfaces from the hits of each sensor's rays
(`runtime/trace.py`). Each kind of sensor says which, with the functions of `figures`. `draw` puts
them on the screen, and `labels` adds names and readings where there is room. `hover` finds the
sensor below the mouse. `refresh` decides when all this is brought up to date. Only `draw` and
`labels` use the GPU.
"""
