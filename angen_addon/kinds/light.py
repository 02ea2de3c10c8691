# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of light sensors: housing, figures, panel rows and explanations.

A sensor with four views shows these views in the viewport. An illuminance sensor shows a lobe. An
explanation lists the light of each lamp, and names the lamp whose light changed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from bpy.types import Context

from ...sensor_logic.kinds.light import given, most_changed, shares_at
from ...sensor_logic.logs.fields import Field
from ...sensor_logic.logs.wording import capital, listed, named, percent, quoted
from ...sensor_logic.model import LightShare, Pose
from ...sensor_logic.parameters import specs
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation, Facts, more_needed
from ..appearance.figures import ROUND, Figure, circle, dashes, ends_of, pairs
from ..appearance.handles import ahead, edge
from ..appearance.housing import Housing, looking
from ..appearance.panel_parts import draw_lines
from ..appearance.reading_text import ReadingText
from ..appearance.recorded import RecordedSensor
from ..runtime.sensor_runner import light_request
from ..runtime.trace import CastRays, SensorRays, Trace
from ..scene.light.views import view_rays
from ..scene.sensors import Sensor

# An explanation lists at most this many lamps by name.
SHOWN = 6
# Lamps that give a smaller fraction of all light get no line.
LITTLE = 1e-3


@dataclass(frozen=True)
class LightCause:
    """How much light came from each lamp, in the unit of `field`.

    Attributes
    ----------
    now
        The light of each lamp at this update. It is empty if the render engine cannot separate
        lamps.
    changed
        The light of the source that changed most, at the update before and at this one; None if no
        light changed notably.
    field
        The field of the reading, such as the illuminance.
    """

    now: tuple[LightShare, ...]
    changed: tuple[LightShare, LightShare] | None
    field: Field

    @property
    def given(self) -> float:
        """The total light of all lamps except negative lamps, which take light away."""
        return max(given(self.now), 1e-9)


def lacking(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: how much more light would switch the output on.

    `found` is the explanation of update `index`. Return it with the fact before its other facts.
    """
    if found.cause is None:
        return found
    light = recorded.parameters_at(index)
    level = light.threshold + light.hysteresis / 2
    value, unit = recorded.track.value[index], recorded.sensor.kind.reading(light).unit
    return found.after([("To be lit", more_needed(level, value, unit))])


def explain_light(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a light sensor by the light of each lamp."""
    track, kind, parameters = recorded.track, recorded.sensor.kind, recorded.parameters_at(index)
    field = kind.reading(parameters)
    cause = LightCause(shares_at(track, index), most_changed(track, index), field)
    engines = specs(kind.parameters)["engine"].choices
    engine = next(c.label for c in engines if c.identifier == parameters.engine)
    facts = [("Reading", f"{field.text(track.value[index])} ({engine})")]
    if index > 0:
        earlier = field.text(track.value[index - 1])
        facts.append(("Before", f"{earlier}, at {recorded.when(index - 1)}"))
    facts += _share_facts(cause)
    note = recorded.evidence("note", index)
    if note:
        facts.append(("Note", note))
    headline = f"{recorded.word(index)}: {_headline(cause)}"
    return recorded.explanation(index, headline, tuple(facts), "", cause)


def _share_facts(cause: LightCause) -> Facts:
    """Return a fact for each notable light source, and one for the sum of all light."""
    if not cause.now:
        return []
    text, whole = cause.field.text, cause.given
    ordered = sorted(cause.now, key=lambda share: -share.light)
    giving = [share for share in ordered if share.light > LITTLE * whole]
    facts = [(_label(s), _part(text(s.light), s.light / whole)) for s in giving[:SHOWN]]
    if len(giving) > SHOWN:
        left = sum(share.light for share in giving[SHOWN:])
        facts.append((f"{len(giving) - SHOWN} more", _part(text(left), left / whole)))
    taking = [share for share in ordered[::-1] if share.light < -LITTLE * whole]
    for share in taking[:SHOWN]:
        facts.append(
            (_label(share), f"takes away {_part(text(-share.light), share.light / whole)}")
        )
    return [*facts, ("All light", text(sum(share.light for share in cause.now)))]


def _part(text: str, share: float) -> str:
    return f"{text}, {percent(share)} of all"


def _headline(cause: LightCause) -> str:
    if not cause.now:
        return "EEVEE cannot tell lamps apart: set Engine to Cycles"
    changed, text = cause.changed, cause.field.text
    if changed is not None:
        then, now = changed
        return f"{_quoted(now)} changed from {text(then.light)} to {text(now.light)}"
    most = max(cause.now, key=lambda share: share.light)
    least = min(cause.now, key=lambda share: share.light)
    if least.light < 0.0 and sum(s.light for s in cause.now) <= LITTLE * cause.given:
        return f"{_quoted(least)} takes the light away"
    if most.light <= 0.0:
        return "no light reaches it"
    return f"{_quoted(most)} gives {percent(most.light / cause.given)} of the light"


def _label(share: LightShare) -> str:
    return listed([*share.names], 2) if share.names else share.source


def _quoted(share: LightShare) -> str:
    return named(share.names, 2) if share.names else quoted(share.source)


# m. Length of the lobe that is drawn before an illuminance sensor.
LOBE = 0.25


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """Return the rays for the floor plan; for a sensor with four views, the axes of the views.

    `sight` is the `Trace` with the sensor's rays, parameters and pose. `metres` is the length of a
    Blender unit in m.
    """
    if sight.parameters.method != "FOUR_WALL":
        return sight.rays(metres)
    request = light_request(sight.sensor, sight.parameters, sight.pose, metres, False)
    origins, directions, reach = (part[:, 0] for part in view_rays(request))
    return SensorRays(origins, directions, reach, apart=True)


def figure(seen: Any, metres: float) -> Figure:
    """Draw the lobe of an illuminance sensor; draw nothing for a sensor with four views.

    The lobe shows the weight of the light from each direction: the cosine of its angle to the
    face's normal. `seen` is the `DrawnSensor`, and `metres` the length of a Blender unit in m.
    """
    if seen.parameters.method == "FOUR_WALL":
        return Figure()
    return _lobe(seen.pose, metres)


def view_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Draw the axis of a view, and the rectangle of its picture at the far end.

    `seen` is the `DrawnSensor`, and `number` the number of the view. `cast` has its rays: first the
    axis, then the four corners. `metres` is the length of a Blender unit in m.
    """
    drawn = Figure()
    (start,), (end,), _ = ends_of(cast, metres)
    drawn.add("dark", dashes(seen.pose.origin / metres, start[0]))
    drawn.add("axis", (start[0], end[0]))
    corners, feet = end[1:], start[1:]
    drawn.add("edge", pairs(feet, corners))
    drawn.add("picture", pairs(corners, np.roll(corners, -1, axis=0)))
    drawn.fill("picture", (corners[[0, 1, 2]], corners[[0, 2, 3]]))
    return drawn


def _lobe(pose: Pose, metres: float) -> Figure:
    drawn = Figure()
    angles = np.linspace(-math.pi / 2, math.pi / 2, ROUND + 1)
    for side in (0, 1):
        directions = np.outer(np.sin(angles), pose.axes[:, side]) - np.outer(
            np.cos(angles), pose.axes[:, 2]
        )
        curve = (pose.origin + directions * np.cos(angles)[:, None] * LOBE) / metres
        drawn.add("axis", pairs(curve[:-1], curve[1:]))
    ring = circle(pose.origin / metres, pose.axes[:, 0], pose.axes[:, 1], LOBE / 4 / metres)
    drawn.add("edge", pairs(ring, np.roll(ring, -1, axis=0)))
    return drawn


def _photoresistor() -> Housing:
    """Return a photoresistor GL55: a disk of 5 mm.

    The diameter is from ednieuw.home.xs4all.nl, "GL55xx LDRs". The thickness of 2 mm is an
    assumption.
    """
    return looking(Housing().lathe([(0.0025, 0.0), (0.0025, 0.002)]))


HOUSINGS = {"": _photoresistor}


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw the note of the reading in the panel, such as that a view is narrower than set.

    `seen` has the texts of the sensor's reading.
    """
    note = seen.fields.get("note", "") if seen.fields is not None else ""
    if note:
        draw_lines(layout, capital(note), "INFO")


APPEARANCE = Appearance(
    HOUSINGS,
    plan_rays=plan_rays,
    figure=figure,
    rays_figure=view_figure,
    handles=(ahead("clip_end"), edge("field_of_view", (1.0, 0.0), 0.5, "clip_end")),
    explain=explain_light,
    lacking=lacking,
    details=draw,
)
