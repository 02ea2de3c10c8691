# SPDX-License-Identifier: GPL-3.0-or-later
"""Each cache of a function says in a line what it keeps, and what the same costs without it."""

import re
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = ("angen_addon", "operators", "panels", "sensor_logic")
CACHES = re.compile(r"@(functools\.)?(lru_cache|cache)\b")


def test_each_cache_says_what_it_costs_to_go_without() -> None:
    silent, count = [], 0
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
            for above, line in pairwise(lines):
                if CACHES.match(line):
                    count += 1
                    if not (above.startswith("#") and "without" in above):
                        silent.append(f"{path.relative_to(ROOT).as_posix()}: {line}")
    assert count > 15 and silent == []
