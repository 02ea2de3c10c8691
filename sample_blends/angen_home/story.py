# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens in the sample: a list to be read from top to bottom. Write your own.

The words are those of routines (docs/residents.md), done from where one stands: doors are opened
in words of their own, and of those that fall shut (`director.FALLS_SHUT`) `close` lets go. Places,
doors and lamps are in `plan`; spots and props are below. Doors start closed, lamps as the home sets
them. The person starts at START. One can sit at sofa_seat, sofa_seat_east, shoe_bench, toilet and
bed_edge, and lie at bed_lie; the chairs stand too close to their tables. A hand reaches 1.2 m, not
through what is closed.
"""

START = "outside_entrance"

# Points (m) that hands go to and that props stand on.
SPOTS: dict[str, tuple[float, float, float]] = {
    "coat hook": (6.185, 7.98, 1.70),
    "fridge shelf": (3.17, 5.53, 0.816),
    "coffee table": (8.80, 5.24, 0.470),
    "kitchen worktop": (2.05, 5.45, 0.96),
    "washbasin tap": (4.90, 0.58, 0.96),
}

# Props and where they are at the start: a spot, or "hand".
PROPS: dict[str, str] = {"Coat": "hand", "Bottle": "fridge shelf"}

STORY = """
switch Lamp hall on
open Door entrance
go entrance_handle_inside
close Door entrance
go coat_hook
put Coat at coat hook

open Door kitchen
switch Lamp kitchen on
go fridge
close Door kitchen
open Fridge door
take Bottle
close Fridge door
open Door kitchen
switch Lamp kitchen off
close Door kitchen

switch Lamp living room on
sit sofa_seat
drink Bottle
put Bottle at coffee table
wait 6 s
look around 4 s
shift
wait 5 s
take Bottle
drink Bottle
put Bottle at coffee table
wait 5 s

switch Lamp living room off
open Door bathroom
switch Lamp bathroom on
go washbasin
close Door bathroom
sit toilet
wait 4 s
go washbasin
use washbasin tap 5 s
open Door bathroom
switch Lamp bathroom off
close Door bathroom

open Door closet
look around 2 s
close Door closet

open Door bedroom
switch Lamp hall off
switch Lamp bedroom on
go bedside
close Door bedroom
sit bed_edge
lie bed_lie
switch Lamp bedroom off
wait 12 s
"""
