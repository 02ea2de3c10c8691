# SPDX-License-Identifier: GPL-3.0-or-later
"""The pad's reading: what it makes of the contact forces, of its weight, and of what it chose."""

import math
from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.sensor_logic.contact.world import PadForces, Partner
from angen_sensors.sensor_logic.kinds.pressure import PressurePad, PressureParameters, pad_reading
from angen_sensors.sensor_logic.model import PadContact, Pose

IDEAL = PressureParameters()
HERE = Pose(np.zeros(3), np.eye(3))
NOTHING = np.zeros(3)


def pushed(name, force, place=(0, 0, 0), uid=1):
    return Partner(name, frozenset({uid}), np.array([place], float), np.array([force], float))


def contact(*partners, weight=NOTHING, chosen=None, **forces):
    return PadContact(PadForces(tuple(partners), **forces), np.array(weight, float), chosen)


def read(parameters, *contacts):
    pad = PressurePad()
    return [pad.update(parameters, update_of(c)) for c in contacts]


def update_of(one, number=0, time=0.0):
    from angen_sensors.sensor_logic.kind import FORCES
    from angen_sensors.sensor_logic.model import Update
    from angen_sensors.sensor_logic.noise import generator

    noise = lambda: generator(0, "pad", number)  # noqa: E731
    return Update(number, time, HERE, {FORCES: lambda: one}, noise, noise)


def test_force_along_the_pads_own_normal():
    """Only what goes into the pad counts: not friction, not what holds it up."""
    found = pad_reading(IDEAL, HERE, contact(pushed("a", (3, 4, -10)), pushed("floor", (0, 0, 10))))
    assert found.force == pytest.approx(10.0)
    assert found.partners == "a"


def test_a_turned_pad():
    axes = np.array(((0, 0, 1.0), (0, 1, 0), (-1, 0, 0)))
    found = pad_reading(IDEAL, Pose(np.zeros(3), axes), contact(pushed("a", (-7, 0, -10))))
    assert found.force == pytest.approx(7.0)


def test_centre_of_pressure_is_in_the_pads_axes():
    pose = Pose(np.array((1.0, 2, 3)), np.array(((0, -1.0, 0), (1, 0, 0), (0, 0, 1))))
    two = (pushed("a", (0, 0, -30), (1.1, 2, 3)), pushed("b", (0, 0, -10), (1.3, 2, 3)))
    found = pad_reading(IDEAL, pose, contact(*two))
    # 0.15 along the world's x is −0.15 along the pad's y.
    assert found.centre == pytest.approx((0.0, -0.15), abs=1e-12)
    assert found.partners == "a;b"


def test_no_centre_where_nothing_presses():
    found = pad_reading(IDEAL, HERE, contact())
    assert found.force == 0.0 and found.partners == "" and all(map(math.isnan, found.centre))


def test_chosen_partners_alone():
    two = (pushed("a", (0, 0, -30), uid=1), pushed("b", (0, 0, -10), uid=2))
    found = pad_reading(IDEAL, HERE, contact(*two, chosen=frozenset({2})))
    assert (found.force, found.partners) == (10.0, "b")


def test_a_partner_of_next_to_nothing_is_not_named():
    two = (pushed("a", (0, 0, -30)), pushed("b", (0, 0, -0.01), uid=2))
    assert pad_reading(IDEAL, HERE, contact(*two)).partners == "a"


@pytest.mark.parametrize(("subtract", "force"), [(True, 30.0), (False, 35.0)])
def test_own_weight(subtract, force):
    parameters = replace(IDEAL, subtract_own_weight=subtract)
    found = pad_reading(
        parameters, HERE, contact(pushed("a", (0, 0, -30)), weight=(0, 0, -5), chosen=None)
    )
    assert found.force == pytest.approx(force)


@pytest.mark.parametrize(("subtract", "force"), [(True, 30.0), (False, 35.0)])
def test_what_holds_the_pad_up_as_the_partner(subtract, force):
    parameters = replace(IDEAL, subtract_own_weight=subtract)
    both = (pushed("a", (0, 0, -30), uid=1), pushed("floor", (0, 0, 35), uid=2))
    found = pad_reading(parameters, HERE, contact(*both, weight=(0, 0, -5), chosen=frozenset({2})))
    assert found.force == pytest.approx(force)
    assert found.partners == "floor"


# Known and unknown


def test_what_is_not_known_leaves_the_last_known_reading():
    known = contact(pushed("a", (0, 0, -30)))
    unknown = contact(problem="a reason", usable=False, residual=0.7)
    estimate = contact(pushed("b", (0, 0, -12)), problem="an estimate", usable=True)
    readings = read(IDEAL, known, unknown, estimate, known)
    assert [r.fields["force_n"] for r in readings] == [30, 30, 12, 30]
    assert [r.fields["valid"] for r in readings] == [True, False, False, True]
    assert [r.fields["problem"] for r in readings] == ["", "a reason", "an estimate", ""]
    assert [r.fields["partners"] for r in readings] == ["a", "a", "b", "a"]
    assert readings[1].fields["residual"] == 0.7


def test_unknown_from_the_start_is_nothing_and_not_valid():
    (reading,) = read(IDEAL, contact(problem="a reason", usable=False))
    assert reading.fields["force_n"] == 0.0 and not reading.fields["valid"]
    assert not reading.active


@pytest.mark.parametrize(("force", "pressed"), [(0.9, False), (1.0, False), (1.1, True)])
def test_pressed_above_the_threshold(force, pressed):
    (reading,) = read(IDEAL, contact(pushed("a", (0, 0, -force))))
    assert (reading.active, reading.fields["pressed"]) == (pressed, pressed)
    assert reading.value == pytest.approx(force)


def test_the_raw_force_goes_on_where_the_resistor_saturates():
    readings = read(IDEAL, *(contact(pushed("a", (0, 0, -f))) for f in (0.0, 5.0, 20.0, 700.0)))
    assert [r.fields["force_n"] for r in readings] == pytest.approx([0, 5, 20, 700])
    assert [r.fields["adc"] for r in readings][1:] == [854, 952, 952]
    assert readings[0].fields["resistance_ohm"] == IDEAL.unloaded_resistance
    volts = [r.fields["voltage_v"] for r in readings]
    assert volts == sorted(volts) and volts[-1] < IDEAL.supply_voltage


def test_noise_is_the_seeds(stage):
    parameters = replace(IDEAL, noise_sigma=0.5)
    contacts = 200 * [contact(pushed("a", (0, 0, -30)))]
    first = stage.press(PressurePad(), parameters, contacts)
    second = stage.press(PressurePad(), parameters, contacts)
    values = np.array([r.fields["force_n"] for r in first])
    assert values.tolist() == [r.fields["force_n"] for r in second]
    assert values.std() == pytest.approx(0.5, rel=0.2)
    assert values.mean() == pytest.approx(30.0, abs=0.15)
    stage.seed = 1
    other = stage.press(PressurePad(), parameters, contacts)
    assert not set(values) & {r.fields["force_n"] for r in other}


def test_contradictions_are_told():
    assert not IDEAL.problems()
    assert "force_min" in replace(IDEAL, force_min=30.0).problems()[0]
