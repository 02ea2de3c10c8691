# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write the dictionaries of the interface, which are `.po` files."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

# The context of the extension's texts in Blender's translations.
CONTEXT = "Angen"
# Stands in both texts for what the program puts in, such as {name}.
HOLE = re.compile(r"\{(\w*)\}")
LABEL, TIP, TAB, MESSAGE = "label", "tip", "tab", "message"


class Entry(NamedTuple):
    """A text of the interface, its translation ("" if there is none), and what it is."""

    text: str
    translation: str
    what: str = ""


def read(path: Path) -> list[Entry]:
    """Read a dictionary; each text and each translation is one line."""
    found, what, text = [], "", ""
    for line in path.read_text(encoding="utf-8").splitlines():
        key, _, value = line.partition(" ")
        if key == "#.":
            what = value
        elif key == "msgid":
            text = json.loads(value)
        elif key == "msgstr" and text:
            found.append(Entry(text, json.loads(value), what))
    return found


HEAD = 'msgid ""\nmsgstr "Content-Type: text/plain; charset=UTF-8\\n"\n'


def written(entries: Iterable[Entry]) -> str:
    """Return the text of a dictionary."""
    parts = (
        f"#. {one.what}\nmsgid {_quoted(one.text)}\nmsgstr {_quoted(one.translation)}\n"
        for one in entries
    )
    return "\n".join([HEAD, *parts])


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
