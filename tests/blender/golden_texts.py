# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts of the golden files: readings of sample homes, and the output of verbs on them."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import day_home
from golden_bench import ROOT, SAMPLES, Bench, all_sensors, chosen, part
from test_places import Flat

# --- the story of the Ängen home ----------------------------------------------------------------


def _story(bench: Bench) -> dict[str, str]:
    bench.open("angen")
    names = chosen(*(s.name for s in all_sensors() if s.kind.identifier != "LIGHT"))
    report, samples = bench.folder / "report.html", bench.folder / "samples"
    start = "2026-03-02T21:30"
    ran = bench.run(
        "simulate", "--quiet", *names, "--report", report, "--samples", samples, "--start", start
    )
    assert ran.status == 0, ran.err
    files = {"events": ran.out, "report": page_text(bench.written("report.html"))}
    return files | {path.stem: bench.written(f"samples/{path.name}") for path in samples.iterdir()}


def story(bench: Bench, *kinds: str) -> str:
    """Return the event log of the whole story, with rows of some kinds only."""
    rows = bench.once("story", partial(_story, bench))["events"].splitlines(keepends=True)
    return "".join([rows[0], *(row for row in rows[1:] if row.split(",")[3] in kinds)])


def story_samples(bench: Bench, sensor: str, first: int, last: int) -> str:
    """Return the samples of one sensor between two times of the story."""
    rows = bench.once("story", partial(_story, bench))[sensor].splitlines(keepends=True)
    return "".join(_until(rows, last, first))


def _until(rows: list[str], last: float, first: float = 0.0) -> list[str]:
    """Return the header, and the rows of a table between two times (s)."""
    return [rows[0], *(row for row in rows[1:] if first <= float(row.split(",")[0]) < last)]


def story_report(bench: Bench) -> str:
    return str(bench.once("story", partial(_story, bench))["report"])


def page_text(page: str) -> str:
    """Return the text of a report: a line for each row of a table and each text of a picture.

    Leaves out the style sheet, titles of pictures' parts, and the versions in the last line.
    """
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    for parent in list(root.iter()):
        for child in list(parent):
            if re.sub(r"{.*}", "", child.tag) in ("style", "title", "footer"):
                parent.remove(child)
    return "".join(f"{line}\n" for line in _lines(root))


def _lines(element: Any) -> Iterator[str]:
    name = re.sub(r"{.*}", "", element.tag)
    if name == "tr":
        yield " | ".join(" ".join("".join(cell.itertext()).split()) for cell in element)
    elif name in ("p", "text", "h1", "h2", "dt", "dd", "figcaption"):
        yield " ".join("".join(element.itertext()).split())
    else:
        assert not (element.text or "").strip(), f"text in <{name}>: {element.text}"
        for child in element:
            yield from _lines(child)


# --- light --------------------------------------------------------------------------------------


def events(bench: Bench, home: str, *runs: tuple[str, ...]) -> str:
    """Return the event logs of runs, each of some frames and sensors: (frames, sensor …)."""
    bench.open(home)
    rows: list[str] = []
    for frames, *sensors in runs:
        ran = bench.run("simulate", "--quiet", "--frames", frames, *chosen(*sensors))
        assert ran.status == 0, ran.err
        rows += ran.out.splitlines(keepends=True)[bool(rows) :]
    return "".join(rows)


def samples(bench: Bench, home: str, frames: str, sensor: str, *others: str) -> str:
    """Return the samples of a sensor in some frames, simulated together with the others."""
    bench.open(home)
    where = bench.folder / f"samples of {home}"
    given = (*chosen(sensor, *others), "--frames", frames, "--samples", where)
    ran = bench.run("simulate", "--quiet", *given)
    assert ran.status == 0, ran.err
    return bench.written(f"{where.name}/{sensor}.csv")


# --- a room with every kind of sensor -------------------------------------------------------------


def room(bench: Bench) -> None:
    """Make a room with a sensor of every kind: a box walks, a door turns and a lamp goes on."""
    world = bench.new_world()
    day_home.build(world)
    world.scene.frame_end, world.scene.angen_seed, world.scene.angen_live = 96, 3, False
    # The warm-up would last the whole run.
    bpy.data.objects["warm"].angen_sensor.pir.warm_up_time = 0.0
    bpy.data.objects["lux"].angen_sensor.light.samples = 16_384
    tof = world.sensor("DISTANCE", "tof", update_rate=10.0, zones_across=2, rays=3, threshold=2.0)
    tof.location, tof.rotation_euler = (-2.9, 0.1, 1.0), (1.5708, 0, -1.5708)
    few = {"columns": 4, "rows": 3, "horizontal_fov": 1.0, "vertical_fov": 0.8, "netd": 0.1}
    eye = world.sensor("THERMAL_ARRAY", "eye", update_rate=2.0, hold_time=1.0, **few)
    eye.location, eye.rotation_euler = (-2.9, 0.1, 1.3), (1.5708, 0, -1.5708)
    magnet = world.link("magnet", None, (2.03, 1.38, 1.9))
    door = bpy.data.objects["door"]
    world.update()
    magnet.parent, magnet.matrix_parent_inverse = door, door.matrix_world.inverted()
    reed = world.sensor("CONTACT", "reed", update_rate=10.0)
    reed.location, reed.angen_sensor.contact.magnet = (2.03, 1.39, 1.9), magnet
    swept = world.switch("swept", swept=True, range_max=1.0, threshold=0.6, aperture_rays=1)
    swept.location, swept.rotation_euler = (2.0, 1.9, 1.0), (-1.5708, 0, 0)
    walk = {1: (-1.2, 0, 0.85), 24: (-1.2, 0, 0.85), 60: (0.6, 0.2, 0.85), 96: (0.6, 0.2, 0.85)}
    world.key(bpy.data.objects["anna"], "location", walk)
    world.key(door, "rotation_euler", {1: (0, 0, 0), 12: (0, 0, 0), 24: (0, 0, -0.6)})
    world.key(bpy.data.lights["lamp"], "energy", {1: 0.0, 30: 60.0}, "CONSTANT")
    world.key(bpy.data.lights["lamp 2"], "energy", {1: 5.0}, "CONSTANT")
    world.update()
    # Verbs need the home as a file.
    bpy.ops.wm.save_as_mainfile(filepath=str(bench.folder / "room.blend"))


def _room(bench: Bench) -> dict[str, str]:
    room(bench)
    where = bench.folder / "samples of room"
    # Each version of Blender reads other light, so the light has its own file.
    names = [s.name for s in all_sensors() if s.name != "lux"]
    chosen = [text for name in names for text in ("--sensor", name)]
    ran = bench.run("simulate", "--quiet", "--samples", where, *chosen)
    assert ran.status == 0, ran.err
    files = {path.stem: bench.written(f"{where.name}/{path.name}") for path in where.iterdir()}
    return {"events": ran.out, **files}


def room_events(bench: Bench) -> str:
    return str(bench.once("room", partial(_room, bench))["events"])


def room_samples(bench: Bench) -> str:
    """Return every fourth sample of each sensor, one sensor after the other."""
    found = bench.once("room", partial(_room, bench))
    texts = []
    for name in sorted(found.keys() - {"events"}):
        rows = found[name].splitlines(keepends=True)
        texts.append(f"{name}\n{''.join(rows[:1] + rows[1::4][:24])}")
    return "\n".join(texts)


# --- a morning in each sample home ----------------------------------------------------------------

MONDAY = date(2026, 3, 2)


class Morning(NamedTuple):
    """A stretch of a Monday that is simulated, in s since midnight."""

    home: str
    routine: str
    first: float
    last: float

    @property
    def between(self) -> tuple[str, str]:
        """The first and last time in the form of a day's tables."""
        ends = [f"{int(t // 3600):02}:{int(t // 60 % 60):02}" for t in (self.first, self.last)]
        return f"{MONDAY}T{ends[0]}", f"{MONDAY}T{ends[1]}"


# The resident gets up and sits down; in the atelier both get up and use the bathroom.
ANGEN = Morning("angen", "week.toml", 23_520.0, 24_720.0)
ATELIER = Morning("atelier", "atelier_week.toml", 24_930.0, 25_410.0)


def _tables(morning: Morning, bench: Bench) -> dict[str, str]:
    """Return the tables of the day, simulated without light, because Cycles takes minutes."""
    bench.open(morning.home)
    run = part("residents.blender.run")
    sensors = [sensor for sensor in all_sensors() if sensor.kind.identifier != "LIGHT"]
    plan = run.Plan.read(SAMPLES / morning.routine)
    household = run.HouseholdDays(bpy.context.scene, sensors, plan, MONDAY, 1)
    with household.keyed() as keys:
        lived = household.run(0, keys, (morning.first, morning.last))
        while True:
            try:
                next(lived)
            except StopIteration as end:
                day = end.value
                break
    files: dict[str, str] = part("residents.days.rows").DayRows.joined([day]).files()
    return {name: bench.plain(text) for name, text in files.items()}


def day(bench: Bench, morning: Morning, table: str) -> str:
    """Return the rows of a day's table within the morning."""
    tables = bench.once(f"day in {morning.home}", partial(_tables, morning, bench))
    first, last = morning.between
    rows = tables[table].splitlines(keepends=True)
    end = 1 if table == "activities.csv" else 0
    return "".join([rows[0], *(r for r in rows[1:] if r.split(",")[end] >= first and r < last)])


# --- verbs ----------------------------------------------------------------------------------------


def listing(bench: Bench, home: str) -> str:
    bench.open(home)
    return bench.run("list", "--json").out


def verbs(bench: Bench, home: str, *commands: str) -> str:
    """Return the output of these commands on a home."""
    bench.open(home)
    return "\n".join(bench.transcript(*_words(command)) for command in commands)


def _words(command: str) -> list[str]:
    """Split a command at spaces, but not in names in quotation marks."""
    return [a or b for a, b in re.findall(r'"([^"]+)"|(\S+)', command)]


def doctor(bench: Bench) -> str:
    texts = []
    for home in ("angen", "atelier", "pressure", "light", "light_control"):
        bench.open(home)
        texts.append(bench.transcript("doctor").replace("doctor", f"doctor {home}.blend", 1))
    return "\n".join(texts)


def places(bench: Bench) -> str:
    """Return places in a flat of two rooms: until its door is marked, the bed cannot be reached."""
    flat = Flat(bench.new_world())
    flat.chair.angen_place.use, flat.bed.angen_place.use = "SIT", "LIE"
    door = flat.door()
    bpy.ops.wm.save_as_mainfile(filepath=str(bench.folder / "flat.blend"))
    shut = bench.transcript("places")
    door.angen_place.use = "DOOR"
    return f"{shut}\n{bench.transcript('places')}\n{bench.transcript('places', '--json')}"


def coverage_map(bench: Bench) -> str:
    bench.open("angen")
    path = bench.folder / "coverage.csv"
    ran = bench.run("coverage", "--quiet", "--room", "hall", "--cell", "0.4", "--csv", path)
    assert ran.status == 0, ran.err
    return bench.written(path.name)


def explanations(bench: Bench, *asked: tuple[str, float]) -> str:
    """Return explanations in the open home: of the last event by a time, and of its reading."""
    texts = []
    for sensor, time in asked:
        given = ("explain", "--quiet", "--sensor", sensor, "--time", f"{time:g}")
        texts += [bench.transcript(*given), bench.transcript(*given, "--now")]
    return "\n".join(texts)


def explain(bench: Bench, home: str, *asked: tuple[str, float]) -> str:
    bench.open(home)
    return explanations(bench, *asked)


def explain_room(bench: Bench, *asked: tuple[str, float]) -> str:
    room(bench)
    return explanations(bench, *asked)


def apply_layout(bench: Bench) -> str:
    """Return the output of `apply`, and the settings of one of the home's seven detectors."""
    bench.open("angen")
    layout = ROOT / "docs" / "examples" / "casas_ceiling.json"
    said = bench.transcript("apply", layout, "--save", bench.folder / "applied.blend")
    (changed,) = [s for s in json.loads(bench.run("list", "--json").out) if s["name"] == "PIR hall"]
    return f"{said}\n{json.dumps(changed, indent=1, ensure_ascii=False)}\n"


def check(bench: Bench) -> str:
    """Return the differences of a log with one value and one time changed."""
    bench.open("angen")
    given = ("--frames", "1:300", "--sensor", "PIR hall")
    log = bench.run("simulate", "--quiet", *given).out
    path = bench.folder / "expected.csv"
    path.write_text(log, encoding="utf-8")
    same = bench.transcript("check", path, "--quiet", *given)
    rows = log.splitlines(keepends=True)
    rows[2], rows[5] = rows[2].replace(",1\n", ",0\n"), f"1{rows[5]}"
    path.write_text("".join(rows), encoding="utf-8")
    return f"{same}\n{bench.transcript('check', path, '--quiet', *given)}"


FAULTS = """\
seed = 7
[[fault]]
lost = 0.05
clock_drift_ppm = [-50, 50]
[[fault]]
kinds = ["PIR"]
late = 0.05
late_by = [0.5, 10]
false_alarms_per_day = 900
false_alarm_lasts = [1, 3]
[[fault]]
sensors = "Switch*"
doubled = 0.5
"""


def _short_log(bench: Bench, seconds: float) -> Path:
    """Return the first seconds of the story's log."""
    rows = story(bench, "PIR", "OPTICAL_SWITCH", "PRESSURE").splitlines(keepends=True)
    path = bench.folder / "log.csv"
    path.write_text("".join(_until(rows, seconds)), encoding="utf-8")
    return path


def converted(bench: Bench, kind: str, name: str, seconds: float) -> str:
    """Return the log in a format of other tools; of a folder, its files one after the other."""
    log, out = _short_log(bench, seconds), bench.folder / name
    ran = bench.run("convert", log, "--format", kind, "--out", out, without_blender=True)
    assert ran.status == 0, ran.err
    files = sorted(out.iterdir()) if out.is_dir() else [out]
    names = [path.relative_to(bench.folder).as_posix() for path in files]
    texts = [f"{name}\n{bench.written(name)}" for name in names]
    return "\n".join(texts) if out.is_dir() else bench.written(names[0])


def faulty(bench: Bench) -> str:
    """Return the changes of a log by faults, and the output of `compare` on both logs."""
    log, told = _short_log(bench, 25.0), bench.folder / "faults.toml"
    told.write_text(FAULTS, encoding="utf-8")
    out, truth = bench.folder / "faulty.csv", bench.folder / "truth.csv"
    given = ("--format", "events", "--out", out, "--faults", told, "--truth", truth)
    said = bench.transcript("convert", log, *given, without_blender=True)
    compared = bench.transcript("compare", log, out, without_blender=True)
    return f"{said}\n{compared}\n{bench.written('truth.csv')}"


def help_of(bench: Bench, *words: str, without_blender: bool = False) -> str:
    """Return the help of a verb.

    Python versions break the lines of the usage differently, so it is joined to one line.
    """
    ran = bench.run(*words, "--help", without_blender=without_blender)
    assert ran.status == 0, ran.err
    usage, blank, rest = ran.out.partition("\n\n")
    return " ".join(usage.split()) + blank + rest
