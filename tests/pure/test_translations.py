# SPDX-License-Identifier: GPL-3.0-or-later
"""The dictionaries of the interface agree with the source, and are complete."""

import runpy
from pathlib import Path

import pytest
from angen_sensors.angen_addon.translations.dictionary import HOLE, read

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "angen_addon" / "translations").glob("*.po"))


@pytest.fixture(scope="module")
def script():
    return runpy.run_path(str(ROOT / "scripts" / "translations.py"))


def test_there_are_german_and_swedish():
    assert [path.stem for path in FILES] == ["de", "sv"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_dictionary_has_the_texts_of_the_source(path, script):
    assert path.read_text(encoding="utf-8") == script["renewed"](path), (
        "run: python scripts/translations.py, and translate what is new"
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_text_is_translated(path):
    assert [entry.text for entry in read(path) if not entry.translation] == []


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_translation_has_the_values_of_its_text(path):
    for entry in read(path):
        if entry.translation:
            assert sorted(HOLE.findall(entry.translation)) == sorted(HOLE.findall(entry.text))
            assert len({*HOLE.findall(entry.text)}) == len(HOLE.findall(entry.text)), entry
