# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pir.md tells what was measured, and each lens that there is."""

import json

from benchmarks.pir_pyroelectric import DATA, PAGE, filled
from sensor_logic.pyroelectric.lenses import LENSES


def test_the_tables_are_those_of_the_data():
    page = PAGE.read_text(encoding="utf-8")
    data = json.loads(DATA.read_text(encoding="utf-8"))
    assert not data["quick"]
    assert filled(page, data) == page, "run: python -m benchmarks.pir_pyroelectric"
    assert all(f"{row['ms']:.2f} |" in page for row in data["cost"])


def test_every_lens_is_told():
    page = PAGE.read_text(encoding="utf-8")
    assert all(f"| `{name}` |" in page for name in LENSES)
