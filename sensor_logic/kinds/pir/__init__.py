# SPDX-License-Identifier: GPL-3.0-or-later
"""Passive infrared motion detector (PIR), with one of two models.

- Models: range_scan.py, from the thesis, with the parameters of both models; pyroelectric.py, with
  the zones of lenses.py; presets.py.
- Scene: rays by angen_addon/scene/rays/caster.py; the temperature at their hits by `Warmth` in
  angen_addon/scene/surfaces/warmth.py.
- Window: angen_addon/kinds/pir/; coverage maps: coverage.py.
- Physics: docs/pir.md, docs/coverage.md.
- Tests: tests/pure/test_pir.py and test_pyro_*.py, tests/blender/test_pyro_scenes.py.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ...evidence import Cause
from ...kind import RAYS, WARMTH, Field, Kind
from ...logs.wording import OF_THRESHOLD
from ...model import Model, Readings, Updates
from .coverage import view
from .presets import PRESETS
from .pyroelectric import PyroelectricDetector
from .range_scan import PYRO, SCAN, PirParameters, RangeScan
from .scan_evidence import FIELDS as SCAN_FIELDS
from .scan_evidence import cause_of_scan
from .warm_evidence import FIELDS as WARM_FIELDS
from .warm_evidence import cause_of_warmth

EVIDENCE = (*SCAN_FIELDS, *WARM_FIELDS)


class MotionDetector(Model):
    """Model of one motion detector.

    The parameter `model` selects the range scan or the pyroelectric model. The state is reset if
    that parameter changes.
    """

    def __init__(self) -> None:
        self._model = ""
        self._sensing: RangeScan | PyroelectricDetector

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        """Return the readings of the selected model."""
        if parameters.model != self._model:
            self._model = parameters.model
            pyroelectric = parameters.model == "PYROELECTRIC"
            self._sensing = PyroelectricDetector() if pyroelectric else RangeScan()
        readings = self._sensing.sense(parameters, updates)
        evidence = {field.name: readings.evidence.get(field.name) for field in EVIDENCE}
        return replace(readings, evidence=evidence)


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track` by the detector's model."""
    is_scan = track.parameters_at(index).model == "RANGE_SCAN"
    return cause_of_scan(track, index) if is_scan else cause_of_warmth(track, index)


KIND = Kind(
    "PIR",
    1,
    "Motion detector (PIR)",
    "Passive infrared motion detector",
    "LIGHT_AREA",
    "pir",
    10.0,
    "Motion",
    "Still",
    PirParameters,
    events=(Field("moved", bool, quantity="motion", tip="Whether it reports movement"),),
    samples=(
        Field(
            "angle_rad",
            float,
            "rad",
            0,
            tip="Tilt of the fan below the horizon at this update",
            word="tilt",
            **SCAN,
        ),
        Field("moved", bool),
        Field(
            "signal",
            float,
            OF_THRESHOLD,
            0,
            optional=True,
            tip="Signal of the elements, relative to the threshold",
            **PYRO,
        ),
    ),
    evidence=EVIDENCE,
    cause=cause,
    model=MotionDetector,
    needs={RAYS: SCAN["used_when"], WARMTH: PYRO["used_when"]},
    # At a lower rate the signal of a walker is more than 5 % too low.
    signal_rate=20.0,
    in_room=True,
    presets=PRESETS,
    part="MI_NODE_SCAN",
    view=view,
)
