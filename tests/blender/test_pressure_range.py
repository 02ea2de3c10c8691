# SPDX-License-Identifier: GPL-3.0-or-later
"""Pads at the ends of what scenes have: masses, distances, thin pads, units, and random piles."""

import numpy as np
import pytest
from pressure_scenes import G
from tiers import mostly_slow

EXACT = 1e-3


@pytest.mark.parametrize("mass", mostly_slow([0.001, 0.02, 1.0, 80.0, 500.0], 0.001, 500.0))
def test_masses(physics, mass):
    physics.on_floor(12)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), mass)
    assert physics.read().known() == pytest.approx(mass * G, rel=EXACT)


@pytest.mark.parametrize("ratio", mostly_slow([10, 100, 1000], 100))
@pytest.mark.parametrize("heavy_below", [True, False])
def test_mass_ratios(physics, ratio, heavy_below):
    """The engine squeezes a light body out from under a heavy one; whatever they do, the pad below
    has Σ m(g + a) of both, or says that it does not know."""
    physics.frames(24)
    physics.pad(half=(2, 2, 0.25), at=(0, 0, -0.25), kind="PASSIVE")
    masses = (0.1 * ratio, 0.1) if heavy_below else (0.1, 0.1 * ratio)
    lower = physics.body("lower", (0.1, 0.1, 0.05), (0, 0, 0.05), masses[0], linear_damping=0.0)
    upper = physics.body("upper", (0.1, 0.1, 0.05), (0, 0, 0.15), masses[1], linear_damping=0.0)
    pad = physics.read()
    weight = sum(masses) * G
    assert pad.valid.mean() > 0.8, pad.problems
    physics.scene.angen_live = False
    heights = []
    for frame in range(1, 26):
        physics.scene.frame_set(frame)
        heights.append([physics.place_of(body)[2] for body in (lower, upper)])
    exact = weight + (np.diff(heights, 2, axis=0) * 24**2) @ masses
    known = pad.valid[1:]
    assert pad.force[1:][known] == pytest.approx(exact[known], abs=0.02 * weight)


@pytest.mark.parametrize("kind", [None, "PASSIVE"])
@pytest.mark.parametrize(
    "far",
    mostly_slow([(100, 0, 0), (2000, -1000, 0), (0, 2000, 500)], (2000, -1000, 0), tuples=False),
    ids=str,
)
def test_far_from_the_origin(physics, far, kind):
    physics.frames(20)
    x, y, z = far
    floor = physics.floor()
    floor.location = (x, y, z - 0.5)
    thick = 0.01 if kind else 0.0
    physics.pad(kind=kind, at=(x, y, z + thick - 0.005))
    physics.body("box", (0.1, 0.1, 0.1), (x, y, z + thick + 0.1), 5.0)
    physics.carried("Person", (0.02, 0.02, 0.5), (x + 0.12, y + 0.12, z + thick + 0.5), 70.0)
    pad = physics.read()
    assert pad.valid[pad.frames > 4].all(), pad.problems
    assert pad.force[pad.frames > 4] == pytest.approx(75 * G, rel=5e-3)


@pytest.mark.parametrize("kind", [None, "PASSIVE"])
@pytest.mark.parametrize("thick", mostly_slow([0.00045, 0.0001], 0.0001))
def test_thin_pads(physics, thick, kind):
    """A real sensor is 0.45 mm thick; the floor beside it carries its part of a body over both."""
    physics.on_floor(16)
    physics.pad(half=(0.15, 0.15, thick / 2), at=(0, 0, thick / 2), kind=kind)
    height = thick if kind else 0.0
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, height + 0.1), 5.0)
    assert physics.read().known(after=3) == pytest.approx(5 * G, rel=EXACT)


def test_a_foil_without_thickness(physics):
    """A flat square as a pad; its +Z up."""
    physics.on_floor(10)
    square = [(-0.15, -0.15, 0), (0.15, -0.15, 0), (0.15, 0.15, 0), (-0.15, 0.15, 0)]
    foil = physics.world.link("pad", physics.world.mesh(square, [(0, 1, 2, 3)]), (0, 0, 0.0001))
    physics.sense(foil)
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.1), 5.0)
    physics.carried("Person", (0.02, 0.02, 0.5), (0.12, 0.12, 0.5), 70.0)
    assert physics.read().known(after=3) == pytest.approx(75 * G, rel=EXACT)


# Units


def test_centimetres(physics):
    """A scene modelled in cm: lengths, and gravity, count a hundredth of a metre."""
    physics.frames(12)
    settings = physics.scene.unit_settings
    settings.system, settings.scale_length = "METRIC", 0.01
    physics.scene.gravity = (0, 0, -981)
    floor = physics.solid("floor", (500, 500, 50), (0, 0, -50))
    physics.rigid_body(floor, "PASSIVE")
    physics.pad(half=(15, 15, 0.5), at=(0, 0, 0.5), kind="PASSIVE")
    physics.body("box", (5, 5, 5), (4, 0, 6), 5.0)
    physics.carried("Person", (2, 2, 50), (-10, 0, 51), 70.0)
    pad = physics.read()
    assert pad.known(after=3) == pytest.approx(75 * G, rel=EXACT)
    assert pad.cop[8, 0] == pytest.approx((5 * 0.04 - 70 * 0.1) / 75, abs=2e-3)


def test_no_units(physics):
    physics.frames(8)
    settings = physics.scene.unit_settings
    settings.system, settings.scale_length = "NONE", 0.01
    physics.floor()
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    assert physics.read().known() == pytest.approx(5 * G, rel=EXACT)


def test_feet(physics):
    """A unit of 0.3048 m: gravity is 32.17 ft/s²."""
    physics.frames(8)
    settings = physics.scene.unit_settings
    settings.system, settings.scale_length = "IMPERIAL", 0.3048
    physics.scene.gravity = (0, 0, -G / 0.3048)
    physics.floor()
    physics.pad(kind="PASSIVE", half=(0.5, 0.5, 0.02), at=(0, 0, 0.02))
    physics.body("box", (0.3, 0.3, 0.3), (0, 0, 0.34), 5.0)
    assert physics.read().known() == pytest.approx(5 * G, rel=EXACT)


# Piles


def pile(physics, seed, frames=24):
    """Bodies on a wide pad; its weight in N. Seeds below 100 start as a stack, put down askew;
    others fall and tumble."""
    rng = np.random.default_rng(seed)
    tumbling = seed >= 100
    physics.frames(frames)
    physics.pad(half=(3, 3, 0.05), at=(0, 0, -0.05), kind="PASSIVE", body={"friction": 0.8})
    total, top = 0.0, 0.0
    for number in range(int(rng.integers(2, 7))):
        half = rng.uniform(0.05, 0.15, 3)
        mass = float(10 ** rng.uniform(-1, 1))
        shapes = ["BOX", "CONVEX_HULL", "SPHERE", "CYLINDER"] if tumbling else ["BOX"]
        shape = str(rng.choice(shapes))
        middle = top + float(half[2] if not tumbling else half.max() + 0.05)
        at = (*rng.uniform(-0.05, 0.05, 2), middle)
        if shape in ("SPHERE", "CYLINDER"):
            obj = physics.round(shape, at, float(half[0]), float(half[1]))
        else:
            obj = physics.solid(f"thing {number}", half, at)
        obj.rotation_euler = rng.uniform(-1, 1, 3) * ((1, 1, 1) if tumbling else (0, 0, 1))
        physics.rigid_body(
            obj, shape=shape, mass=mass, friction=0.8, angular_damping=0.4, linear_damping=0.1
        )
        total += mass
        top = middle + float(half[2] if not tumbling else half.max())
    return total * G


def resting(physics, count=6):
    """Whether nothing moved by 0.1 mm a frame over the last frames of the scene."""
    bodies = [o for o in physics.scene.objects if o.rigid_body and o.rigid_body.type == "ACTIVE"]
    last = physics.scene.frame_end
    physics.scene.angen_live = False
    places = []
    for frame in range(last - count, last + 1):
        physics.scene.frame_set(frame)
        places.append([physics.place_of(body) for body in bodies])
    return np.abs(np.diff(places, axis=0)).max() < 1e-4


@pytest.mark.parametrize("seed", mostly_slow([*range(10), 101, 103], 0, 1, 103))
def test_random_piles(physics, seed):
    """No NaN, no spike, no pulling; at rest the sum is the weight within 0.5 %."""
    assert_pile(physics, seed)


def assert_pile(physics, seed, frames=24):
    weight = pile(physics, seed, frames)
    pad = physics.read()
    assert np.isfinite(pad.force).all() and np.isfinite(pad.residual).all()
    assert (pad.force >= 0).all()
    assert (pad.residual[pad.valid] <= 0.02).all()
    assert pad.valid.mean() > (0.2 if seed >= 100 else 0.7), pad.problems
    assert pad.force.max() < (20 if seed >= 100 else 4) * weight
    if resting(physics):
        late = pad.frames > frames - 4
        assert pad.valid[late].all(), pad.problems
        assert pad.force[late] == pytest.approx(weight, rel=5e-3)
