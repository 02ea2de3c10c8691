# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts that users see equal the golden files in tests/golden, which `make golden` renews."""

import difflib
import os
import re
from itertools import zip_longest

import pytest
from golden_bench import ROOT, Bench
from golden_cases import CASES, Close

GOLDEN = ROOT / "tests" / "golden"
WRITE = os.environ.get("ANGEN_GOLDEN") == "write"
NUMBER = re.compile(r"(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)")
MOST_SHOWN = 80


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return Bench(tmp_path_factory.mktemp("golden"), lambda: None)


def is_close(expected: str, found: str, close: Close) -> bool:
    """Return whether two texts are equal except for numbers within the tolerance."""
    if expected == found:
        return True
    one, two = NUMBER.split(expected), NUMBER.split(found)
    if one[::2] != two[::2]:
        return False
    return all(
        abs(float(a) - float(b)) <= close.absolute + close.relative * abs(float(a))
        for a, b in zip(one[1::2], two[1::2], strict=True)
    )


def with_expected(expected: str, found: str, close: Close) -> str:
    """Return the found text with the expected line in place of each that is close to it."""
    if close == Close():
        return found
    lines = expected.splitlines(keepends=True), found.splitlines(keepends=True)
    heads = lines[0][0].rstrip("\n").split(",") if close.columns else []

    def agree(a: str, b: str) -> bool:
        if not close.columns:
            return is_close(a, b, close)
        one, two = a.rstrip("\n").split(","), b.rstrip("\n").split(",")
        return len(one) == len(two) == len(heads) and all(
            is_close(x, y, close) if head in close.columns else x == y
            for head, x, y in zip(heads, one, two, strict=True)
        )

    pairs = zip_longest(*lines, fillvalue="")
    return "".join(a if agree(a, b) else b for a, b in pairs)


# Names only: pytest would keep the table and with it bpy, and Blender 4.2 crashes at the end.
NAMES = [
    # These read the homes' places and plan a day, which takes seconds.
    pytest.param(name, marks=pytest.mark.slow) if name.startswith("day_") else name
    for name in CASES
]


@pytest.mark.parametrize("name", NAMES)
def test_golden(name, bench, request):
    bench.new_world = lambda: request.getfixturevalue("world")
    case, path = CASES[name], GOLDEN / name
    text = case.text(bench)
    expected = path.read_text(encoding="utf-8") if path.exists() else ""
    found = with_expected(expected, text, case.close) if expected else text
    if found == expected:
        return
    if WRITE:
        GOLDEN.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
        print(f"written: {path.relative_to(ROOT)}")
        return
    ends = expected.splitlines(), found.splitlines()
    diff = list(difflib.unified_diff(*ends, "golden", "found now", n=1, lineterm=""))
    more = [f"… and {len(diff) - MOST_SHOWN} more lines"] if len(diff) > MOST_SHOWN else []
    pytest.fail(
        "\n".join(
            [
                f"tests/golden/{name} differs from what the code gives now.",
                "If the change is meant, run `make golden` and say why in the commit.",
                *diff[:MOST_SHOWN],
                *more,
            ]
        ),
        pytrace=False,
    )


def test_every_golden_file_has_a_case():
    left = {path.name for path in GOLDEN.iterdir()} - set(CASES)
    if WRITE:
        for name in left:
            (GOLDEN / name).unlink()
    else:
        assert not left, "remove them: make golden"
