# SPDX-License-Identifier: GPL-3.0-or-later
"""Layout files: every error names file, line, sensor and the way out; lines of values in TOML."""

import json
import re
import runpy
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.layout.entries import KEYS, read_layout
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.lines import line_of, read_toml
from angen_sensors.sensor_logic.parameters import specs

ROOT = Path(__file__).resolve().parents[2]
SOUND = """[
 {"name": "PIR hall.001", "kind": "PIR", "location": [0, 1, 2],
  "preset": "HC_SR501",
  "parameters": {"hold_time": 2, "rays": 9.0}}
]"""
TWO = '[{"name": "A"},\n{"name": "B"},\n{"name": "A"}]'


def entry(text):
    """Return a layout of one sensor with the given text in its third line."""
    return f'[\n {{"name": "A", "kind": "PIR",\n {text}}}\n]'


WRONG = [
    ("", 1, "not valid JSON"),
    ("[\n{]", 2, "not valid JSON"),
    ('{"name": "A"}', 1, "'name' is unknown: give a list of sensors"),
    ("{}", 1, "'sensors' is missing"),
    ('{"sensors":\n {}}', 2, "sensors must be a list"),
    ("[1,\n2]", 1, "a sensor must be an object"),
    ('[\n{"kind": "PIR"}]', 2, "must have a name"),
    ('[\n{"name": ""}]', 2, "not empty"),
    (TWO, 3, "'A': line 1 has the same sensor"),
    ('[{"name": "A",\n"name": "B"}]', 2, "'name' is given twice"),
    (entry('"room": 1'), 3, "'A': room must be a text"),
    (entry('"room": "\\ud800"'), 3, "an incomplete character"),
    (entry('"rooom": "hall"'), 3, "'rooom' is unknown: did you mean room"),
    (entry('"range_mx": 1'), 3, 'parameters belong under "parameters": {"range_max": … }'),
    (entry('"threshold": 1'), 3, 'parameters belong under "parameters": {"threshold": … }'),
    (entry('"enabled": 1'), 3, "true or false"),
    (entry('"update_rate": true'), 3, "update_rate must be a number"),
    (entry('"update_rate": NaN'), 3, "NaN is no number"),
    (entry('"update_rate": 1e999'), 3, "too large"),
    (entry('"location": [1, 2]'), 3, "x, y and z"),
    (entry('"location": [1, 2, "3"]'), 3, "location must be a number"),
    (entry('"location": [1, 2,\n 1e39]'), 3, "too large"),
    (entry('"look": [0, 0, 0]'), 3, "look is not a direction"),
    (entry('"rotation": [0, 0, 0], "look": [1, 0, 0]'), 3, "give one of them"),
    (entry('"relative_to": "Door"'), 3, "needs a location"),
    (entry('"bounds": [[1, 1, 1], [0, 2, 2]]'), 3, "smallest"),
    (entry('"preset": "HC_SR50"'), 3, "did you mean HC_SR501"),
    (entry('"parameters": []'), 3, "object in { }"),
    (entry('"parameters": {"rays": 1,\n"range_mx": 1}'), 4, "did you mean range_max"),
    (entry('"parameters": {"rays": 1.5}'), 3, "rays must be a whole number"),
    (entry('"parameters": {"rays": 1e10}'), 3, "rays is too large"),
    (entry('"parameters": {"rays": 1' + "0" * 5000 + "}"), 1, "too many digits"),
    (entry('"parameters": {"retrigger": 1}'), 3, "retrigger must be true or false"),
    (entry('"parameters": {"sweep": "AL"}'), 3, "did you mean ALL"),
    (entry('"parameters": {"range_max": null}'), 3, "range_max must be a number"),
    ('[{"name": "A",\n"kind": "PIRR"}]', 2, "kind 'PIRR' is unknown: did you mean PIR?"),
    ("[" * 100_000, 1, "nested too deep"),
    (entry('"empties": {\n"Magnet": 1}'), 3, "'Magnet' must be an object in { }, such as"),
    (entry('"empties": {"M": {"place": 1}}'), 3, "'M' has the unknown key 'place'"),
    (entry('"empties": {"M": {"location": [1]}}'), 3, "'M' has a wrong location: it must be"),
    (entry('"empties": {"M": {"relative_to": "D"}}'), 3, "relative_to without a location"),
    (entry('"empties": {"A": {"location": [0, 0, 0]}}'), 3, "a sensor of the layout has this name"),
    (entry('"texts": {"Lens": "a,b"}'), 3, "texts 'Lens' must be a list of its lines"),
    (entry('"texts": {"Lens": [1]}'), 3, "texts 'Lens' has a line that must be a text"),
    (entry('"texts": []'), 3, "texts must be an object in { } with a name for each"),
    ('{"sensors": [],\n"marks": []}', 2, "marks must be an object in { }"),
    ('{"sensors": [],\n"marks": {"Door":\n 1}}', 2, "marks 'Door' must be an object in { }"),
    ('{"sensors": [],\n"others_enabled": "no"}', 2, "others_enabled must be true or false"),
]


def written(folder, text):
    path = folder / "home.json"
    path.write_text(text, encoding="utf-8")
    return path


def test_what_is_read_has_the_types_of_the_parameters(tmp_path):
    for text in (SOUND, '{"$schema": "x", "sensors": ' + SOUND + "}", "\ufeff" + SOUND):
        (found,) = read_layout(written(tmp_path, text)).sensors
        values = found.settings(KINDS["PIR"])
        assert found.name == "PIR hall.001"
        # The preset's values, and those that replace them.
        assert (values["range_max"], values["hold_time"], values["rays"]) == (5.0, 2.0, 9)
        assert isinstance(values["rays"], int) and isinstance(values["hold_time"], float)


@pytest.mark.parametrize(("text", "line", "told"), WRONG)
def test_what_is_wrong_is_told_with_its_line(tmp_path, text, line, told):
    with pytest.raises(InputError) as error:
        read_layout(written(tmp_path, text))
    assert str(error.value).startswith(f"{tmp_path / 'home.json'}, line ")
    found = re.search(r"home\.json, line (\d+): (.*)$", str(error.value))
    assert found, error.value
    assert int(found[1]) == line and told in found[2]


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_bytes(b'["\xff"]')
    for path, told in ((tmp_path / "none.json", "No such file"), (tmp_path, ""), (bad, "UTF-8")):
        with pytest.raises(InputError, match=re.escape(path.name)) as error:
            read_layout(path)
        assert told in str(error.value)


def test_the_schema_is_that_of_the_parameters():
    made = runpy.run_path(str(ROOT / "scripts" / "layout_schema.py"))
    text = made["schema_text"]()
    assert made["FILE"].read_text(encoding="utf-8") == text, "run: python scripts/layout_schema.py"
    told = json.loads(text)["definitions"]["sensor"]
    assert told["properties"].keys() == KEYS.keys()
    for of_kind, kind in zip(told["allOf"], KINDS.values(), strict=True):
        parameters = of_kind["then"]["properties"]["parameters"]["properties"]
        assert parameters.keys() == specs(kind.parameters).keys()


# Lines of values

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
