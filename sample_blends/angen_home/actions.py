# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of a story. Names are those of `plan` and of the scene; times are seconds."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Walk:
    """Goes to a place and turns the way one looks there."""

    place: str
    speed: float = 1.1  # m/s


@dataclass(frozen=True)
class OpenDoor:
    """Steps to the door's handle on this side and opens it."""

    door: str


@dataclass(frozen=True)
class CloseDoor:
    """Steps to where the handle will be and shuts the door."""

    door: str


@dataclass(frozen=True)
class LetDoorClose:
    """The door falls shut by itself as soon as nobody is in its way; the story goes on."""

    door: str


@dataclass(frozen=True)
class Open:
    """Opens a thing that has a hinged door, such as the fridge."""

    thing: str


@dataclass(frozen=True)
class Close:
    """Shuts it."""

    thing: str


@dataclass(frozen=True)
class Take:
    """Takes a prop from where it is."""

    prop: str


@dataclass(frozen=True)
class Put:
    """Puts a prop that is in the hand at a spot."""

    prop: str
    spot: str


@dataclass(frozen=True)
class Drink:
    """Drinks from the prop in the hand."""

    prop: str


@dataclass(frozen=True)
class UseBothHands:
    """Busies both hands at a spot: washing, cooking."""

    spot: str
    seconds: float


@dataclass(frozen=True)
class LookAround:
    """Stays and looks to both sides."""

    seconds: float


@dataclass(frozen=True)
class Sit:
    """Sits down at a place that has a seat; the way there first."""

    place: str


@dataclass(frozen=True)
class Shift:
    """Moves to sit more comfortably."""


@dataclass(frozen=True)
class StandUp:
    """Gets up from a seat."""


@dataclass(frozen=True)
class Lie:
    """From sitting on the bed's edge: lies down on the back."""

    place: str


@dataclass(frozen=True)
class Wait:
    """Stays as one is."""

    seconds: float


@dataclass(frozen=True)
class Switch:
    """Turns a lamp on or off; the hand is not shown."""

    lamp: str
    on: bool


Action = (
    Walk | OpenDoor | CloseDoor | LetDoorClose | Open | Close | Take | Put | Drink
    | UseBothHands | LookAround | Sit | Shift | StandUp | Lie | Wait | Switch
)  # fmt: skip
