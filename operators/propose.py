# SPDX-License-Identifier: GPL-3.0-or-later
"""Propose places for motion detectors, and turn the proposals into sensors or remove them."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Context, Operator

from ..angen_addon.authoring.presets import new_sensor
from ..angen_addon.coverage import shown
from ..angen_addon.coverage.maps import MAPPED
from ..angen_addon.coverage.proposal import Proposal, Wish, propose
from ..angen_addon.coverage.settings import motion_of, room_names
from ..angen_addon.scene.instances import stands_for
from ..angen_addon.scene.sensors import Sensor, all_sensors, decimal, room_of
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.wording import plural
from ..sensor_logic.progress import Doing, Work
from .long_work import LongWork
from .polls import can_read_scene, cancelled, has_editable_collection, needs


def active_detector(context: Context) -> Sensor | None:
    """Return the active sensor; None if it is no motion detector."""
    active = stands_for(context.view_layer.objects.active)
    found = (s for s in all_sensors(context.view_layer) if s.handle == active)
    return next((s for s in found if s.kind in MAPPED), None)


class ANGEN_OT_place_propose(LongWork, Operator):
    bl_idname = "angen.place_propose"
    bl_label = "Propose Places"
    bl_description = (
        "Find the places on walls and ceilings from which motion detectors together cover most of "
        "the floor. They get the parameters of the active motion detector. Esc keeps the best "
        "places so far, or cancels if there are none yet"
    )
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(
        name="Preset",
        description="Identifier of a preset, in place of the active detector's parameters",
    )
    seed: IntProperty(
        name="Seed", description="Seed of the choice between equally good places", min=0
    )

    poll = classmethod(can_read_scene)

    def _show(self, context: Context, doing: Doing) -> None:
        self.esc = "Esc keeps the best places so far" if doing.found else "Esc cancels"
        super()._show(context, doing)

    def _begin(self, context: Context) -> Work[Proposal]:
        settings = context.scene.angen_coverage
        like = None if self.preset else active_detector(context)
        pattern = shown.pattern(like, self.preset)
        self._like = like.name if like else ""
        wish = Wish(
            settings.count,
            *pattern,
            room_names(settings.rooms),
            settings.mounting,
            decimal(settings.mounting_height),
            seed=self.seed,
            beside=settings.beside,
        )
        return propose(
            context.evaluated_depsgraph_get(),
            all_sensors(context.view_layer),
            wish,
            motion_of(settings.motion, settings.height),
            decimal(settings.cell),
        )

    def _finish(self, context: Context, result: Proposal) -> None:
        for ghost in shown.show_proposal(context.scene, result, self._like, self.preset):
            # Blender writes the names of unselected objects in black, also on dark walls.
            if ghost.name in context.view_layer.objects:
                ghost.select_set(True)
        self.report({"INFO"}, translated(result.summary()))


def _has_proposal(cls: Any, context: Context) -> bool:
    """Poll: whether the scene shows a proposal, which can be accepted or discarded."""
    is_there = shown.proposed(context.scene) or shown.is_of_proposal(context.scene)
    return needs(cls, is_there, "There is no proposal: Propose Places first") and can_read_scene(
        cls, context
    )


class ANGEN_OT_place_accept(Operator):
    bl_idname = "angen.place_accept"
    bl_label = "Accept"
    bl_description = "Turn the proposed places, or only the selected ones, into motion detectors"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_editable_collection(cls, context) and _has_proposal(cls, context)

    def execute(self, context: Context) -> set[str]:
        found = shown.proposed(context.scene)
        chosen = [ghost for ghost in found if ghost.select_get()] or found
        scene = context.scene
        try:
            made = [accept(context, ghost) for ghost in chosen]
        except AngenError as error:
            return cancelled(self, error)
        shown.accept_map(scene)
        shown.discard(scene)
        for sensor in made:
            sensor.select_set(True)
        self.report(
            {"INFO"}, translated(f"Placed {', '.join(sensor.name for sensor in made)}")[:200]
        )
        return {"FINISHED"}


def accept(context: Context, ghost: Any) -> Any:
    """Add a motion detector at the pose of `ghost`, the empty that marks a proposed position.

    Raise `AngenError` if the proposal's preset is unknown.
    """
    kind, preset = shown.preset_of(ghost.get(shown.PRESET, ""))
    like = context.scene.objects.get(ghost.get(shown.LIKE, ""))
    if like is not None:
        kind = KINDS.get(like.angen_sensor.kind, kind)
    room = room_of(ghost)
    name = f"{kind.short_label} {room}".strip()
    sensor = new_sensor(context, kind.identifier, preset, name)
    if like is not None and like.angen_sensor.kind == kind.identifier:
        shown.copy_settings(like.angen_sensor, sensor.angen_sensor)
    sensor.matrix_world = ghost.matrix_world
    sensor.angen_sensor.room = room
    return sensor


class ANGEN_OT_place_discard(Operator):
    bl_idname = "angen.place_discard"
    bl_label = "Discard"
    bl_description = "Remove the proposed places, and show the earlier coverage map again"
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(_has_proposal)

    def execute(self, context: Context) -> set[str]:
        count = shown.discard(context.scene)
        self.report({"INFO"}, translated(f"Discarded {plural(count, 'proposed place')}"))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_place_propose, ANGEN_OT_place_accept, ANGEN_OT_place_discard)
)
