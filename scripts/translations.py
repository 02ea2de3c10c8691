# SPDX-License-Identifier: GPL-3.0-or-later
"""Renew the dictionaries of the interface in angen_addon/translations from the source.

A dictionary has each text of the interface, with a translation or an empty one. This script adds
the new texts, removes those that are gone, and keeps all translations:

    python scripts/translations.py
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from angen_addon.translations.dictionary import (  # noqa: E402
    HOLE,
    LABEL,
    MESSAGE,
    TAB,
    TIP,
    Entry,
    read,
    written,
)
from sensor_logic.kinds import KINDS, owner_properties  # noqa: E402
from sensor_logic.parameters import Parameters, specs  # noqa: E402

FOLDER = ROOT / "angen_addon" / "translations"
SOURCES = ("angen_addon", "operators", "panels", "residents", "studies/window")
# The attributes of classes, and the keywords of calls, that are texts of the interface.
ATTRIBUTES = {"bl_label": LABEL, "bl_category": TAB, "bl_description": TIP}
OF_PROPERTY = {"name": LABEL, "description": TIP}
# Blender itself translates placeholders, as tips.
OF_LAYOUT = {"text": LABEL, "heading": LABEL, "placeholder": MESSAGE}
LAYOUTS = ("label", "operator", "prop", "menu", "popover", "progress", "column", "row", "draw_row")
# A value in a text, also one with a format; attributes whose owners name the value better.
FORMATTED = re.compile(r"\{(\w*)(?::[^{}]*)?\}")
NAMELESS = ("name", "text", "label", "value", "short", "name_full")
VALUE = "value"
# The name of a fact, which an explanation has in a pair with a text.
FACT = re.compile(r"[A-Z][a-z ]+")
WORD = re.compile(r"\b[a-z]{4,}")
# The least letters of a text of several words, without its values.
LETTERS = 2
# Texts that panels draw, and that are made elsewhere in the source.
OTHERS = (
    "No reading", "All Frames, {} to {}", "Simulate first", "Parameters of {}",
    "Parameters: the defaults", "Add Place at 3D Cursor", "Motion, open, pressed, lit",
    "Still, closed, free, dark", "Not valid", "Not yet sure, or warming up",
    "Old: the scene has changed since", "Only baked keyframes",
    "No reading: scrub, play or simulate", "Off", "{} and {} more", "{}, and is stale",
    "no room", "not noticed", "noticed in few directions", "covered by one", "by two",
    "by three or more",
    "Older adult", "Adult", "Child", "Cat",
    # Words that sentences have as values.
    " and ", "above", "away", "below", "breathing", "centimetres", "doors", "fast", "feet",
    "hinged", "inches", "it", "learnt", "left", "mass", "millimetres", "movement", "noise",
    "nothing", "power", "right", "rooms", "sliding", "slowly", "something", "walls", "warmest",
    "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday",
)  # fmt: skip
# The positions of texts in calls of functions, by the function's name.
ARGUMENTS = {
    "draw_lines": {1: MESSAGE},
    "draw_property": {4: LABEL},
    "draw_row": {1: LABEL, 2: MESSAGE},
    "needs": {2: MESSAGE},
    "cancelled": {1: MESSAGE},
    "translated": {0: MESSAGE},
    "Doing": {1: MESSAGE},
    "part_of": {3: MESSAGE},
    "AngenError": {0: MESSAGE},
    "InputError": {0: MESSAGE},
    "SensorError": {0: MESSAGE},
    "Advice": {0: MESSAGE, 1: MESSAGE},
}
# Folders and files in which each text of several words is shown in the window.
PROSE = (
    "angen_addon/advice",
    "angen_addon/appearance/handles.py",
    "angen_addon/appearance/facts.py",
    "angen_addon/appearance/recorded.py",
    "angen_addon/appearance/uses.py",
    "angen_addon/coverage/floor_cells.py",
    "angen_addon/coverage/proposal.py",
    "angen_addon/coverage/shown.py",
    "angen_addon/doctor",
    "angen_addon/explain",
    "angen_addon/kinds",
    "angen_addon/output/mqtt/live.py",
    "angen_addon/output/mqtt/online.py",
    "angen_addon/recording/bake.py",
    "angen_addon/recording/fingerprint.py",
    "angen_addon/recording/followed_scene.py",
    "angen_addon/recording/store.py",
    "angen_addon/runtime",
    "angen_addon/scene/animation.py",
    "angen_addon/scene/door_motion.py",
    "angen_addon/scene/forces",
    "angen_addon/scene/light/cycles.py",
    "angen_addon/scene/light/probe.py",
    "angen_addon/scene/timed.py",
    "angen_addon/scene/uses.py",
    "angen_addon/view",
    "operators",
    "panels",
    "residents/blender/followed_day.py",
    "residents/blender/lamps.py",
    "residents/blender/marks.py",
    "residents/blender/places.py",
    "residents/blender/reachable.py",
    "residents/blender/settings.py",
    "residents/blender/standing.py",
    "residents/blender/unmovable.py",
    "residents/operators",
    "residents/panels",
    "sensor_logic/coverage/motions.py",
    "sensor_logic/forces/pad_forces.py",
    "sensor_logic/model.py",
    "sensor_logic/physics.py",
    "sensor_logic/progress.py",
    "sensor_logic/recording/validity.py",
    "sensor_logic/use.py",
)
# Texts in these places that are names in a file or in Blender.
NOT_SHOWN = (
    "3D View Tool: Tweak", "3D View Tool: Tweak (fallback)", "Coverage of {scene}",
    "Emission Color", "Emission Strength", "Flag {leaf_object}", "Lens of {obj}", "Object Mode",
    "Proposed {short_label} {i}", "Switch {leaf_object}", "Way that ends", "Way to {place}",
    "{OWNER} = bpy.context.object.angen_sensor.{attribute}", "{stem} events", "{stem} samples",
    "A recording of the Blender extension Ängen Sensors; Clear Recording there removes it",
    "{LABELS}, from anywhere", "Walking frame metal", "{rig} walking frame",
)  # fmt: skip
# Files of commands and formats, whose errors no window shows.
COMMANDS = (
    "angen_addon/api", "angen_addon/commands", "angen_addon/coverage/command.py",
    "angen_addon/output/faulty.py", "angen_addon/output/mqtt/address.py",
    "angen_addon/output/mqtt/player.py", "angen_addon/output/output_files.py",
    "angen_addon/process", "residents/blender/api.py", "residents/blender/command.py",
    "residents/blender/learn.py", "residents/routine/learn.py",
)  # fmt: skip


# Without it each language takes as long as the first one.
@cache
def texts() -> dict[str, str]:
    """Return the texts of the interface, each with what it is: label, tip or message."""
    found: dict[str, str] = {}
    first: dict[str, str] = {}
    for text, what in [*_of_source(), *_of_kinds(), *_of_others()]:
        # Names in programs, and errors of commands.
        is_name = ("_" in text and " " not in text) or text.startswith("--")
        if any(letter.isalpha() for letter in HOLE.sub("", text)) and not is_name:
            # Texts that differ only in the names of their values are one text.
            text = first.setdefault(bare(text), text)
            # What Blender looks for in its own context must not be a mere label here.
            found[text] = what if found.get(text, LABEL) == LABEL else found[text]
    return found


def _of_kinds() -> Iterator[tuple[str, str]]:
    parameters: list[type[Parameters]] = []
    for kind in KINDS.values():
        yield from ((kind.label, LABEL), (kind.tip, TIP), (kind.active_label, LABEL))
        yield kind.idle_label, LABEL
        for field in kind.events:
            name = field.name.replace("_", " ")
            if field.type is int:
                yield f"{{count}} {name}", MESSAGE
            elif field.type is bool:
                yield from ((name, MESSAGE), (f"not {name}", MESSAGE))
        yield from ((field.word, MESSAGE) for field in kind.samples if field.word)
        # Most presets have only the name of a product.
        yield from ((p.label, LABEL) for p in kind.presets if WORD.search(p.label))
        parameters.append(kind.parameters)
    for made in (made for owner in ("Object", "Material") for made in owner_properties(owner)):
        yield from ((made.label, LABEL), (made.tip, TIP))
        parameters.append(made.parameters)
    for group in parameters:
        for spec in specs(group).values():
            yield from ((spec.label, LABEL), (spec.short, LABEL), (spec.tip, TIP))
            yield from ((label, LABEL) for _, *labels in spec.other_labels for label in labels)
            for choice in spec.choices:
                yield from ((choice.label, LABEL), (choice.tip, TIP))


def _of_others() -> Iterator[tuple[str, str]]:
    """Yield OTHERS; raise ValueError if one is no longer in the source."""
    known = {
        bare(text)
        for path in _paths((*SOURCES, "sensor_logic/coverage", "sensor_logic/logs/wording.py"))
        for node in _nodes(path)
        if isinstance(node, (ast.Constant, ast.JoinedStr))
        for text, _ in _constants(node, LABEL)
    }
    if gone := [text for text in OTHERS if bare(_with_names(text)) not in known]:
        raise ValueError(f"remove from OTHERS, as the source does not have them: {gone}")
    yield from ((_with_names(text), MESSAGE) for text in OTHERS)


def _of_source() -> Iterator[tuple[str, str]]:
    commands = set(_paths(COMMANDS))
    for path in _paths(SOURCES):
        if path not in commands:
            for node in _nodes(path):
                yield from _of_node(node)
    for path in _paths(PROSE):
        yield from _of_prose(_nodes(path))


def _of_prose(nodes: Sequence[ast.AST]) -> Iterator[tuple[str, str]]:
    """Yield the texts of several words, without docstrings."""
    inner: set[ast.AST] = set()
    for node in nodes:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            inner.add(node.value)
        if isinstance(node, ast.JoinedStr):
            formats = [getattr(part, "format_spec", None) for part in node.values]
            inner.update(node.values, filter(None, formats))
    for node in nodes:
        pair = node.elts if isinstance(node, ast.Tuple) and len(node.elts) == 2 else ()
        if pair and FACT.fullmatch(name := _string(pair[0])):
            yield name, MESSAGE
        if node not in inner and isinstance(node, (ast.Constant, ast.JoinedStr)):
            found = ((text.removeprefix(". "), what) for text, what in _constants(node, MESSAGE))
            yield from (one for one in found if _is_prose(one[0]))


def _is_prose(text: str) -> bool:
    letters = sum(map(str.isalpha, HOLE.sub("", text)))
    return letters >= LETTERS and " " in text.strip() and text not in NOT_SHOWN


def _paths(places: Iterable[str]) -> Iterator[Path]:
    """Yield the Python files of folders, and files themselves; raise ValueError if one is gone."""
    for place in places:
        path = ROOT / place
        if not path.exists():
            raise ValueError(f"{place} is gone: name its texts' new place in this script")
        yield from [path] if path.is_file() else sorted(path.rglob("*.py"))


# Without it the files with texts are parsed twice.
@cache
def _nodes(path: Path) -> list[ast.AST]:
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def _of_node(node: ast.AST) -> Iterator[tuple[str, str]]:
    if isinstance(node, ast.ClassDef):
        for one in node.body:
            if isinstance(one, ast.Assign) and isinstance(one.targets[0], ast.Name):
                what = ATTRIBUTES.get(one.targets[0].id)
                yield from _constants(one.value, what) if what else ()
    if isinstance(node, (ast.List, ast.Tuple)):
        yield from _of_items(node)
        if _is_section(node):
            yield from _constants(node.elts[0], LABEL)
    if not isinstance(node, ast.Call):
        return
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    keywords = OF_PROPERTY if name.endswith("Property") else OF_LAYOUT if name in LAYOUTS else {}
    for keyword in node.keywords:
        if keyword.arg in keywords:
            yield from _constants(keyword.value, keywords[keyword.arg])
    if name == "plural" and isinstance(noun := node.args[-1], ast.Constant):
        yield from ((f"{{count}} {_string(noun)}s", MESSAGE), (f"1 {_string(noun)}", MESSAGE))
    for position, what in ARGUMENTS.get(name, {}).items():
        if position < len(node.args):
            yield from _constants(node.args[position], what)


def _is_section(node: ast.List | ast.Tuple) -> bool:
    """Return whether this is a section of a panel: a title and the names of its properties."""
    if len(node.elts) != 2 or not isinstance(node.elts[1], ast.Tuple):
        return False
    return all(isinstance(p, ast.Constant) and p.value for p in node.elts[1].elts)


def _string(node: ast.expr) -> str:
    """Return the string that an expression is, or ""."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def _of_items(node: ast.List | ast.Tuple) -> Iterator[tuple[str, str]]:
    """Yield the labels and tips of the items of an enumeration: (identifier, label, tip, …)."""
    for item in node.elts:
        if not isinstance(item, ast.Tuple) or not 3 <= len(item.elts) <= 5:
            continue
        parts = [_string(part) for part in item.elts[1:3]]
        last = item.elts[-1]
        if all(parts) and (
            len(item.elts) == 3 or (isinstance(last, ast.Constant) and isinstance(last.value, int))
        ):
            yield from ((parts[0], LABEL), (parts[1], TIP))


def _constants(node: ast.expr, what: str) -> Iterator[tuple[str, str]]:
    """Yield the texts that an expression can be, with {name} for what is put into them."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield _with_names(node.value), what
    elif isinstance(node, ast.Subscript):
        yield from _constants(node.value, what)
    elif isinstance(node, ast.JoinedStr):
        for part in node.values:
            if isinstance(part, ast.FormattedValue):
                yield from (one for one in _constants(part.value, what) if "{" not in one[0])
        holes = (_string(p) or f"{{{_name(p)}}}" for p in node.values)
        yield _with_names("".join(holes)), what
    elif isinstance(node, ast.IfExp):
        yield from (*_constants(node.body, what), *_constants(node.orelse, what))


def _name(node: ast.expr) -> str:
    """Return a word for the value of an expression, such as `sensor` for `sensor.name`."""
    if isinstance(node, ast.FormattedValue):
        return _name(node.value)
    if isinstance(node, ast.Attribute):
        owner = _name(node.value) if node.attr in NAMELESS else "self"
        return node.attr.strip("_") if owner == "self" else owner
    if isinstance(node, ast.Call):
        if getattr(node.func, "id", "") == "plural":
            return _string(node.args[-1]).rpartition(" ")[2] + "s"
        return _name(node.args[0] if node.args else node.func)
    if isinstance(node, (ast.Subscript, ast.Starred)):
        return _name(node.value)
    if isinstance(node, ast.BinOp):
        return _name(node.left)
    return node.id.strip("_") or VALUE if isinstance(node, ast.Name) else VALUE


def _with_names(text: str) -> str:
    """Return a text whose values all have different names."""
    names: list[str] = []

    def named(found: re.Match[str]) -> str:
        word = VALUE if found[1].isdigit() or not found[1] else found[1]
        again = sum(name.rstrip("0123456789") == word for name in names)
        names.append(f"{word}{again + 1}" if again else word)
        return f"{{{names[-1]}}}"

    return FORMATTED.sub(named, text)


def bare(text: str) -> str:
    """Return a text without the names of its values, which differ only for translators."""
    return HOLE.sub("{}", text)


def renewed(path: Path) -> str:
    """Return the text of a dictionary with the texts of the source."""
    before = {bare(entry.text): entry for entry in read(path)}
    return written(
        Entry(text, _translation(before[bare(text)], text) if bare(text) in before else "", what)
        for text, what in texts().items()
    )


def _translation(before: Entry, text: str) -> str:
    """Return a translation with the names that the values have in `text`."""
    names = dict(zip(HOLE.findall(before.text), HOLE.findall(text), strict=True))
    return HOLE.sub(lambda found: f"{{{names.get(found[1], found[1])}}}", before.translation)


if __name__ == "__main__":
    for file in sorted(FOLDER.glob("*.po")):
        file.write_text(renewed(file), encoding="utf-8")
        empty = sum(not entry.translation for entry in read(file))
        print(f"{file.name}: {len(texts())} texts, {empty} not translated")
