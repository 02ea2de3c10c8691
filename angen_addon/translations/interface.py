# SPDX-License-Identifier: GPL-3.0-or-later
"""Show the interface in Blender's language, from the dictionaries beside this file.

All texts have a context of their own. So Blender's dictionary, in which a word can mean another
thing, does not translate them. Blender translates labels and tips, and `translated` the texts that
panels draw and operators report. Logs, and what verbs print, are always English.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from functools import cache, lru_cache, partial, wraps
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints
from weakref import WeakSet

import bpy
from bpy.types import AddonPreferences, Menu, Operator, Panel, PropertyGroup

from .dictionary import CONTEXT, HOLE, LABEL, Entry, read

# Blender's own context, in which it looks for tips and tabs.
EVERYWHERE = "*"
FOLDER = Path(__file__).parent
PACKAGE = __name__.removesuffix(".angen_addon.translations.interface")
# Classes that hold properties, and draw none of our panels.
HOLDERS = PropertyGroup, AddonPreferences
DRAWING = ("draw", "draw_header", "draw_header_preset")
# What a template must have besides its holes, so that it does not match every text.
LETTERS, SHORT = 2, 3
VALUE = re.compile(r"[\d']")
WORD = re.compile(r"[^\W\d_]{3}")
# Between sentences, between a name and a sentence, and in lists.
BETWEEN = (". ", ": ", "; ", ", ")
# Between the tip of a parameter and the source of its default.
SOURCE = ". Source: "
# Before a quoted name in a list.
IN_LIST = re.compile(r"( and |, )(?=')")
# A value in a pattern; in quotes it is one name of a list.
ANY, QUOTED = "(.+?)", "((?:(?!', ).)+?)"


def language() -> str:
    """Return the language of the interface, such as "de"."""
    return str(bpy.app.translations.locale or "en")[:2]


# Reading a dictionary costs some 10 ms, and panels are drawn many times a second.
@cache
def _entries(code: str) -> tuple[Entry, ...]:
    path = FOLDER / f"{code}.po"
    return tuple(e for e in read(path) if e.translation) if path.exists() else ()


# Without it each text costs 0.1 ms more.
@cache
def _texts(code: str) -> dict[str, str]:
    return {entry.text: entry.translation for entry in _entries(code)}


class _Template(NamedTuple):
    """A text with values: its longest part, a pattern with a group for each value, their names.

    A short one, such as "{count} by {name}", fits only numbers, names in quotes and known words.
    """

    part: str
    pattern: re.Pattern[str]
    names: list[str]
    translation: str
    is_short: bool


# Without it each text with values costs 1 ms more, or 10 ms if `re` has forgotten the patterns.
@cache
def _templates(code: str) -> list[_Template]:
    """Return the texts with values, those with the most letters first."""
    found = [e for e in _entries(code) if HOLE.search(e.text) and _letters(e.text) >= LETTERS]
    found.sort(key=lambda entry: -_letters(entry.text))
    made = []
    for entry in found:
        parts = HOLE.split(entry.text)[::2]
        pattern = "".join(
            re.escape(part) + (QUOTED if part.endswith("'") else ANY) for part in parts[:-1]
        )
        whole = re.compile(pattern + re.escape(parts[-1]), re.DOTALL)
        names = HOLE.findall(entry.text)
        is_short = _letters(entry.text) < SHORT
        longest = max(parts, key=len)
        made.append(_Template(longest, whole, names, entry.translation, is_short))
    return made


def _letters(text: str) -> int:
    """Return the number of letters of a text without its values."""
    return sum(letter.isalpha() for letter in HOLE.sub("", text))


def translated(text: str) -> str:
    """Return a text in the language of the interface; texts without a translation stay."""
    code = language()
    return _in(code, text) if text and _texts(code) else text


def _in(code: str, text: str) -> str:
    return _texts(code).get(text) or _composed(code, text) or text


# Without it each text with values costs some 20 µs more at each drawing, of a hundred in a panel.
@lru_cache(4096)
def _composed(code: str, text: str) -> str:
    """Return the translation of a text that is made of known ones and of values; or ""."""
    if not WORD.search(text):
        # A number with its unit.
        return ""
    if found := _of_property(code, text):
        return found
    *parts, last = IN_LIST.split(text)
    if parts and all(_fitting(code, part) for part in [*parts[::2], last]):
        return "".join(_in(code, part) for part in [*parts, last])
    # A sentence after a name and a colon begins with a small letter, and alone with a capital one.
    other = text[:1].swapcase() + text[1:]
    found = _texts(code).get(other) or _fitting(code, text) or _fitting(code, other)
    if found:
        return found[:1].upper() + found[1:] if text[:1].isupper() else found
    for between in BETWEEN:
        first, _, rest = text.partition(between)
        if rest and (found := f"{_in(code, first)}{between}{_in(code, rest)}") != text:
            return found
    return ""


def _of_property(code: str, text: str) -> str:
    """Return the translation of a label with a unit, or of a tip with a source; or ""."""
    known = _texts(code)
    label, _, unit = text.rpartition(" (")
    if unit.endswith(")") and label in known:
        return f"{known[label]} ({unit}"
    tip, _, source = text.partition(SOURCE)
    return (
        f"{known[tip]}. {known.get('Source', 'Source')}: {source}"
        if source and tip in known
        else ""
    )


def _fitting(code: str, text: str) -> str:
    """Return the translation of a text with values, which are translated too; or ""."""
    for part, pattern, names, template, is_short in _templates(code):
        if part in text and (found := pattern.fullmatch(text)):
            if is_short and not all(VALUE.search(v) or v in _texts(code) for v in found.groups()):
                continue
            values = (_in(code, value) for value in found.groups())
            return template.format(**dict(zip(names, values, strict=True)))
    return ""


class TranslatedLayout:
    """A `UILayout` whose texts are translated, unless `translate` is False."""

    def __init__(self, layout: Any) -> None:
        object.__setattr__(self, "layout_in_english", layout)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.layout_in_english, name)
        return partial(self._draw, found) if callable(found) else found

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self.layout_in_english, name, value)

    def _draw(self, function: Callable[..., Any], *arguments: Any, **facts: Any) -> Any:
        """Call a function of the layout with translated texts; parts of it translate too."""
        shown = {key: facts[key] for key in ("text", "heading") if facts.get(key)}
        if shown and facts.get("translate", True):
            facts |= {key: translated(text) for key, text in shown.items()} | {"translate": False}
        found = function(*arguments, **facts)
        if isinstance(found, tuple):
            return tuple(TranslatedLayout(one) if one is not None else None for one in found)
        of_layout = isinstance(found, type(self.layout_in_english))
        return TranslatedLayout(found) if of_layout else found


class _Translated:
    """A panel, menu or operator while it draws; its layout translates."""

    def __init__(self, owner: Any) -> None:
        self._owner = owner
        self.layout = TranslatedLayout(owner.layout)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._owner, name)


def translating(draw: Callable[..., None]) -> Callable[..., None]:
    """Decorate a function that draws, in a class or appended to a menu: its layout translates."""

    @wraps(draw)
    def translating(self: Any, context: Any) -> None:
        draw(_Translated(self) if _texts(language()) else self, context)

    return translating


def in_context(prop: Any) -> Any:
    """Return a bpy property, of which Blender looks for texts in the extension's context."""
    prop.keywords.setdefault("translation_context", CONTEXT)
    return prop


def prepare_classes() -> None:
    """Give the extension's classes, before their registration, its context and translated texts."""
    for cls in _classes():
        if cls not in _FORMER:
            _prepare(cls)


def _prepare(cls: Any) -> None:
    own = vars(cls).get("__annotations__", {})
    for name, prop in own.items():
        if isinstance(prop, str) and "Property(" in prop:
            # A postponed annotation, which Blender evaluates in the same way.
            own[name] = prop = get_type_hints(cls)[name]
        if hasattr(prop, "keywords"):
            in_context(prop)
    if issubclass(cls, HOLDERS) or "bl_translation_context" in vars(cls):
        return
    cls.bl_translation_context = CONTEXT
    for name in DRAWING:
        if hasattr(cls, name):
            setattr(cls, name, translating(getattr(cls, name)))


def _classes() -> Iterator[Any]:
    """Yield the extension's classes that Blender can register, each before its subclasses."""
    for base in (Panel, Menu, Operator, *HOLDERS):
        yield from _below(base)


def _below(base: Any) -> Iterator[Any]:
    for cls in base.__subclasses__():
        if cls.__module__.startswith(f"{PACKAGE}."):
            yield cls
        yield from _below(cls)


def _texts_of_properties() -> Iterator[str]:
    """Yield the names and tips of the extension's properties."""
    for cls in (cls for base in HOLDERS for cls in _below(base)):
        for prop in vars(cls).get("__annotations__", {}).values():
            if hasattr(prop, "keywords"):
                yield from (prop.keywords.get(key, "") for key in ("name", "description"))


# Classes of another version that this one replaces in a running Blender: their modules are gone.
_FORMER = WeakSet(cls for cls in _classes() if cls.__module__ not in sys.modules)


def register() -> None:
    """Give Blender all dictionaries, once all properties are known."""
    found: dict[str, dict[tuple[str, str], str]] = {}
    texts = set(_texts_of_properties())
    for path in FOLDER.glob("*.po"):
        entries = _entries(path.stem)
        found[path.stem] = {(CONTEXT, e.text): e.translation for e in entries}
        found[path.stem] |= {
            (EVERYWHERE, e.text): e.translation for e in entries if e.what != LABEL
        }
        for text in texts:
            if shown := _of_property(path.stem, text):
                found[path.stem] |= {(CONTEXT, text): shown, (EVERYWHERE, text): shown}
    bpy.app.translations.register(__name__, found)


def unregister() -> None:
    bpy.app.translations.unregister(__name__)
