# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport draws of the sensors: their fields of view as they are, and their states.

`drawn_sensors` keeps lines and surfaces of what each sensor's own rays met (runtime/trace.py),
which the kinds make with the help of `figures`; `picture` colours these by the sensors' readings;
`draw` and `labels` put them on the screen, `label_layout` in places that `covered` leaves free;
`hover` knows what the mouse is over. Only `draw` and `labels` know the GPU.
"""

from ...registering import of_modules

register, unregister = of_modules(__name__, "settings", "hover", "draw", "refresh")
