# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of pressure sensors: pads, the arrow of the force, panel rows, explanations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from bpy.types import Context

from ...sensor_logic.evidence import rows_of
from ...sensor_logic.kinds.pressure import FORCE, KIND, PressureParameters
from ...sensor_logic.logs.wording import METRES, NOTHING, Lengths, capital, quoted, split, typed
from ...sensor_logic.model import NOT_YET, Pose
from ..advice import sensing as advice
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation, more_needed
from ..appearance.figures import OFF_SURFACE, Figure, circle, pairs, triangles
from ..appearance.handles import SizeHandle
from ..appearance.housing import Housing, Point, lying, pad
from ..appearance.panel_parts import draw_lines, draw_row
from ..appearance.reading_text import ReadingText
from ..appearance.recorded import RecordedSensor
from ..explain.nearby import surroundings
from ..scene.lengths import UNITS, lengths_of
from ..scene.sensors import Sensor

# The fields of a reading that its arrow is drawn from.
FIELDS = ("force_n", "cop_x_m", "cop_y_m")
# Length of the arrow in m per newton, and its least and greatest length in m.
ARROW_PER_N, LEAST_ARROW, LONGEST_ARROW = 0.001, 0.06, 1.2


def figure(seen: Any, metres: float) -> Figure:
    """Draw the outline of the pad, without its force.

    `seen` is the `DrawnSensor`, and `metres` the length of a Blender unit in m.
    """
    drawn = Figure()
    if seen.outline is not None:
        corners = seen.outline
        drawn.add("pad", pairs(corners, np.roll(corners, -1, axis=0)))
        drawn.fill("pad", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return drawn


def force_figure(pose: Pose, metres: float, force: float, centre: tuple[float, float]) -> Figure:
    """Draw an arrow that presses on a pad, with a dot at the centre of pressure.

    Parameters
    ----------
    pose
        Pose of the pad, in m.
    metres
        Length of a Blender unit in m.
    force
        Force in N, which sets the length of the arrow.
    centre
        Centre of pressure (2,) along the pad's axes, in m.
    """
    drawn = Figure()
    x, y, z = pose.axes.T
    place = (pose.origin + x * centre[0] + y * centre[1] + z * OFF_SURFACE) / metres
    length = min(max(force * ARROW_PER_N, LEAST_ARROW), LONGEST_ARROW) / metres
    width = min(length / 3, 0.04 / metres)
    tail, neck = place + z * length, place + z * width * 1.6
    drawn.add("force", (tail, neck))
    for side in (x, y):
        drawn.fill("force", (place, neck - side * width * 0.6, neck + side * width * 0.6))
    dot = circle(place, x, y, 0.02 / metres)
    drawn.fill("force", triangles(np.broadcast_to(place, dot.shape), dot, np.roll(dot, 1, 0)))
    ring = circle(place, x, y, 0.035 / metres)
    drawn.add("force", pairs(ring, np.roll(ring, -1, axis=0)))
    return drawn


def force_of_reading(seen: Any, fields: Mapping[str, Any], metres: float) -> Figure | None:
    """Draw the arrow for a reading's force; return None if its centre of pressure is unknown.

    `seen` is the `DrawnSensor` of the pad, and `metres` the length of a Blender unit in m.
    """
    centre = fields["cop_x_m"], fields["cop_y_m"]
    if not all(math.isfinite(c) for c in centre):
        return None
    return force_figure(seen.pose, metres, fields["force_n"], centre)


# Housings. The default is a pad for seats and below furniture. The others have the sizes of their
# data sheets (FSR 400 series, FSR 402, FSR 406).


def _force_resistor(diameter: float, length: float, side: float = 0.0) -> Housing:
    """Return a force-sensing resistor, 0.45 mm thin, with a tail along −Y.

    The resistor is a disk of the `diameter`, or a square if `side` is not 0. Lengths are in m. The
    tail senses nothing, so it has lines and no surface. The width of the tail is an assumption.
    """
    thin, half = 0.00045, (diameter or side) / 2
    housing = pad(side, thin) if side else Housing().lathe([(half, 0.0), (half, thin)])
    end, w = half - length, min(half, 0.0032)
    tail: list[Point] = [(-w, -half, 0.0), (-w, end, 0.0), (w, end, 0.0), (w, -half, 0.0)]
    return housing.lines(tail, [(0, 1), (1, 2), (2, 3)])


def _fsr_402() -> Housing:
    return _force_resistor(0.01828, 0.056)


HOUSINGS = {
    "": lambda: pad(0.3, 0.01),
    # The thickness of these pads is an assumption.
    "SMART_CAREGIVER_CHAIR": lambda: pad(0.254, 0.01, 0.381),
    "SMART_CAREGIVER_MAT": lambda: pad(0.6096, 0.01, 1.2192),
    **dict.fromkeys(("FSR_402_IDEAL", "FSR_402", "FSR_402_3K3"), _fsr_402),
    **dict.fromkeys(("FSR_402_47K", "FSR_402_100K"), _fsr_402),
    "FSR_400": lambda: _force_resistor(0.0051, 0.038),
    "FSR_406": lambda: _force_resistor(0.0, 0.083, side=0.04369),
}


def centre_text(x: float, y: float, lengths: Lengths) -> str:
    """Return a centre of pressure as a text; `x` and `y` are in m along the pad's axes.

    If the scene's unit is metres, the text is in centimetres.
    """
    if math.isnan(x) or math.isnan(y):
        return NOTHING
    fine = UNITS["CENTIMETERS"] if lengths == METRES else lengths
    along = KIND.fields["cop_x_m"]
    return f"X {along.text(x, fine)}, Y {along.text(y, fine)}"


newtons = FORCE.text


@dataclass(frozen=True)
class PadCause:
    """The forces on a pad, which explain its reading.

    Attributes
    ----------
    partners
        The objects that press on the pad and their forces in N, in descending order.
    force
        The force of the reading, in N.
    own_weight
        The pad's own weight along its −Z axis, in N.
    threshold
        The force from which the pad counts as pressed, in N.
    centre
        The centre of pressure along the pad's axes, in m.
    problem
        A text on why the forces are uncertain; empty if they are certain.
    before
        The names of the objects that pressed on the pad at the previous update.
    """

    partners: tuple[tuple[Any, ...], ...]
    force: float
    own_weight: float
    threshold: float
    centre: tuple[float, float]
    problem: str
    before: tuple[str, ...]


def lacking(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: how much force is missing until the pad counts as pressed.

    If nothing presses on the pad, a second fact names the nearest object above it. `found` is the
    explanation of update `index`. Return it with the new facts before its other facts.
    """
    cause = found.cause
    if cause is None:
        return found
    facts = [("To be pressed", more_needed(cause.threshold, cause.force, "N"))]
    if not cause.partners:
        facts.append(
            ("Nearest above", _nearest_above(recorded, index) or "nothing is above the pad")
        )
    return found.after(facts)


def _nearest_above(recorded: RecordedSensor, index: int) -> str:
    """Return name and distance of the nearest object above a pad; empty if there is none."""
    found = surroundings(recorded, [index], include_sensor=True)[0].bounds
    name = recorded.sensor.object.name
    if name not in found:
        return ""
    low, high = found.pop(name)
    gaps = {
        n: float(b[0, 2] - high[2])
        for n, b in found.items()
        if (b[0, :2] < high[:2]).all() and (b[1, :2] > low[:2]).all() and b[0, 2] >= high[2]
    }
    if not gaps:
        return ""
    nearest = min(sorted(gaps), key=lambda n: gaps[n])
    return f"{quoted(nearest)}, by {recorded.lengths.text(gaps[nearest])}"


def explain_pad(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a pad by the objects that press on it."""
    track, kind = recorded.track, recorded.sensor.kind
    parameters: PressureParameters = recorded.parameters_at(index)
    fields = {name: column[index] for name, column in track.columns.items()}
    cause = PadCause(
        rows_of(recorded.evidence("shares", index)),
        track.value[index],
        recorded.evidence("own_weight_n", index),
        parameters.threshold,
        (fields["cop_x_m"], fields["cop_y_m"]),
        fields["problem"],
        tuple(split(track.columns["partners"][index - 1])) if index else (),
    )
    facts = _facts(cause, recorded.lengths)
    if index > 0:
        before = ", ".join([newtons(track.value[index - 1]), *cause.before])
        facts.append(("Before", f"{before}, at {recorded.when(index - 1)}"))
    headline = _headline(cause, kind.active_label, kind.idle_label)
    return recorded.explanation(index, headline, tuple(facts), cause.problem, cause)


def _facts(cause: PadCause, lengths: Lengths) -> list[tuple[str, str]]:
    facts = [(name, newtons(force)) for name, force in cause.partners]
    if cause.own_weight:
        facts.append(("Own weight", newtons(cause.own_weight)))
    facts.append(("Force", f"{newtons(cause.force)}, threshold {typed(cause.threshold, 'N')}"))
    if np.isfinite(cause.centre).all():
        facts.append(("Centre", f"{centre_text(*cause.centre, lengths)} from the pad's origin"))
    return facts


def _headline(cause: PadCause, pressed: str, free: str) -> str:
    by = " and ".join(f"{quoted(name)} with {force:.1f} N" for name, force in cause.partners[:3])
    if (more := len(cause.partners) - 3) > 0:
        by = f"{by} and {more} more"
    if cause.force > cause.threshold:
        return f"{pressed} by {by}" if by else f"{pressed}: {newtons(cause.force)}"
    if by:
        return f"{free}: {by} is not more than the threshold of {typed(cause.threshold, 'N')}"
    return capital(f"{free}: nothing presses on it")


# The sections of parameters in the panel.
SECTIONS = (
    (
        "Force and Partners",
        (
            "threshold",
            "report_step",
            "partner_object",
            "partner_collection",
            "subtract_own_weight",
            "noise_sigma",
        ),
    ),
    (
        "Resistor",
        (
            "resistor",
            "resistance_at_1n",
            "exponent",
            "force_min",
            "force_max",
            "unloaded_resistance",
            "area",
            "overall_area",
            "rim_force",
            "hysteresis",
            "drift",
            "part_spread",
            "repeatability",
        ),
    ),
    ("Electronics", ("load_resistor", "supply_voltage", "adc_bits")),
)


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw the reading in the panel, and warnings with buttons that help.

    `seen` has the texts of the sensor's reading.
    """
    pad, scene = sensor.object, context.scene
    problem = advice.without_surface(pad)
    if problem:
        draw_lines(layout, problem.text, "ERROR")
        return
    if seen.fields is not None:
        _draw_reading(layout, seen.fields, lengths_of(scene))
    outdated = None if seen.recorded else advice.outdated_cache(scene)
    if outdated:
        draw_lines(layout, outdated.text, "ERROR")
    elif seen.problem:
        not_yet = seen.problem == NOT_YET
        draw_lines(layout, _not_yet(seen) if not_yet else _not_valid(seen), seen.icon)
    sinks = advice.sinks(pad, scene)
    if sinks:
        box = draw_lines(layout, sinks.text, "ERROR")
        box.row().prop(pad.rigid_body, "type", expand=True)
    for found in (
        advice.weightless(pad, scene, context.view_layer),
        advice.hidden_partner(sensor, context.view_layer),
    ):
        if found:
            draw_lines(layout, found.text, "ERROR")
    short = advice.short_cache(scene)
    if short:
        box = draw_lines(layout, short.text, "ERROR")
        box.prop(scene.rigidbody_world.point_cache, "frame_end", text="Cache End")


MAKE_VALID = "Play the animation, or simulate, to get a valid reading"


def _not_yet(seen: ReadingText) -> str:
    text = f"Not yet sure: {seen.problem}. The force is computed as if all bodies were at rest"
    return text if seen.recorded else f"{text}. {MAKE_VALID}"


def _not_valid(seen: ReadingText) -> str:
    text = f"Not valid: {seen.problem}"
    if seen.fields is None:
        return text
    text = f"{text}. This is the last valid reading"
    return text if seen.recorded else f"{text}. {MAKE_VALID}"


def _draw_reading(layout: Any, fields: Mapping[str, Any], lengths: Lengths) -> None:
    """Draw a row for each field except the force, which the sensor's state already shows."""
    column = layout.column(align=True)
    of = KIND.fields
    # Below its threshold a pad counts as free, although a cushion may lie on it.
    label = "Pressed By" if fields["pressed"] else "On It"
    draw_row(column, label, ", ".join(split(fields["partners"])) or NOTHING)
    draw_row(column, "Centre", centre_text(fields["cop_x_m"], fields["cop_y_m"], lengths))
    draw_row(column, "Resistor", of["resistance_ohm"].text(fields["resistance_ohm"]))
    voltage = of["voltage_v"].text(fields["voltage_v"])
    draw_row(column, "Output", f"{voltage}, ADC {fields['adc']}")


APPEARANCE = Appearance(
    HOUSINGS,
    lying,
    figure=figure,
    reading_figure=force_of_reading,
    drawn_fields=FIELDS,
    handles=(SizeHandle(0), SizeHandle(1)),
    outlined=True,
    explain=explain_pad,
    lacking=lacking,
    sections=SECTIONS,
    details=draw,
)
