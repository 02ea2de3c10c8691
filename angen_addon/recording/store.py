# SPDX-License-Identifier: GPL-3.0-or-later
"""Storage of recordings in blend files, as text datablocks that exist only in the file on disk.

A recording's text is added just before Blender saves a file, and removed after Blender has saved or
loaded it. So neither undo steps nor the evaluated copy of the scene hold recordings. Blender
without the extension does not list the text, since its name begins with a dot.
"""

from __future__ import annotations

import base64
import sys
from collections.abc import Mapping
from typing import Any

import bpy

from ...sensor_logic.logs.error import AngenError, replaced
from ...sensor_logic.recording.file import VALUES, from_bytes, size_of, to_bytes
from ..scene.sensors import Sensor, all_sensors
from .fingerprint import Fingerprint
from .results import RESULTS
from .stored_recording import StoredRecording

# The name of the texts; its leading dot hides them from lists.
TEXT = ".angen_recording"
# Custom properties of a text: the scene of its recording, why the recording is stale, and whether
# it is put away while the scene shows another time.
SCENE, STALE, ASIDE = "angen_scene", "angen_stale", "angen_aside"
TITLE = "A recording of the Blender extension Ängen Sensors; Clear Recording there removes it"
LINE = 4096


def put_into_file() -> None:
    """Add the recordings of all scenes to the file as texts, before it is saved.

    A recording is encoded only once, even if the file is saved several times.
    """
    # The file may hold recordings, if the extension was switched on after it was opened.
    restore()
    for scene in bpy.data.scenes:
        _put(scene, RESULTS.kept(scene), False)
        _put(scene, RESULTS.kept_aside(scene), True)


def _put(scene: Any, kept: StoredRecording | None, is_aside: bool) -> None:
    if kept is None:
        return
    try:
        kept.stored = kept.stored or _encoded(kept, scene)
    except AngenError as error:
        report(f"The recording was not saved with the file: {error}. Export it")
        return
    text = bpy.data.texts.new(TEXT)
    text.use_fake_user = True
    text[SCENE], text[ASIDE] = scene, is_aside
    text[STALE] = kept.stale_then if is_aside else kept.stale
    text.from_string(kept.stored)


def take_out_of_file() -> None:
    """Remove the texts with recordings again, once the file is saved."""
    for text in _texts():
        bpy.data.texts.remove(text)


def restore() -> None:
    """Read the recordings of a file that was just opened, and remove their texts.

    Report each recording that cannot be read.
    """
    values_left = VALUES
    for text in _texts():
        scene = text.get(SCENE)
        # A scene has one recording of each sort: a second text is not decoded.
        is_aside = bool(text.get(ASIDE))
        known = RESULTS.kept_aside if is_aside else RESULTS.kept
        if isinstance(scene, bpy.types.Scene) and known(scene) is None:
            try:
                kept, names = _decoded(text.as_string(), values_left)
                find_sensors(kept, scene, names)
            except AngenError as error:
                report(f"The recording in this file could not be read: {error}. Simulate again")
            else:
                kept.stale_then = str(text.get(STALE, ""))
                values_left -= size_of(kept.recording)
                RESULTS.keep_from_file(scene, kept, is_aside)
        bpy.data.texts.remove(text)


def report(text: str) -> None:
    """Show a notice on the file in the sidebar, and print it on standard error."""
    RESULTS.add_notice(text)
    if sys.stderr is not None:
        print(f"Ängen Sensors: {text}", file=sys.stderr)


def find_sensors(kept: StoredRecording, scene: Any, names: Mapping[str, str]) -> None:
    """Set the session uid in each track of the recording `kept` to its sensor's present one.

    Also set `kept.names` by the present session uids. `names` are the names at the run of all
    sensors, by their names when the file was saved. A sensor is found by name, or by its name at
    the run if only its name has changed since. Blender gives objects new session uids each time a
    file is opened.
    """
    tracks, sensors = kept.recording.tracks, _sensors_of(kept, scene)
    names = {**{name: name for name in tracks}, **names}
    known = {sensor.name: sensor for sensor in sensors}
    others = [sensor for sensor in sensors if sensor.name not in names]
    for name, then in names.items():
        found = known.get(name) or next((s for s in others if kept.was_called(s, then)), None)
        if found is not None:
            kept.names[found.uid] = then
        if name in tracks:
            tracks[name].uid = found.uid if found is not None else 0


def _sensors_of(kept: StoredRecording, scene: Any) -> list[Sensor]:
    layers = scene.view_layers
    return all_sensors(layers.get(kept.fingerprint.view_layer) or layers[0])


def _texts() -> list[Any]:
    """Return the texts of this file that hold recordings, but no texts of linked libraries."""
    return [
        text
        for text in bpy.data.texts
        if text.name.startswith(TEXT) and text.library is None and SCENE in text
    ]


def _encoded(kept: StoredRecording, scene: Any) -> str:
    made, sensors = kept.fingerprint, _sensors_of(kept, scene)
    header = {
        "facts": kept.facts,
        "blender": kept.blender,
        "made_in": kept.made_in,
        "view_layer": made.view_layer,
        "light": made.light,
        "digests": made.digests,
        "names": {s.name: kept.names[s.uid] for s in sensors if s.uid in kept.names},
    }
    data = base64.b64encode(to_bytes(kept.recording, header)).decode()
    lines = [data[i : i + LINE] for i in range(0, len(data), LINE)]
    return "\n".join([TITLE, *lines])


def _decoded(text: str, most_values: int) -> tuple[StoredRecording, dict[str, str]]:
    """Return the recording in a text, and the names of sensors at the run, by name when saved.

    Raise AngenError if the text is damaged or has too many values.
    """
    title, _, data = text.partition("\n")
    if title != TITLE:
        raise AngenError("it is damaged")
    with replaced("it is damaged", ValueError, raised=AngenError):
        packed = base64.b64decode(data.replace("\n", ""), validate=True)
    recording, header = from_bytes(packed, most_values)
    if not _is_header(header):
        raise AngenError("it is damaged")
    made = Fingerprint(header["view_layer"], header["light"], header["digests"])
    kept = StoredRecording(recording, made, tuple(header["blender"]))
    kept.made_in = tuple(header.get("made_in", kept.blender))
    kept.facts = header.get("facts", 1)
    kept.stored = text
    kept.unsure = True
    return kept, header.get("names", {})


def _is_header(header: dict[str, Any]) -> bool:
    """Return whether a header has the entries and the types that `_encoded` writes."""
    numbers = [header.get("facts", 1)]
    versions: list[Any] = [header.get("blender"), header.get("made_in", []), numbers]
    texts: list[Any] = [header.get("digests"), header.get("names", {})]
    return (
        isinstance(header.get("view_layer"), str)
        and isinstance(header.get("light"), bool)
        and all(isinstance(version, list) for version in versions)
        and all(isinstance(number, int) for version in versions for number in version)
        and all(isinstance(digests, dict) for digests in texts)
        and all(isinstance(digest, str) for digests in texts for digest in digests.values())
    )
