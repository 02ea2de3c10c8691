# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pir.md tells what was measured, and each lens that there is."""

import json

from angen_sensors.sensor_logic.kinds.pir.lenses import LENSES

from benchmarks.page import DOCS
from benchmarks.pir_pyroelectric_report import COMMAND, PAGE, filled


def test_the_tables_are_those_of_the_data():
    page = PAGE.read_text(encoding="utf-8")
    data = json.loads((DOCS / "data" / "pir_pyroelectric.json").read_text(encoding="utf-8"))
    assert not data["quick"]
    assert filled(page, data) == page, f"run: {COMMAND}"


def test_every_lens_is_told():
    page = PAGE.read_text(encoding="utf-8")
    assert all(f"| `{name}` |" in page for name in LENSES)
