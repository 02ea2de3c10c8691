# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport draws of the sensors: their fields of view as they are, and their states.

`picture` keeps lines and surfaces of what each sensor's own rays met (runtime/trace.py), which the
kinds make with the help of `figures`, and colours them by the sensors' readings; `draw` puts them
on the screen, and `labels` names and readings, where there is room. `hover` knows what the mouse is
over. Only `draw` and `labels` know the GPU.
"""
