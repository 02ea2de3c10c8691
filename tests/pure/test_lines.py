# SPDX-License-Identifier: GPL-3.0-or-later
"""The line of each value in JSON and TOML."""

import json

import pytest
from angen_sensors.sensor_logic.error import InputError
from angen_sensors.sensor_logic.lines import line_of, read_json, read_toml

# Each whole number is that of its line.
TOML = """# a [comment] = 0
date = 1979-05-27 07:32:00  # "no" = 0
text = '''
[no.header]
no = 0
'''
more = \"\"\"a "quoted" \\" text
[[no]]\"\"\"
"quoted.key" = 9 # [[no]]
with.dots."and #".'quotes' = {a = 10, "b" = [ 10,
  11 ], c.d = [{x = 11}, {x = 11, y = '#]}'}]}
[list]
of = [ # one
  [14, 14],  # two ]
  [

    17],
  {name = "x", at = 18},
]
none = {}
[[rows]]
empty = []
infinite = +inf
[rows.inner]
deep = 25
[[rows.sub]]
x = 27
[[rows.sub]]
x = 29
[[ rows ]]
[[rows.sub]]
x = 32
["a b".'c']
y = 34
"""


def paths(value, path=()):
    yield path, value
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from paths(inner, (*path, key))


def test_toml_gives_the_line_of_every_value():
    values, lines = read_toml(TOML, "a.toml")
    numbers = [(path, value) for path, value in paths(values) if isinstance(value, int)]
    assert len(numbers) == 15
    assert {path: lines[path] for path, _ in numbers} == dict(numbers)
    assert line_of(lines, ("rows",)) == 21
    assert line_of(lines, ("rows", 1)) == 30
    assert line_of(lines, ("list", "of", 1, "missing", 2)) == 15
    assert line_of(lines, ("missing",)) == 1


def test_json_gives_the_line_of_every_value():
    value = {"a": [1, {"b #": None, "c": []}, "x,]"], "d\n": {"e": True, "f": {}}, "": -1.5e3}
    text = json.dumps(value, indent=1)
    found, lines = read_json(text, "a.json")
    assert found == value
    assert set(lines) == {path for path, _ in paths(value)}
    assert [lines[path] for path, _ in paths(value)] == [1, 2, 3, 4, 5, 6, 8, 10, 11, 12, 14]
    assert line_of(lines, ("a", 1, "missing", 3)) == 4


@pytest.mark.parametrize(
    ("text", "line", "told"),
    [
        ('{"a": 1,\n"a": 2}', 2, "'a' is given twice"),
        ("[1,\n NaN\n]", 2, "NaN is no number"),
        ("[1,\n\n}", 3, "no JSON at column 1"),
        ("[" * 100_000, 1, "nested too deep"),
    ],
)
def test_json_that_is_wrong(text, line, told):
    with pytest.raises(InputError, match=f"a.json, line {line}: .*{told}"):
        read_json(text, "a.json")
