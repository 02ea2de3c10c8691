# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens in the sample: a list to be read from top to bottom. Write your own.

The words are in `actions`, the places, doors and lamps in `plan`; spots and props are below.
Doors start closed, lamps as the home sets them. The person starts at START.
One can Sit at sofa_seat, sofa_seat_east, shoe_bench, toilet and bed_edge, and Lie at bed_lie;
the chairs stand too close to their tables. A hand reaches 1.2 m, not through what is closed.
"""

from .actions import (
    Action,
    Close,
    CloseDoor,
    Drink,
    LetDoorClose,
    Lie,
    LookAround,
    Open,
    OpenDoor,
    Put,
    Shift,
    Sit,
    StandUp,
    Switch,
    Take,
    UseBothHands,
    Wait,
    Walk,
)

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

STORY: list[Action] = [
    # Home from work.
    Switch("Lamp hall", on=True),
    OpenDoor("entrance"),
    Walk("entrance_handle_inside"),
    CloseDoor("entrance"),
    Walk("coat_hook"),
    Put("Coat", "coat hook"),
    # Something to drink.
    OpenDoor("kitchen"),
    Switch("Lamp kitchen", on=True),
    Walk("fridge"),
    LetDoorClose("kitchen"),
    Open("Fridge door"),
    Take("Bottle"),
    Close("Fridge door"),
    OpenDoor("kitchen"),
    Switch("Lamp kitchen", on=False),
    LetDoorClose("kitchen"),
    # A rest on the sofa.
    Switch("Lamp living room", on=True),
    Sit("sofa_seat"),
    Drink("Bottle"),
    Put("Bottle", "coffee table"),
    Wait(6.0),
    LookAround(4.0),
    Shift(),
    Wait(5.0),
    Take("Bottle"),
    Drink("Bottle"),
    Put("Bottle", "coffee table"),
    Wait(5.0),
    StandUp(),
    # To the bathroom.
    Switch("Lamp living room", on=False),
    OpenDoor("bathroom"),
    Switch("Lamp bathroom", on=True),
    Walk("washbasin"),
    LetDoorClose("bathroom"),
    Sit("toilet"),
    Wait(4.0),
    StandUp(),
    Walk("washbasin"),
    UseBothHands("washbasin tap", 5.0),
    OpenDoor("bathroom"),
    Switch("Lamp bathroom", on=False),
    LetDoorClose("bathroom"),
    # A glance into the closet.
    OpenDoor("closet"),
    LookAround(2.0),
    CloseDoor("closet"),
    # To bed.
    OpenDoor("bedroom"),
    Switch("Lamp hall", on=False),
    Switch("Lamp bedroom", on=True),
    Walk("bedside"),
    LetDoorClose("bedroom"),
    Sit("bed_edge"),
    Lie("bed_lie"),
    Switch("Lamp bedroom", on=False),
    Wait(12.0),
]
