# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of the documentation: of panels, and of the setting or button under the mouse (F1)."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any

import bpy

from ...sensor_logic.kinds import KINDS
from ..process.version import manifest

# The page of each kind by its attribute, and of each group of settings by its property. Others are
# in the page of the window, or, for kinds, in the tables of parameters.
WINDOW, PARAMETERS = "window", "parameters"
KIND_PAGES = {
    "optical_switch": "switch",
    **{name: name for name in ("pir", "pressure", "light", "distance", "contact")},
    **{name: name for name in ("thermal_array", "presence_radar", "appliance", "flow")},
}
GROUP_PAGES = {
    "angen_breathing": "presence_radar",
    "angen_coverage": "coverage",
    "angen_day": "residents",
    "angen_heat": "pir",
    "angen_load": "pressure",
    "angen_place": "residents",
    "angen_radar": "presence_radar",
    "angen_resident": "residents",
    "angen_site": "residents",
    "angen_study": "studies",
    "angen_topic": "home_assistant",
    "angen_use": "appliance",
    "angen_warmth": "pir",
}
# The pages of operators whose names match; the first match counts.
OPERATOR_PAGES = (
    ("place_propose", "coverage"),
    ("place_accept", "coverage"),
    ("place_discard", "coverage"),
    ("place*", "residents"),
    ("day*", "residents"),
    ("resident*", "residents"),
    ("walking*", "residents"),
    ("study*", "studies"),
    ("mqtt*", "home_assistant"),
    ("*layout", "layouts"),
    ("export_format", "formats"),
    ("*coverage*", "coverage"),
    ("doctor*", "your_own_home"),
    ("*", WINDOW),
)
OWNERS = ("Object", "Scene", "Material", "Collection", "WindowManager", "Bone")


# Each drawing of a panel's header costs a millisecond more without this cache.
@functools.cache
def site() -> str:
    """Return the address of the documentation, which the manifest names; it ends with "/"."""
    return str(manifest()["website"])


def page_address(page: str) -> str:
    """Return the address of a page, such as "pir"."""
    return f"{site()}{page}.html"


def draw_help(layout: Any, page: str) -> None:
    """Draw a button that opens a page of the documentation."""
    layout.operator("wm.url_open", text="", icon="HELP", emboss=False).url = page_address(page)


def manual_map() -> tuple[str, list[tuple[str, str]]]:
    """Return the address of the documentation, and the page of each of the extension's names.

    The pages are pairs of a pattern, such as `bpy.ops.angen.add*`, and a page relative to the
    address, as `bpy.utils.register_manual_map` takes them.
    """
    rows = [(f"bpy.ops.angen.{name}", page) for name, page in OPERATOR_PAGES]
    rows += [("bpy.types.angenpreferences.*", "home_assistant")]
    rows += [(f"bpy.types.{name.lower()}", page) for name, page in _properties()]
    return site(), [(pattern, f"{page}.html") for pattern, page in rows]


def _properties() -> Iterator[tuple[str, str]]:
    """Yield patterns of the extension's properties, each with its page."""
    for owner in OWNERS:
        for found in getattr(bpy.types, owner).bl_rna.properties:
            if found.identifier.startswith("angen_"):
                page = GROUP_PAGES.get(found.identifier, WINDOW)
                yield f"{owner}.{found.identifier}", page
                yield from _of_group(found, page)


def _of_group(pointer: Any, page: str) -> Iterator[tuple[str, str]]:
    """Yield the pattern of a group of properties, and those of the groups in it."""
    group = getattr(pointer, "fixed_type", None)
    if group is None or group.base is None or group.base.identifier != "PropertyGroup":
        return
    kinds = {kind.attribute: kind for kind in KINDS.values()}
    yield f"{group.identifier}.*", page
    for found in group.properties:
        if found.type in {"POINTER", "COLLECTION"}:
            inner = page
            if found.identifier in kinds:
                inner = KIND_PAGES.get(found.identifier, PARAMETERS)
            yield from _of_group(found, inner)


def register() -> None:
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    bpy.utils.unregister_manual_map(manual_map)
