# SPDX-License-Identifier: GPL-3.0-or-later
"""Proposed detectors in the scene: empties, which no sensor sees, until they are accepted."""

from __future__ import annotations

from typing import Any

import bpy
from mathutils import Matrix

from ...sensor_logic.coverage.detectors import DETECTOR, PirParameters
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Pose
from ...sensor_logic.parameters import specs
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, decimal, read_parameters, unit_scale
from .mesh import collection, remove_own_collection
from .proposal import Proposal

PROPOSAL = "PROPOSAL"
# m: as large as an empty is drawn.
SHOWN_M = 0.25
LIKE, PRESET = "angen_like", "angen_preset"


def show(scene: Any, proposal: Proposal, like: str = "", preset: str = "") -> list[Any]:
    """Empties at the proposed poses, in place of those of an earlier proposal; `like` is the
    sensor, `preset` the preset, whose parameters they get when accepted."""
    discard(scene)
    made = []
    for candidate, name in zip(proposal.chosen, proposal.names, strict=True):
        ghost = bpy.data.objects.new(name, None)
        ghost.empty_display_type = "CONE"
        ghost.empty_display_size = SHOWN_M / unit_scale(scene)
        ghost.matrix_world = matrix_of(candidate.pose, unit_scale(scene))
        ghost.show_name = True
        ghost[COVERAGE_MARK] = PROPOSAL
        ghost.angen_sensor.room = candidate.room
        ghost[LIKE], ghost[PRESET] = like, preset
        collection(scene).objects.link(ghost)
        made.append(ghost)
    return made


def proposed(scene: Any) -> list[Any]:
    """The empties of a proposal, by name."""
    found = [obj for obj in scene.objects if obj.get(COVERAGE_MARK) == PROPOSAL]
    return sorted(found, key=lambda obj: obj.name)


def discard(scene: Any) -> int:
    """Takes a proposal out of the scene; of how many detectors it was."""
    found = proposed(scene)
    for ghost in found:
        bpy.data.objects.remove(ghost)
    remove_own_collection(scene)
    return len(found)


def matrix_of(pose: Pose, metres: float) -> Matrix:
    matrix = Matrix([[*row, 0.0] for row in pose.axes.tolist()] + [[0.0, 0.0, 0.0, 1.0]])
    matrix.translation = (pose.origin / metres).tolist()
    return matrix


def pattern(sensor: Sensor | None, preset: str) -> tuple[PirParameters, float]:
    """Parameters and update rate (Hz) of detectors to place: those of a sensor, or of a preset, or
    the defaults. Raises AngenError."""
    if sensor is not None:
        parameters = read_parameters(sensor, sensor.settings)
        if not isinstance(parameters, PirParameters):
            raise AngenError(f"'{sensor.name}' is no motion detector (PIR)")
        return parameters, decimal(sensor.settings.update_rate)
    rate = DETECTOR.update_rate
    if not preset:
        return PirParameters(), rate
    known = {p.identifier: p for p in DETECTOR.presets}
    if preset not in known:
        raise AngenError(f"no preset is called '{preset}': there are {', '.join(known)}")
    return PirParameters(**known[preset].values), rate


def copy_settings(source: Any, target: Any) -> None:
    """Gives a sensor the parameters and the update rate of another one."""
    target.update_rate = source.update_rate
    old, new = (getattr(owner, DETECTOR.attribute) for owner in (source, target))
    for name in specs(DETECTOR.parameters):
        setattr(new, name, getattr(old, name))
