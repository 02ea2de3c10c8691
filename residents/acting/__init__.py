# SPDX-License-Identifier: GPL-3.0-or-later
"""Act out a day of a routine: the motion of bodies, doors, lamps and things.

From the top down; each module imports only those after it:

- `day`: all persons of a home; always advances the one whose time is earliest.
- `performer`: does the steps of a person's activities, which `activity_steps` parses.
- `navigator`: walks through doors, around others and to free places; `route_planner` says where a
  way leads now.
- `hands`: work, carried things, and the handles of doors.
- `home_in_use`: open doors, lamps, things and reserved places; `traffic`: who is in whose way.
- `actor`: walks, sits and lies; `moving_body`: the body's pose now, and its timeline so far.
- `walking_frame`: where it fits, and where its user leaves it.
- `floor_map`: floors, doors and paths of a home; `places`: what is marked in it.
- `path_search`: paths over one floor.
- `timeline`: motion as functions of time, and what was acted.

Apart from these, `unreached_places` checks a home's marks.
"""

from .day import act, acting
from .floor_map import FloorMap

__all__ = ["FloorMap", "act", "acting"]
