# SPDX-License-Identifier: GPL-3.0-or-later
"""Water flow sensors and smart plugs in closed form, by when what they watch is used."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import USES
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.kinds.appliance import LOADS, ApplianceParameters, SmartPlug
from angen_sensors.sensor_logic.kinds.flow import FlowParameters, FlowSensor
from angen_sensors.sensor_logic.model import (
    Answers,
    ObjectUse,
    Pose,
    Readings,
    Updates,
    joined_readings,
)
from angen_sensors.sensor_logic.noise import generator

POSE = Pose(np.zeros(3), np.eye(3))


def sensed(model, parameters, uses, until, rate=1.0, steps=10, parts=1, name="Toilet"):
    """Return times (n,) and readings of a model that observes `steps` steps a second.

    `uses` has begin and end of each use in s. The updates come in so many `parts`. Without a name,
    the sensor watches nothing.
    """
    every = np.arange(round(until * steps) + 1)
    times = every / steps
    due = np.isclose(times * rate % 1.0, 0.0) | np.isclose(times * rate % 1.0, 1.0)
    used = np.zeros(len(times), np.intp)
    for begin, end in uses:
        used[(times >= begin - 1e-9) & (times < end - 1e-9)] = 1
    table = [ObjectUse(name, False), ObjectUse(name, True)] if name else [None, None]
    numbers = np.ceil(np.round(times * rate, 6)).astype(int)
    found = []
    for part in np.array_split(every, parts):
        scene = {USES: lambda *, indices=None, part=part: Answers(table, used[part])}
        updates = Updates(
            numbers[part],
            times[part],
            due[part],
            POSE,
            scene,
            lambda k: generator(1, "sensor", k),
            lambda: generator(1, "sensor, part", 0),
        )
        found.append(model.sense(parameters, updates))
    return times[due], joined_readings(found)


def spans(times, on):
    """Return begin and end of each time in which a reading is on."""
    changes = np.diff(np.concatenate([[False], on, [False]]).astype(int))
    ends = np.append(times, math.inf)
    return list(zip(ends[:-1][changes[:-1] == 1], ends[np.flatnonzero(changes == -1)], strict=True))


def same(one: Readings, two: Readings) -> bool:
    columns = [
        name for name in one.fields if not np.array_equal(one.fields[name], two.fields[name])
    ]
    return not columns and list(one.evidence["object"]) == list(two.evidence["object"])


@pytest.mark.parametrize(("volume", "rate"), [(6.0, 6.0), (4.5, 9.0), (9.0, 7.2)])
def test_a_cistern_fills_for_its_volume_by_the_flow_rate(volume, rate):
    parameters = FlowParameters(flows="AFTER_USE", refill_volume=volume, flow_rate=rate)
    times, found = sensed(FlowSensor(), parameters, [(10.0, 130.0)], 300.0, rate=10.0)
    ((begin, end),) = spans(times, found.active)
    assert begin == pytest.approx(130.0) and end - begin == pytest.approx(60.0 * volume / rate)
    # What has flown is the volume.
    assert np.sum(found.value) / 10.0 / 60.0 == pytest.approx(volume)
    assert set(found.evidence["object"]) == {"", "Toilet"}


def test_a_flush_while_the_cistern_fills_fills_it_anew():
    parameters = FlowParameters(flows="AFTER_USE")
    times, found = sensed(FlowSensor(), parameters, [(0.0, 10.0), (40.0, 50.0)], 200.0)
    assert spans(times, found.active) == [(10.0, 110.0)]


def test_a_tap_flows_while_it_is_used():
    times, found = sensed(FlowSensor(), FlowParameters(), [(3.0, 8.0), (12.0, 13.0)], 20.0)
    assert spans(times, found.active) == [(3.0, 8.0), (12.0, 13.0)]
    assert set(found.value) == {0.0, 6.0} and found.fields["flow_lpm"] is found.value


def test_the_output_follows_after_the_response_time():
    parameters = FlowParameters(response_time=1.5)
    times, found = sensed(FlowSensor(), parameters, [(3.0, 8.0), (12.0, 12.5)], 20.0, rate=10.0)
    begins_ends = [(4.5, 9.5), (13.5, 14.0)]
    assert np.allclose(spans(times, found.active), begins_ends)
    assert np.allclose(spans(times, found.value > 0.0), [(3.0, 8.0), (12.0, 12.5)])


def test_a_flow_below_the_minimum_is_measured_but_not_reported():
    _, found = sensed(FlowSensor(), FlowParameters(min_flow=6.5), [(3.0, 8.0)], 10.0)
    assert not found.active.any() and found.value.max() == 6.0


def test_a_use_between_two_updates_counts():
    """Sensed once in 5 s, a use of 0.3 s flushes all the same; the tap is missed."""
    times, flush = sensed(
        FlowSensor(), FlowParameters(flows="AFTER_USE"), [(1.0, 1.3)], 100.0, rate=0.2
    )
    assert spans(times, flush.active) == [(5.0, 65.0)]
    _, tap = sensed(FlowSensor(), FlowParameters(), [(1.0, 1.3)], 100.0, rate=0.2)
    assert not tap.active.any()


def test_what_is_in_use_at_the_start_has_been_for_long():
    parameters = FlowParameters(response_time=5.0)
    times, tap = sensed(FlowSensor(), parameters, [(0.0, 10.0)], 30.0)
    assert spans(times, tap.active) == [(0.0, 15.0)]
    times, flush = sensed(FlowSensor(), FlowParameters(flows="AFTER_USE"), [(0.0, 10.0)], 90.0)
    assert spans(times, flush.active) == [(10.0, 70.0)]


@pytest.mark.parametrize("model", [FlowSensor, SmartPlug])
def test_what_watches_nothing_reads_nothing(model):
    parameters = FlowParameters() if model is FlowSensor else ApplianceParameters()
    _, found = sensed(model(), parameters, [(0.0, 5.0)], 10.0, name="")
    assert not found.active.any() and not found.value.any()
    assert set(found.evidence["object"]) == {""}


PLUGS = [
    FlowParameters(flows="AFTER_USE", accuracy=0.1, noise_sigma=0.2, response_time=1.0),
    *(ApplianceParameters(load=name, accuracy=0.02, noise_sigma=1.0) for name in LOADS),
]


@pytest.mark.parametrize("parameters", PLUGS, ids=lambda p: getattr(p, "load", "flow"))
def test_parts_of_a_run_give_the_same_as_the_whole(parameters):
    make = FlowSensor if isinstance(parameters, FlowParameters) else SmartPlug
    uses = [(5.0, 9.0), (20.0, 80.3), (81.0, 81.2), (150.0, 300.0)]
    _, whole = sensed(make(), parameters, uses, 500.0)
    for parts in (7, 500):
        assert same(sensed(make(), parameters, uses, 500.0, parts=parts)[1], whole)


def test_a_device_keeps_its_error_within_its_accuracy():
    _, found = sensed(FlowSensor(), FlowParameters(accuracy=0.1), [(0.0, 60.0)], 50.0)
    assert len(set(found.value)) == 1 and 5.4 <= found.value[0] <= 6.6 != found.value[0]


def energy(parameters, uses, until):
    """Return the energy in J by the readings, ten in a second."""
    _, found = sensed(SmartPlug(), parameters, uses, until, rate=10.0)
    return float(np.sum(found.value[:-1])) / 10.0


def test_the_energy_of_a_washing_machine_is_that_of_its_phases():
    """It starts when the user leaves, and a look at it meanwhile changes nothing."""
    parameters = ApplianceParameters(load="WASHING_MACHINE")
    phases, standby = 900 * 2000 + 3600 * 150 + 600 * 400, 0.5
    found = energy(parameters, [(10.0, 50.0), (700.0, 720.0)], 6000.0)
    assert found == pytest.approx(phases + standby * (6000.0 - 5100.0), rel=1e-9)
    # The next use that ends after it starts it again.
    again = energy(parameters, [(10.0, 50.0), (5200.0, 5210.0)], 10_310.0)
    assert again == pytest.approx(2 * phases + standby * (10_310.0 - 10_200.0), rel=1e-9)


def test_a_load_works_as_its_kind_does():
    uses = [(10.0, 12.0), (40.0, 41.0), (200.0, 201.0)]

    def on(**given):
        times, found = sensed(SmartPlug(), ApplianceParameters(**given), uses, 400.0)
        return spans(times, found.active)

    assert on() == uses
    assert on(works="LINGERS", run_time=60.0) == [(10.0, 101.0), (200.0, 261.0)]
    assert on(works="PROGRAMME", run_time=60.0) == [(12.0, 72.0), (201.0, 261.0)]
    assert on(works="SWITCHED") == [(10.0, 40.0), (200.0, math.inf)]
    assert on(load="TELEVISION") == [(10.0, 40.0), (200.0, math.inf)]


def test_a_plug_reads_within_its_limits():
    parameters = ApplianceParameters(power=3000.0, standby_power=0.4, min_power=0.5, max_power=2500)
    _, found = sensed(SmartPlug(), parameters, [(3.0, 8.0)], 10.0)
    assert set(found.value) == {0.0, 2500.0}
    stepped = ApplianceParameters(power=60.04, resolution=0.1, standby_power=0.06)
    _, found = sensed(SmartPlug(), stepped, [(3.0, 8.0)], 10.0)
    assert np.allclose(sorted(set(found.value)), [0.1, 60.0])


def test_every_load_says_where_its_figures_are_from():
    for name, load in LOADS.items():
        assert "Assumed" in load.source or "Energy Use" in load.source, name
        if load.works == "PROGRAMME":
            assert sum(seconds for seconds, _ in load.phases) == load.runs, name
        assert load.standby < min(watts for _, watts in load.phases)
    # 1 L of water from 20 to 100 °C.
    kettle = LOADS["KETTLE"]
    assert 0.9 * kettle.runs * kettle.phases[0][1] == pytest.approx(4186.0 * 80.0, rel=0.01)


def test_presets_of_sensors_leave_what_is_used_as_it_is():
    for name, own in (("APPLIANCE", {"load", "power"}), ("FLOW", {"flow_rate", "flows"})):
        for preset in KINDS[name].presets:
            assert preset.identifier == "CISTERN_FLOAT" or not own & set(preset.values)
