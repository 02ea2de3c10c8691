# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/hard_cases.md: every hard case with its test, its tolerance and the measured error.

python scripts/hard_cases.py          runs the tests and writes docs/data/hard_cases.json too
python scripts/hard_cases.py --page   the page alone, from the data

The tests of tests/blender/test_hard_cases.py note their cases. Those of other tests are listed
below, with the figures that they note by the fixture `figure`. Some figures of the pressure sensor
come from its benchmark (docs/data/pressure.json).
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "hard_cases.md"
DATA = ROOT / "docs" / "data" / "hard_cases.json"
PRESSURE = ROOT / "docs" / "data" / "pressure.json"
OWN = "tests/blender/test_hard_cases.py"
BLENDER, PURE = "tests/blender/", "tests/pure/"
FAILS = "**fails**"
# Family, case, tolerance, test, and the scene of the pressure benchmark that has the figure.
OTHERS = (
    ("Place and size", "a room in centimetres, with and without units: a range", "5e-06 m",
     BLENDER + "test_room.py::test_every_range_in_a_room_in_centimetres", ""),
    ("Edges", "a beam exactly into the joint of two panels: its range", "5e-06 m",
     BLENDER + "test_room.py::test_a_beam_into_the_joint_of_two_panels_does_not_leak", ""),
    ("Edges", "back faces, glass: the range of a beam that they stop", "5e-06 m",
     BLENDER + "test_room.py::test_backfaces_stop_the_beam", ""),
    ("Edges", "a sensor within its own housing, to 10 km from the origin: a range", "0.002 m",
     BLENDER + "test_room.py::test_the_housing_of_a_parented_sensor", ""),
    ("Thin and fast", "a slanted card far from its own origin: a range", "5e-06 m",
     BLENDER + "test_room.py::test_a_slanted_card_far_from_its_origin", ""),
    ("Thin and fast", "a card of 1 cm at 1 m/s between two frames", "missed at 24 fps, as is true",
     BLENDER + "test_time.py::test_a_card_between_two_frames_is_missed_without_substeps", ""),
    ("Thin and fast", "the same with substeps", "found",
     BLENDER + "test_time.py::test_a_card_between_two_frames_is_found_with_substeps", ""),
    ("Thin and fast", "the same, swept, at the very update", "found",
     BLENDER + "test_swept_switch.py::test_a_card_between_two_frames_is_caught", ""),
    ("Thin and fast", "swept flags of 10 µm to 10 cm, 0.05 to 20 m/s, at any moment", "all found",
     BLENDER + "test_swept_switch.py::"
     "test_flags_of_any_width_and_speed_are_caught_at_any_moment", ""),
    ("Thin and fast", "boxes that fly and swing, swept, against 64 substeps", "the same breaks",
     BLENDER + "test_swept_switch.py::test_random_flags_against_64_substeps", ""),
    ("Thin and fast", "a swept flag mirrored, scaled, 10 km from the origin", "found",
     BLENDER + "test_swept_switch.py::test_mirrored_and_scaled_and_far_away", ""),
    ("Thin and fast", "a door flung by 40° a frame: its edge, 0.1 mm inside", "found",
     BLENDER + "test_swept_switch.py::test_the_edge_of_a_door_that_is_flung", ""),
    ("Thin and fast", "a flag's edge that shakes by ± 0.04 mm", "one ray toggles, nine do not",
     PURE + "test_optical_switch.py::test_a_vibrating_edge_toggles_one_ray_and_not_nine", ""),
    ("Shape", "an armature's mesh: a range", "2e-05 m",
     BLENDER + "test_ray_layer.py::test_armature", ""),
    ("Shape", "random scenes that change, with and without instances: a range", "2e-05 m",
     BLENDER + "test_ray_layer.py::test_same_ranges_as_scene_ray_cast", ""),
    ("Shape", "visibility that is keyed", "followed at the frame",
     BLENDER + "test_room.py::test_keyed_visibility_is_followed", ""),
    ("Time", "a jump of the playhead", "no movement",
     BLENDER + "test_time.py::test_a_jump_is_never_movement", ""),
    ("Time", "two runs, and a part of a run", "equal to the bit",
     BLENDER + "test_time.py::test_two_runs_are_equal_to_the_bit", ""),
    ("Not a number", "a sensor at NaN", "refused by name",
     BLENDER + "test_time.py::test_a_sensor_at_nan_is_refused_by_name", ""),
    ("Pressure", "1 kg on 1000 kg", "2% of the weight",
     BLENDER + "test_pressure_shapes.py::test_mass_ratios", "1 kg on 1000 kg"),
    ("Pressure", "1 g to 500 kg", "0.1%",
     BLENDER + "test_pressure_shapes.py::test_masses", "box of 0.001 kg"),
    ("Pressure", "2 km from the origin", "0.5%",
     BLENDER + "test_pressure_shapes.py::test_far_from_the_origin",
     "two boxes 2 km from the origin"),
    ("Pressure", "a pad 0.1 mm thin", "0.1%",
     BLENDER + "test_pressure_shapes.py::test_thin_pads", "pad 0.1 mm thin"),
    ("Pressure", "a virtual pad that the box goes through", "0.1%",
     BLENDER + "test_pressure_statics.py::test_a_box_at_rest",
     "virtual pad that the box goes through"),
    ("Pressure", "active mesh shapes", "0.1%",
     BLENDER + "test_pressure_shapes.py::test_every_shape_at_rest", "mesh of 5 kg"),
    ("Pressure", "a drop of 2 m, 24 fps: its impulse", "0.2%",
     BLENDER + "test_pressure_motion.py::test_impulse_of_a_drop", "2 kg from 2 m, e = 0.5, 24 fps"),
    ("Pressure", "a sitter sunk 5 cm into the seat: the worst leg", "3%",
     BLENDER + "test_pressure_carried.py::test_a_sitter_on_a_chair",
     "70 kg on a chair, aside, sunk 5 cm into the seat"),
    ("Pressure", "a sitter farther above the seat than the tolerance", "valid = 0",
     BLENDER + "test_pressure_carried.py::test_hovering_is_not_a_silent_zero", ""),
    ("Pressure", "a teleport: its spike", "1% of the weight",
     BLENDER + "test_pressure_carried.py::test_a_teleport_is_no_spike", ""),
    ("Pressure", "random piles", "0.5%",
     BLENDER + "test_pressure_shapes.py::test_random_piles",
     "100 random piles of 6 bodies (5 came to rest: 124 frames)"),
    ("Pressure", "20,000 random islands of up to 6 bodies, that can be in balance or not; masses, "
     "stiffnesses and sizes that differ by up to 1000: solved", "all settle",
     PURE + "test_balance.py::test_every_island_settles", ""),
    ("Light", "a white sphere: light that bounces many times", "2%",
     BLENDER + "test_light_closed_form.py::test_inside_a_white_sphere_light_goes_round", ""),
    ("Light", "far from the origin, 10 km", "3%",
     BLENDER + "test_light_closed_form.py::test_far_from_the_origin_it_is_right", ""),
    ("Light", "too far from the origin", "refused",
     BLENDER + "test_light_closed_form.py::test_too_far_from_the_origin_is_refused", ""),
    ("Light", "negative lamps", "not below dark",
     BLENDER + "test_light_closed_form.py::"
     "test_negative_lamps_take_light_away_but_not_below_dark", ""),
    ("Light", "colours that are no numbers", "left out",
     BLENDER + "test_light_closed_form.py::test_colours_that_are_no_numbers_are_left_out", ""),
)  # fmt: skip
HEAD = """\
# Hard cases

After this page you know how exact each difficult case is, and the test that shows it.

Written by `python scripts/hard_cases.py`; do not edit. Each is a test that fails above its
tolerance; *measured* is the worst that was found in {blender}. *Held*: the test passes, and
there is no figure in it. Far places are those that single precision can tell apart there: Blender
stores where an object is in no more.
"""


def main() -> None:
    if "--page" not in sys.argv[1:]:
        DATA.parent.mkdir(exist_ok=True)
        text = json.dumps(measured(), indent=1, ensure_ascii=False)
        DATA.write_text(text + "\n", encoding="utf-8")
    PAGE.write_text(page(json.loads(DATA.read_text(encoding="utf-8"))), encoding="utf-8")


def measured() -> dict[str, Any]:
    """Run the tests; return the rows of the page, including those of failing tests."""
    nodes = [OWN, *dict.fromkeys(test for *_, test, _ in OTHERS)]
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.xml")
        command = [sys.executable, "-m", "pytest", "-q", "-o", "junit_family=xunit1"]
        done = subprocess.run([*command, f"--junitxml={report}", *nodes], cwd=ROOT)
        if done.returncode > 1:
            raise SystemExit("the tests could not be run: see above")
        cases = list(ElementTree.parse(report).iter("testcase"))
    rows = []
    outcome: dict[str, str] = {}
    figures: dict[str, list[str]] = {}
    for case in cases:
        name = str(case.get("name")).partition("[")[0]
        failed = case.find("failure") is not None or case.find("error") is not None
        if case.find("skipped") is None and outcome.get(name) != FAILS:
            outcome[name] = FAILS if failed else "held"
        for noted in case.iter("property"):
            if noted.get("name") == "figure":
                figures.setdefault(name, []).append(str(noted.get("value")))
                continue
            family, what, figure, tolerance = str(noted.get("value")).split("\t")
            figure = f"{figure.strip()} ({FAILS})" if failed else figure.strip()
            rows.append([family, what, figure, tolerance.strip(), f"{OWN}::{name}"])
    for family, what, tolerance, test, _ in OTHERS:
        function = test.partition("::")[2]
        held = outcome.get(function, "not run")
        if held == "held" and function in figures:
            held = _worst(figures[function])
        rows.append([family, what, held, tolerance, test])
    return {"blender": _blender(), "rows": rows}


def _worst(noted: list[str]) -> str:
    """Return the greatest number with its unit that a test noted, or else its last text."""
    numbers = [value.partition("\t") for value in noted if "\t" in value]
    if not numbers:
        return noted[-1]
    number, _, unit = max(numbers, key=lambda value: float(value[0]))
    return f"{float(number):.2g} {unit}".strip()


def _blender() -> str:
    """Return the version of Blender."""
    import bpy

    return f"Blender {bpy.app.version_string}"


def page(data: dict[str, Any]) -> str:
    """Return the text of docs/hard_cases.md."""
    figures = _pressure()
    of_test = {(test, name): scene for _, name, _, test, scene in OTHERS}
    text = HEAD.format(blender=data["blender"])
    for family in dict.fromkeys(row[0] for row in data["rows"]):
        text += (
            f"\n## {family}\n\n| case | measured | tolerance | test |\n| --- | --- | --- | --- |\n"
        )
        for _, name, figure, tolerance, test in (r for r in data["rows"] if r[0] == family):
            scene = of_test.get((test, name), "")
            path, _, function = test.partition("::")
            link = f"[{function}](../{path})"
            shown = figures.get(scene, figure) if figure == "held" else figure
            text += f"| {name} | {shown} | {tolerance} | {link} |\n"
    return text


def _pressure() -> dict[str, str]:
    """Return the relative errors of the pressure benchmark's scenes."""
    rows = json.loads(PRESSURE.read_text(encoding="utf-8"))["accuracy"]
    return {row["scene"]: f"{row['error']:.1e} of the force" for row in rows}


if __name__ == "__main__":
    main()
