# SPDX-License-Identifier: GPL-3.0-or-later
"""Find what is missing in the open file, without which readings would be wrong.

These are missing libraries and other files, drivers that fail, and sensors of unknown kinds.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import Any

import bpy

from ...sensor_logic.kind import LIGHT
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.logs.wording import named
from ..scene import memory
from ..scene.animation import all_animated
from ..scene.former_choices import stored_settings
from ..scene.sensors import all_sensors, simulated

FILES = {"FILE", "SEQUENCE", "MOVIE", "TILED"}
FIND = "put the file back, or show Blender where it is (File, External Data, Find Missing Files)"

# The problem, and the way to mend it.
Lack = tuple[str, str]

# What `look` found last: what the panels show.
found: list[str] = []


def lacking(view_layer: Any, light: bool) -> list[str]:
    """Return a sentence, with a remedy, for each missing file and each other thing that is missing.

    If `light` is True, include files that only light sensors need. Evaluate the scene before the
    call, because Blender disables drivers only then.
    """
    return [f"{what}: {mend}" for what, mend in lacks(view_layer, light)]


def lacks(view_layer: Any, light: bool) -> Iterator[Lack]:
    """Yield the problem and its remedy for each missing file and each other thing that is missing.

    If `light` is True, include files that only light sensors need.
    """
    yield from _unknown_kinds(view_layer)
    yield from _missing_libraries()
    yield from _missing_data()
    yield from _missing_files(
        "the cache file", bpy.data.cache_files, "the objects that it moves stand still"
    )
    yield from _missing_mesh_caches(view_layer)
    yield from _failing_drivers()
    if light:
        images = [i for i in bpy.data.images if i.source in FILES and not i.has_data]
        yield from _missing_files("the image", images, "light sensors see pink in its place")


def look(view_layer: Any) -> None:
    """Update `found`, the list of missing files and data that the panels show."""
    global found
    sensors = simulated(all_sensors(view_layer))
    if sensors:
        view_layer.update()
    found = lacking(view_layer, any(s.kind.requires(LIGHT) for s in sensors))


@memory.forgets_at_load
def forget() -> None:
    """Empty the list that the panels show."""
    global found
    found = []


def _unknown_kinds(view_layer: Any) -> Iterator[Lack]:
    known = {0, *(kind.number for kind in KINDS.values())}
    for obj in view_layer.objects:
        number = _stored_kind(obj) if obj is not None else 0
        if number not in known:
            yield (
                f"'{obj.name}' is a sensor of a kind that this version does not know "
                f"(number {number}) and is left out",
                "update the extension",
            )


def _stored_kind(obj: Any) -> int:
    """Return the kind's number as stored in the file, even for a kind unknown to the extension."""
    group = stored_settings(obj)
    return int(group.get("kind", 0)) if group is not None else 0


def _missing_libraries() -> Iterator[Lack]:
    for library in bpy.data.libraries:
        path = bpy.path.abspath(library.filepath, library=library.parent)
        inside = library.packed_file is not None or getattr(library, "is_archive", False)
        if not inside and not os.path.isfile(path):
            yield f"the linked library '{library.name}' is missing ({path})", FIND


def _missing_data() -> Iterator[Lack]:
    """Yield a problem for each library that exists but lacks datablocks which the file links."""
    lost: dict[str, list[str]] = {}
    for collection in (bpy.data.objects, bpy.data.collections, bpy.data.meshes, bpy.data.actions):
        for block in collection:
            library = block.library
            if block.is_missing and library is not None:
                path = bpy.path.abspath(library.filepath, library=library.parent)
                if os.path.isfile(path):
                    lost.setdefault(library.name, []).append(block.name)
    for name, blocks in lost.items():
        yield (
            f"the linked library '{name}' no longer contains {named(blocks)}",
            "add them to that file again, or delete what is linked from it here",
        )


def _missing_files(what: str, blocks: Iterable[Any], effect: str) -> Iterator[Lack]:
    for block in blocks:
        if getattr(block, "packed_file", None) is not None or block.users == 0:
            continue
        path = bpy.path.abspath(block.filepath, library=block.library)
        # The path of an image sequence, or of tiles, has a placeholder: no such file exists.
        if block.filepath and not os.path.exists(path) and "<" not in path:
            yield f"{what} '{block.name}' is missing ({path}), so {effect}", FIND


def _missing_mesh_caches(view_layer: Any) -> Iterator[Lack]:
    for obj in view_layer.objects:
        for modifier in obj.modifiers if obj is not None else ():
            if modifier.type == "MESH_CACHE" and modifier.show_viewport:
                path = bpy.path.abspath(modifier.filepath, library=obj.library)
                if modifier.filepath and not os.path.isfile(path):
                    text = f"the mesh cache of '{obj.name}' is missing ({path}), so it stands still"
                    yield (
                        text,
                        ("put the file back, or choose another one in the modifier Mesh Cache"),
                    )


def _failing_drivers() -> Iterator[Lack]:
    blocked: list[str] = []
    failed: list[str] = []
    for owner in all_animated():
        for curve in owner.animation_data.drivers:
            driver = curve.driver
            if not driver.is_valid and not curve.mute:
                python = driver.type == "SCRIPTED" and not driver.is_simple_expression
                where = blocked if python and bpy.app.autoexec_fail else failed
                where.append(f"{owner.name} ({curve.data_path})")
    if blocked:
        yield (
            f"Blender blocked Python drivers, so the objects that they move stand still: "
            f"{named(blocked)}",
            "if you trust the file, allow them with --enable-autoexec, or with Trusted Source "
            "where you open it",
        )
    if failed:
        text = f"drivers fail, so the objects that they move stand still: {named(failed)}"
        yield text, "correct or remove them"
