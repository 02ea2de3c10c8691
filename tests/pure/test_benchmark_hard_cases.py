# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/hard_cases.md: each case with a tolerance has its measured figure."""

import hard_cases


def test_the_worst_of_a_tests_cases_is_told_with_its_unit():
    assert hard_cases._worst(["1e-06\tm", "0.00025\tm", "5e-05\tm"]) == "0.00025 m"
    assert hard_cases._worst(["0.0\tvalid updates"]) == "0 valid updates"
    assert hard_cases._worst(["3 changes", "4 changes"]) == "4 changes"


def test_what_has_a_number_for_its_tolerance_has_a_measured_one():
    page = hard_cases.PAGE.read_text(encoding="utf-8")
    cells = [line.split(" | ") for line in page.splitlines() if line.endswith(".py) |")]
    assert len(cells) > 60
    for case, measured, tolerance, _ in cells:
        if tolerance[0].isdigit():
            assert measured[0].isdigit(), case
