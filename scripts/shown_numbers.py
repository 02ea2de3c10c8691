# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare every number that the window shows of a recorded home with the exported CSV files.

blender -b home.blend --python scripts/shown_numbers.py -- EVENTS.csv SAMPLES [REPORT.csv]

Export Events and Export Samples write these files from the recording in the home; missing files are
exported first. At many frames this script draws the panels, the table, the labels and Explain by
their own functions into a layout that records the texts. It compares each number and each state
with the CSV row of that frame, to half of the last digit shown. A value that the CSV has and the
text omits counts as a difference. It prints the number of comparisons and each difference, and
exits with 1 if there is any.
"""

from __future__ import annotations

import csv
import math
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import bpy

ADDON = "bl_ext.user_default.angen_sensors"
EVERY = 400
# How many events of each sensor are visited, and how many are explained.
EVENTS_VISITED, EVENTS_EXPLAINED = 8, 2
NUMBER = re.compile(
    r"(?P<number>-?\d+(?:\.\d+)?) ?(?P<unit>% of threshold|%|lx|N\b|°|MΩ|kΩ|Ω|cm\b|m\b|V\b|s ago)"
)
FACTORS = {"MΩ": 1e6, "kΩ": 1e3, "cm": 0.01, "°": math.radians(1.0), "% of threshold": 0.01}
# The column of a kind's samples by the unit of a shown number.
COLUMNS = {
    "PIR": {"°": "angle_rad", "% of threshold": "signal"},
    "OPTICAL_SWITCH": {"m": "range_m", "cm": "range_m"},
    "PRESSURE": {"N": "force_n", "Ω": "resistance_ohm", "V": "voltage_v"},
    "LIGHT": {"%": "luminance_percent", "lx": "illuminance_lux"},
}
STATES = {
    "PIR": ("moved", "Motion", "Still"),
    "OPTICAL_SWITCH": ("open", "Open", "Closed"),
    "PRESSURE": ("pressed", "Pressed", "Free"),
    "LIGHT": ("lit", "Lit", "Dark"),
}
# The facts of Explain that are readings; those of a detector are ranges, which no log has.
EXPLAINED = {
    "OPTICAL_SWITCH": ("Now", "Before"),
    "PRESSURE": ("Force", "Before"),
    "LIGHT": ("Reading", "Before"),
}


class Row(NamedTuple):
    """A comparison of the text that is `shown` with the value in the `csv`."""

    frame: float
    sensor: str
    place: str
    shown: str
    csv: str
    same: bool


class RecordingLayout:
    """A layout that records the texts drawn into it."""

    def __init__(self, texts: list[str]) -> None:
        object.__setattr__(self, "texts", texts)

    def __setattr__(self, name: str, value: Any) -> None: ...

    def label(self, text: str = "", **_: Any) -> None:
        self.texts.append(text)

    def operator(self, idname: str, text: str = "", **_: Any) -> Any:
        self.texts.append(text)
        return SimpleNamespace()

    def prop(self, *_: Any, **__: Any) -> None: ...

    def panel(self, *_: Any, **__: Any) -> tuple[RecordingLayout, RecordingLayout]:
        return self, self

    def __getattr__(self, name: str) -> Any:
        return lambda *_, **__: self


def part(name: str) -> Any:
    """Return a module of the extension."""
    return import_module(f"{ADDON}.{name}")


class ExportedLog:
    """The exported files: the samples and events of each sensor."""

    def __init__(self, events: Path, samples: Path) -> None:
        with open(events, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.events: dict[str, list[dict[str, str]]] = defaultdict(list)
        for row in rows:
            self.events[row["sensor"]].append(row)
        names = part("sensor_logic.logs.files").file_names(self.events)
        self.samples: dict[str, list[dict[str, str]]] = {}
        for sensor, name in names.items():
            with open(samples / name, newline="", encoding="utf-8") as file:
                self.samples[sensor] = list(csv.DictReader(file))

    def at(self, sensor: str, frame: float) -> dict[str, str]:
        """Return the sample of a sensor at a frame."""
        return [row for row in self.samples[sensor] if float(row["frame"]) <= frame + 1e-4][-1]

    def event_frames(self, sensor: str, kind: str) -> list[float]:
        """Return the frames at which a state changed, or, without a state, a measured value."""
        numbers = {"force_n", "luminance_percent", "illuminance_lux"}
        first = float(self.samples[sensor][0]["frame"])
        later = [row for row in self.events[sensor] if float(row["frame"]) > first]
        states = {float(row["frame"]) for row in later if row["field"] not in numbers}
        return sorted(states or {float(row["frame"]) for row in later})

    def last_event(self, sensor: str, frame: float) -> float:
        """Return the frame of a sensor's last event up to a frame."""
        return max(
            float(row["frame"]) for row in self.events[sensor] if float(row["frame"]) <= frame
        )


class Comparison:
    """The comparisons made so far, and the log to compare with."""

    def __init__(self, log: ExportedLog) -> None:
        self.log = log
        self.rows: list[Row] = []

    def note(self, frame: float, sensor: Any, place: str, shown: str, csv: str, same: bool) -> None:
        """Add a comparison."""
        self.rows.append(Row(frame, sensor.name, place, shown, csv, same))

    def text(self, frame: float, sensor: Any, place: str, text: str, at: dict[str, str]) -> None:
        """Compare the state and numbers in a text.

        For a text without any, the CSV must have no value.
        """
        kind = sensor.kind.identifier
        field, active, idle = STATES[kind]
        word = text.split(",")[0]
        if word in (active, idle):
            wanted = active if at[field] == "1" else idle
            self.note(frame, sensor, place, word, wanted, word == wanted)
        found = list(NUMBER.finditer(text))
        for match in found:
            self.measured(frame, sensor, place, match, at)
        if not found and word not in (active, idle):
            self.note(frame, sensor, place, text, "a reading", at.get("valid") == "0")

    def measured(self, frame: float, sensor: Any, place: str, match: Any, at: Any) -> None:
        """Compare a number with a unit with its column."""
        unit, number = match["unit"], match["number"]
        if unit == "s ago":
            render = bpy.context.scene.render
            value = (frame - float(at["frame"])) * render.fps_base / render.fps
        else:
            column = COLUMNS[sensor.kind.identifier].get(unit.strip("kM") if "Ω" in unit else unit)
            cell = at.get(column or "", "")
            if not cell:
                self.note(frame, sensor, place, match[0], "nothing", False)
                return
            value = float(cell) / FACTORS.get(unit, 1.0)
        self.number(frame, sensor, place, match[0], number, value)

    def number(
        self, frame: float, sensor: Any, place: str, shown: str, number: str, value: float
    ) -> None:
        """Compare a number with a value, to half of its last digit.

        Where the window shows only the strength, the sign is ignored.
        """
        digits = len(number.partition(".")[2])
        value = abs(value) if "threshold" in shown else value
        # Resistances have three digits, with or without a decimal point.
        least = 10.0 ** (len(number) - 3) if "Ω" in shown and "." not in number else 1.0
        room = 0.5 * (least if least > 1.0 else 10.0**-digits) * (1 + 1e-6) + 1e-9
        self.note(frame, sensor, place, shown, f"{value:.6g}", abs(float(number) - value) <= room)

    def equal(self, frame: float, sensor: Any, place: str, shown: Any, csv: Any) -> None:
        """Compare two values for equality."""
        self.note(frame, sensor, place, str(shown), str(csv), shown == csv)


def compare_frame(found: Comparison, sensors: list[Any], frame: int) -> None:
    """Compare all texts at a frame, sensor by sensor."""
    context = bpy.context
    context.scene.frame_set(frame)
    for sensor in sensors:
        at = found.log.at(sensor.name, frame)
        context.view_layer.objects.active = sensor.object
        seen = part("angen_addon.view.readings").reading_text(sensor, context.scene)
        for place, text in (*table_texts(sensor), *label_texts(sensor, seen)):
            found.text(frame, sensor, place, text, at)
        compare_panel(found, sensor, frame, at)
        compare_events(found, sensor, frame)


def table_texts(sensor: Any) -> Iterator[tuple[str, str]]:
    """Yield the reading of a sensor's row in a narrow and a wide table."""
    context = bpy.context
    for place, width in (("table", 250), ("wide table", 400)):
        texts: list[str] = []
        region = SimpleNamespace(width=width)
        scale = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
        around = SimpleNamespace(
            region=region, preferences=scale, scene=context.scene, view_layer=context.view_layer
        )
        cls = part("panels.table").ANGEN_UL_sensors
        cls.draw_item(None, around, RecordingLayout(texts), None, sensor.object, 0, None, "")
        # Name, room (in a wide table) and reading; the active row also has a button.
        yield place, [text for text in texts if text][-1]


def label_texts(sensor: Any, seen: Any) -> Iterator[tuple[str, str]]:
    """Yield the texts of a sensor's label in the viewport."""
    texts = part("angen_addon.view.overlay.labels")._texts
    for place, full in (("label", False), ("full label", True)):
        yield place, texts(bpy.context, sensor.name, seen, full)[1]


def panel_texts(module: str, panel: str) -> list[str]:
    """Return the texts that a panel draws."""
    texts: list[str] = []
    getattr(part(module), panel).draw(SimpleNamespace(layout=RecordingLayout(texts)), bpy.context)
    return [text for text in texts if text]


def compare_panel(found: Comparison, sensor: Any, frame: int, at: dict[str, str]) -> None:
    """Compare the panel Active Sensor: the reading, its frame, and all values of a pad."""
    texts = panel_texts("panels.active_sensor", "ANGEN_PT_active_sensor")
    reading = texts.index(sensor.name) + 1
    # The label of the menu of presets comes in between.
    where = next(n for n in range(reading, len(texts)) if texts[n].startswith("Recorded at"))
    found.text(frame, sensor, "panel", texts[where - 1], at)
    found.equal(frame, sensor, "panel", float(texts[where].split()[-1]), float(at["frame"]))
    # Of two equal labels the first counts: the later ones are titles of sections.
    after = dict(reversed(list(zip(texts[where + 1 :], texts[where + 2 :], strict=False))))
    if sensor.kind.identifier != "PRESSURE":
        return
    names = ", ".join(filter(None, at["partners"].split(";"))) or "–"
    label = "Pressed By" if at["pressed"] == "1" else "On It"
    found.equal(frame, sensor, "Pressed By", after[label], names)
    for axis, column in (("X", "cop_x_m"), ("Y", "cop_y_m")):
        match = re.search(rf"{axis} (-?[\d.]+) cm", after["Centre"])
        if match is None or not at[column]:
            found.equal(frame, sensor, "Centre", after["Centre"], "–" if not at[column] else "")
        else:
            value = 100.0 * float(at[column])
            found.number(frame, sensor, "Centre", match[0], match[1], value)
    for name in ("Resistor", "Output"):
        if at.get("resistance_ohm" if name == "Resistor" else "voltage_v"):
            found.text(frame, sensor, name, after[name], at)
    found.equal(frame, sensor, "ADC", after["Output"].split("ADC ")[-1], at["adc"])


def compare_events(found: Comparison, sensor: Any, frame: int) -> None:
    """Compare the panel Events: how many have passed, and which one can be explained."""
    texts = panel_texts("panels.events", "ANGEN_PT_events")
    count = re.match(r"(\d+) of (\d+) events passed", texts[0])
    first = float(found.log.samples[sensor.name][0]["frame"])
    frames = [float(row["frame"]) for row in found.log.events[sensor.name]]
    frames = [at for at in frames if at > first]
    shown = (int(count[1]), int(count[2])) if count else ()
    found.equal(frame, sensor, "events", shown, (sum(f <= frame for f in frames), len(frames)))
    line = next((text for text in texts if text.startswith("Frame ")), "")
    match = re.match(r"Frame ([\d.]+) \(([\d.]+) s\):", line)
    last = found.log.last_event(sensor.name, frame)
    found.equal(frame, sensor, "event", float(match[1]) if match else math.nan, last)
    if match:
        seconds = float(found.log.at(sensor.name, float(match[1]))["time_s"])
        found.number(frame, sensor, "event's time", match[0], match[2], seconds)


def compare_explained(found: Comparison, sensor: Any, frame: float) -> None:
    """Compare Explain's text for the event at a frame: readings and named updates."""
    context, memory = bpy.context, part("angen_addon.explain.explain").MEMORY
    context.scene.frame_set(math.floor(frame + 1e-4), subframe=max(0.0, frame % 1.0))
    context.view_layer.objects.active = sensor.object
    bpy.ops.angen.explain("EXEC_DEFAULT")
    recording = part("angen_addon.recording.results").RESULTS.recording(context.scene)
    track = recording.track_of(sensor.uid)
    explanation = memory.recall(recording, sensor.uid, track.at(frame + 1e-4))
    at = found.log.at(sensor.name, frame)
    if explanation is None:
        found.equal(frame, sensor, "Explain", "nothing", "an explanation")
        return
    field, active, idle = STATES[sensor.kind.identifier]
    word = re.split(r"\W", explanation.headline)[0]
    found.equal(frame, sensor, "Explain", word, active if at[field] == "1" else idle)
    for name, text in explanation.facts:
        moment = re.search(r"frame ([\d.]+) \((-?[\d.]+) s\)", text)
        row = found.log.at(sensor.name, float(moment[1])) if moment else at
        if moment is not None:
            found.equal(frame, sensor, name, float(moment[1]), float(row["frame"]))
            found.number(frame, sensor, name, moment[0], moment[2], float(row["time_s"]))
        if name in EXPLAINED.get(sensor.kind.identifier, ()):
            # The reading comes first; a threshold or a place may follow.
            number = NUMBER.search(text)
            assert number is not None, text
            found.measured(frame, sensor, f"Explain, {name}", number, row)


def visited(log: ExportedLog, sensors: Iterable[Any], scene: Any) -> list[int]:
    """Return the frames to compare: every `EVERY` frames, and around some events."""
    frames = set(range(scene.frame_start, scene.frame_end + 1, EVERY)) | {scene.frame_end}
    for sensor in sensors:
        events = log.event_frames(sensor.name, sensor.kind.identifier)
        for frame in events[:: max(1, len(events) // EVENTS_VISITED)]:
            # The frame before the event has the state before it.
            frames |= {math.ceil(frame), max(math.ceil(frame) - 1, scene.frame_start)}
    return sorted(frames)


def main(events: Path, samples: Path, report: Path | None = None) -> int:
    scene = bpy.context.scene
    if not events.exists():
        bpy.ops.angen.export_events(filepath=str(events))
        bpy.ops.angen.export_samples(directory=str(samples.parent), folder=samples.name)
    sensors = part("angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
    found = Comparison(ExportedLog(events, samples))
    for frame in visited(found.log, sensors, scene):
        compare_frame(found, sensors, frame)
    for sensor in sensors:
        for event in found.log.event_frames(sensor.name, "")[:EVENTS_EXPLAINED]:
            compare_explained(found, sensor, event)
    if report is not None:
        with open(report, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([Row._fields, *found.rows])
    wrong = [row for row in found.rows if not row.same]
    for row in wrong[:50]:
        print("differs:", *row[:5], sep=" | ")
    print(f"compared {len(found.rows)}, differing {len(wrong)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*[Path(text).absolute() for text in sys.argv[sys.argv.index("--") + 1 :]]))
