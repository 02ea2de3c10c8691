# SPDX-License-Identifier: GPL-3.0-or-later
"""A person on a sofa's cushion, which lies on a pad, with the feet on the floor: what each carries
must be as statics has it."""

import numpy as np
import pytest
from pressure_scenes import G

MASS, CUSHION, TOLERANCE = 70.0, 2.5, 0.03
TOP = 0.47  # of the cushion, in m
# By eye: how deep the seat is in the cushion and the shoes in the floor, in m.
SEAT_SUNK, SHOES_SUNK = 0.02, 0.01
SEAT = ((0.17, 0.225, 0.07), (0, 0.235, TOP - SEAT_SUNK + 0.07))
SHOES = [((0.05, 0.13, 0.04), (x, -0.2, 0.04 - SHOES_SUNK)) for x in (-0.1, 0.1)]
SHINS = [((0.05, 0.05, 0.17), (x, -0.15, 0.25)) for x in (-0.1, 0.1)]


def person_of(trunk):
    """Half sizes and middles of boxes; the sofa's back is at +y, `trunk` is the trunk's y."""
    return [SEAT, ((0.17, 0.11, 0.3), (0, trunk, 0.89)), *SHINS, *SHOES]


PAD, LYING = ((0.31, 0.26, 0.006), (0, 0.385, 0.306)), ((0.385, 0.345, 0.079), (0, 0.35, 0.391))


def sofa(physics):
    """As the sample home's: a pad on a frame, and a cushion of 2.5 kg on the pad alone."""
    physics.frames(4)
    physics.solid("floor", (5, 5, 0.5), (0, 0, -0.5))
    physics.solid("frame", (0.9, 0.4, 0.1), (0, 0.4, 0.2))
    physics.pad(half=PAD[0], at=PAD[1])
    physics.carried("cushion", *LYING, CUSHION, tolerance=0.005)


def layer(boxes, sunk):
    """The first moments (3,) over y of an elastic layer below boxes, pressed in as posed."""
    found = np.zeros(3)
    for half, (_, y, _) in boxes:
        stiff = 4.0 * half[0] * half[1] * (1.0 + sunk / TOLERANCE)
        found += stiff * np.array([1.0, y, y**2 + half[1] ** 2 / 3.0])
    return found


def on_seat(person):
    """N: what of the person's weight the seat carries. Person and cushion go down by p + q·y and
    r + s·y on the layers below shoes, seat and cushion, until forces and moments are in balance."""
    volumes = np.array([8.0 * np.prod(half) for half, _ in person])
    centre = volumes @ np.array([middle[1] for _, middle in person]) / volumes.sum()
    shoes, seat, pad = (
        np.array([[k, ky], [ky, kyy]])
        for k, ky, kyy in (layer(SHOES, SHOES_SUNK), layer([SEAT], SEAT_SUNK), layer([PAD], 0.0))
    )
    weights = G * np.array([MASS, MASS * centre, CUSHION, CUSHION * LYING[1][1]])
    person_down, cushion_down = np.linalg.solve(
        np.block([[shoes + seat, -seat], [-seat, seat + pad]]), weights
    ).reshape(2, 2)
    for (half, (_, y, _)), down in (
        (SHOES[0], person_down), (SEAT, person_down - cushion_down), (PAD, cushion_down),
    ):  # fmt: skip
        assert min(down @ [1.0, y - half[1]], down @ [1.0, y + half[1]]) > 0, "all of it is pressed"
    return float((seat @ (person_down - cushion_down))[0])


@pytest.mark.parametrize("trunk", [0.2, 0.17, 0.14], ids=["back", "upright", "forward"])
def test_the_pad_under_a_seat_and_the_feet_on_the_floor(physics, figure, trunk):
    person = person_of(trunk)
    sofa(physics)
    physics.carried("Person", (), (0, 0, 0), MASS, TOLERANCE, parts=person)
    wanted = on_seat(person)
    pad = physics.read()
    figure(wanted / (MASS * G), "of the weight is on the seat")
    assert pad.known() == pytest.approx(wanted + CUSHION * G, rel=0.01)
    assert set(pad.partners) == {"cushion"}
