# SPDX-License-Identifier: GPL-3.0-or-later
"""The schema of layouts, as editors use it, in the hands of jsonschema."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.layout.schema import schema

DOCS = Path(__file__).resolve().parents[2] / "docs" / "layouts.md"


def sensor(**values):
    return [{"name": "A", "kind": "PIR", "location": [0, 0, 0], **values}]


@pytest.mark.parametrize(
    "wrong",
    [
        {"sensor": []},
        [{"kind": "PIR"}],
        sensor(kind="PIRR"),
        sensor(rooom="hall"),
        sensor(preset="FSR_402"),
        sensor(update_rate=0),
        sensor(location=[1, 2]),
        sensor(look=[1, 0, 0], rotation=[0, 0, 0]),
        sensor(parameters={"range_mx": 1}),
        sensor(parameters={"range_max": -1}),
        sensor(parameters={"rays": 1.5}),
        sensor(parameters={"sweep": "AL"}),
    ],
)
def test_what_is_wrong_is_found(reader, wrong) -> None:
    validator = reader("jsonschema").Draft7Validator
    validator.check_schema(schema())
    assert not validator(schema()).is_valid(wrong)


def test_the_example_of_the_docs_is_valid(reader) -> None:
    (example,) = re.findall(r"```json\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    reader("jsonschema").Draft7Validator(schema()).validate(json.loads(example))
