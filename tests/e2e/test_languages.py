# SPDX-License-Identifier: GPL-3.0-or-later
"""The window in German and Swedish: no text of the extension is English, and texts fit.

It needs a display: DISPLAY, or Xvfb on PATH.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import build_zip

HOME = build_zip.ROOT / "sample_blends" / "angen.blend"
SCRIPT = Path(__file__).with_name("window_texts.py")
LANGUAGES = ("de_DE", "sv_SE")
WORD = re.compile(r"(?<!/)\b[^\W\d_]{3,}")
QUOTED = re.compile(r"'[^']*'")


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def display() -> Iterator[None]:
    """Give Blender a display."""
    if os.environ.get("DISPLAY"):
        yield
        return
    if not (server := shutil.which("Xvfb")):
        pytest.skip("needs a display: DISPLAY, or Xvfb on PATH")
    command = [server, "-displayfd", "1", "-screen", "0", "1600x900x24", "+extension", "GLX"]
    with subprocess.Popen([*command, "-nolisten", "tcp"], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("DISPLAY", f":{run.stdout.readline().strip()}")
            yield
        run.terminate()


@pytest.fixture(scope="module")
def report(
    display: None,
    run_blender: Callable[[list[str]], subprocess.CompletedProcess[str]],
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[str, Any]:
    """Return what the window has drawn, by language."""
    path = tmp_path_factory.mktemp("texts") / "report.json"
    size = ["-p", "0", "0", "1600", "900", "--no-window-focus"]
    done = run_blender([*size, str(HOME), "-P", str(SCRIPT), "--", str(path), *LANGUAGES])
    assert done.returncode == 0 and path.exists(), done.stdout + done.stderr
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


@pytest.fixture(params=LANGUAGES)
def window(request: pytest.FixtureRequest, report: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = report[request.param]
    return found


def english(texts: dict[str, str], known: list[str]) -> list[str]:
    """Return the texts that stay as they are, without numbers, units and quoted names."""
    return [
        text
        for text, shown in texts.items()
        if text == shown and WORD.search(QUOTED.sub("", text)) and text not in known
    ]


def test_blender_finds_the_names_and_tips(window: dict[str, Any]) -> None:
    assert len(window["looked up"]) > 500
    assert english(window["looked up"], window["known"]) == []


def test_no_text_of_a_panel_is_english(window: dict[str, Any]) -> None:
    texts = {text: shown for text, (shown, *_) in window["panels"].items()}
    assert len(texts) > 150
    # Of the coverage map's legend and of an explanation.
    assert {"by three or more", "Opens from"} <= set(texts)
    assert english(texts, window["known"]) == []


def test_texts_fit_with_real_fonts(window: dict[str, Any]) -> None:
    for text, (shown, wide, shown_wide) in window["panels"].items():
        assert shown_wide <= 1.5 * max(wide, window["sidebar"]), (text, shown)


def test_states_in_the_view_are_translated(window: dict[str, Any]) -> None:
    states = {word.partition(",")[0] for word in window["view"]}
    assert states & {"Geschlossen", "Stängd"}
    assert not states & {"Still", "Motion", "Closed", "Open", "Free", "Pressed", "Absent"}
    assert not any("make this editor higher" in word for word in window["view"])
