# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of docs/pressure.md are those of the measured data."""

import json

from benchmarks import pressure_report


def data():
    return json.loads(pressure_report.DATA.read_text(encoding="utf-8"))


def test_the_page_has_the_tables_of_the_data():
    page = pressure_report.PAGE.read_text(encoding="utf-8")
    assert page == pressure_report.filled(page, data()), "run: python -m benchmarks.pressure_report"
