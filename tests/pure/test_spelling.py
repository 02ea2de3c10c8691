# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts that users read are spelled right, and nothing uses words that only this project had.

tests/data/words.txt has every word of these texts, in British spelling, one a line and sorted.
`make golden` writes it anew: look at the spelling of what is new in it.
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WORDS = ROOT / "tests" / "data" / "words.txt"
PRODUCT = ("sensor_logic", "angen_addon", "operators", "panels", "residents", "studies")
CODE = (*PRODUCT, "benchmarks", "sample_blends", "scripts", "tests")
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
WORD = re.compile(r"[^\W\d_]+(?:[-–/'’][^\W\d_]+)*")
# Code and addresses within a page.
NO_PROSE = re.compile(
    r"```.*?```|`[^`\n]*`|<!--.*?-->|<[^>\n]+>|\]\([^)\n]*\)|https?://\S+", re.DOTALL
)
# Phrases that only this project used, with those of the field.
PRIVATE = {
    "takes down": "records",
    "take down": "record",
    "taken down": "recorded",
    "had their turn": "after yielding",
    "somebody else's turn": "after yielding",
    "what is asked of": "the queries of",
    "is told of": "gets, is notified of",
    "are told beside": "are given too",
    "is told beside": "is given too",
    "lives the home": "evaluates the home",
    "goes round": "is reflected",
    "is met anew": "is cast again",
    "of former code": "of an older checkout",
}
BREAK = re.compile(r"\s+(?:# )?")
PHRASE = re.compile(rf"\b(?:{'|'.join(PRIVATE).replace(' ', BREAK.pattern)})\b")


def sources(*folders: str) -> Iterator[tuple[str, str]]:
    for path in sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py")):
        yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def pages() -> Iterator[tuple[str, str]]:
    for path in (*(ROOT / name for name in PAGES), *sorted((ROOT / "docs").rglob("*.md"))):
        yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def literals(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of the strings that are sentences or labels, without docstrings."""
    docstrings = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr):
            docstrings.add(node.value)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
            is_label = text[:1].isupper() and text[1:].islower()
            if node not in docstrings and (is_label or " " in text.strip()):
                yield node.lineno, text


def prose(page: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of a page, without code and addresses."""
    blank = NO_PROSE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), page)
    yield from enumerate(blank.splitlines(), 1)


def words(text: str) -> Iterator[str]:
    """Yield the words of a text in lower case, without names of code and abbreviations."""
    for token in text.split():
        token = token.strip(".,;:!?()[]{}\"'“”‘’*…|<>=+")
        if WORD.fullmatch(token):
            for word in re.split(r"[-–/]", token):
                word = re.sub(r"['’]s?$", "", word).replace("’", "'")
                if word[1:] == word[1:].lower() and len(word) > 1:
                    yield word.lower()


def user_texts() -> Iterator[tuple[str, int, str]]:
    for name, source in sources(*PRODUCT):
        yield from ((name, line, text) for line, text in literals(source))
    for name, page in pages():
        yield from ((name, line, text) for line, text in prose(page))


def test_every_word_that_users_read_is_in_the_list() -> None:
    used = [(word, f"{name}:{line}") for name, line, text in user_texts() for word in words(text)]
    if os.environ.get("ANGEN_GOLDEN") == "write":
        WORDS.write_text("\n".join(sorted({word for word, _ in used})) + "\n", encoding="utf-8")
    known = set(WORDS.read_text(encoding="utf-8").split())
    wrong = [f"{place}: {word}" for word, place in used if word not in known]
    how = "These are misspelled, or new. `make golden ARGS='-k spelling'` takes new ones in:"
    assert not wrong, "\n".join([how, *wrong])


def test_the_list_is_sorted() -> None:
    listed = WORDS.read_text(encoding="utf-8").split()
    assert listed == sorted(set(listed))


def test_the_way_to_words_finds_what_it_should() -> None:
    assert [*words("It aldirections reads `x`, doors' leaf-end; obj.path UUIDs a 5 °C.")] == [
        *("it", "aldirections", "reads", "doors", "leaf", "end")
    ]
    assert [*literals('"""Doc."""\nfail("No such", f"{x} is one")\n"key"\n')] == [
        (2, "No such"),
        (2, " is one"),
    ]


def test_no_text_uses_words_that_only_this_project_had() -> None:
    this = Path(__file__).relative_to(ROOT).as_posix()
    texts = [item for item in sources(*CODE) if item[0] != this]
    found = []
    for name, text in (*texts, *pages()):
        # A phrase may go on in the next line, or in the next comment.
        for hit in PHRASE.finditer(text):
            phrase = BREAK.sub(" ", hit[0])
            line = text.count("\n", 0, hit.start()) + 1
            found.append(f"{name}:{line}: '{phrase}', say: {PRIVATE[phrase]}")
    assert not found, "\n".join(found)
