# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out whether the list of a read day is stale: the settings or the home have changed."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import bpy

from ...angen_addon.recording.fingerprint import Fingerprint, digest, key_of
from ...angen_addon.recording.followed_map import FollowedResult
from ...angen_addon.recording.results import FOLLOWED, RESULTS
from ...angen_addon.relative_path import absolute
from ...angen_addon.scene.facts import part_facts
from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.files import read_text
from ...sensor_logic.logs.wording import listed

# Settings of the panel on which the list depends, apart from the routine.
SETTINGS = ("date", "number", "seed")


class FollowedDay(FollowedResult):
    """The fingerprint of the home for which a day was read.

    While an activity of the day is shown, it is the fingerprint of the home as it is shown.
    """

    @staticmethod
    def stored_text(scene: Any) -> str:
        return str(scene.angen_day.followed)

    @staticmethod
    def store_text(scene: Any, text: str) -> None:
        scene.angen_day.followed = text

    @staticmethod
    def depends_on(sensor: Any) -> bool:
        return False

    def _fingerprint_now(self, scene: Any, depsgraph: Any) -> Fingerprint:
        made = super()._fingerprint_now(scene, depsgraph)
        layer = scene.view_layers[depsgraph.view_layer.name]
        for obj in layer.objects:
            if key_of(obj) in made.digests:
                made.digests |= _mark_of(obj)
        return made

    def check(self, original: Any) -> None:
        super().check(original)
        if isinstance(original, bpy.types.Object):
            known = self.fingerprint.digests
            self._compare({k: d for k, d in _mark_of(original).items() if k in known})


def _mark_of(obj: Any) -> dict[str, str]:
    """Return the digest of an object's settings as a place of residents, by a fingerprint's key.

    The digest of the object leaves these settings out, because no sensor notices them.
    """
    return {f"Place {obj.name_full}": digest(part_facts(obj, obj.angen_place))}


def note_read(scene: Any) -> None:
    """Remember that the day was read with the present settings, in the home as it is now."""
    scene.angen_day.read_with = json.dumps(_settings_of(scene))
    note_home(scene)


def note_home(scene: Any) -> None:
    """Remember the home as it is now; later edits make the list of the day stale."""
    RESULTS.note_result(scene, bpy.context.evaluated_depsgraph_get(), FollowedDay)


def why_stale(scene: Any) -> str:
    """Return why the list no longer matches settings and home, in a few words; empty if it does."""
    day = scene.angen_day
    if not day.done:
        return ""
    followed = RESULTS.result(scene, FollowedDay)
    if not day.read_with or followed is None:
        return "it was read by an earlier version of Ängen Sensors"
    was, now = json.loads(day.read_with), _settings_of(scene)
    changed = [day.bl_rna.properties[name].name for name in now if now[name] != was.get(name)]
    return f"changed since: {listed(changed, 3)}" if changed else followed.stale


def verify(scene: Any) -> None:
    """Compare the whole home with the home of the list, because Blender does not tell all edits."""
    followed = RESULTS.result(scene, FollowedDay)
    if followed is not None:
        followed.verify(scene, bpy.context.evaluated_depsgraph_get())


def _settings_of(scene: Any) -> dict[str, Any]:
    """Return the settings on which the list depends, by the names of the properties."""
    day = scene.angen_day
    return {"routine": _routine(day), **{name: getattr(day, name) for name in SETTINGS}}


def _routine(day: Any) -> str:
    """Return a digest of the routine's text; empty if it cannot be read."""
    if day.text is not None:
        return _digest_of_text(day.text.as_string())
    path = absolute(day.routine)
    try:
        found = path.stat()
        return _digest_of_file(path, found.st_mtime_ns, found.st_size)
    except (OSError, InputError):
        return ""


# Keeps the digests of the last routines, for all buttons of the panel at each redraw.
# Without it, `why_stale` takes 39 µs instead of 22 µs.
@lru_cache(maxsize=4)
def _digest_of_text(text: str) -> str:
    return digest(text)


# Keeps the digests of the last files, as long as these are unchanged.
# Each redraw reads the file some 30 times without it.
@lru_cache(maxsize=4)
def _digest_of_file(path: Path, _changed: int, _size: int) -> str:
    return digest(read_text(path))


FOLLOWED.append(FollowedDay)
