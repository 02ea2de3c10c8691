# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of golden files: for each file in tests/golden the function that gives its text.

`test_golden.py` compares the texts with the files, and writes the files for `make golden`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import golden_texts as texts
from golden_bench import Bench, part
from golden_texts import ANGEN, ATELIER


class Close(NamedTuple):
    """The tolerance of numbers, as a share and as a difference, against the golden file.

    Attributes
    ----------
    columns : tuple of str
        The columns of a CSV that the tolerance applies to; all others are compared exactly. Without
        any, it applies to each number of the text.
    """

    relative: float = 0.0
    absolute: float = 0.0
    columns: tuple[str, ...] = ()


EXACT = Close()
# Contact forces: single-precision poses differ in their last bits between versions of Blender.
# Relative differences of the forces were 1e-7 between 4.2, 4.5 and 5.2.
FORCE = Close(1e-5, 1e-5, ("value", "force_n", "cop_x_m", "cop_y_m", "residual"))
# Cycles: each version traces other paths, and a reading has the noise of its few samples: up to 2.4
# % between 4.2, 4.5 and 5.2. The resistor behind the sensor follows the reading.
LIGHT = Close(0.05, 0.01, ("value", "illuminance_lux", "resistance_ohm", "voltage_v"))
# Texts show rounded numbers, also whole percents.
LIGHT_TEXT = Close(0.05, 1.0)
# Sums and small matrices: their last digits depend on the processor.
ROUNDING = Close(1e-6, 1e-6)


@dataclass(frozen=True)
class Case:
    """A golden file: the function that gives its text, and how closely its numbers must agree."""

    text: Callable[[Bench], str]
    close: Close = EXACT


def _case(close: Close, make: Callable[..., str], *given: Any, **more: Any) -> Case:
    return Case(lambda bench: make(bench, *given, **more), close)


PADS = ("Pad front left", "Pad stack", "Pad drop")
# The lamp in the bathroom is on.
LIT = ("2401:2401", "Light sensor bathroom", "Light sensor hall")

CASES: dict[str, Case] = {
    "story_motion.csv": _case(EXACT, texts.story, "PIR"),
    "story_switches.csv": _case(EXACT, texts.story, "OPTICAL_SWITCH"),
    "story_pad.csv": _case(FORCE, texts.story, "PRESSURE"),
    "story_report.txt": _case(EXACT, texts.story_report),
    "story_samples_motion.csv": _case(EXACT, texts.story_samples, "PIR hall", 0, 20),
    "story_samples_pad.csv": _case(FORCE, texts.story_samples, "Pressure sofa", 72, 90),
    "story_light.csv": _case(LIGHT, texts.events, "angen", LIT),
    # Without the light in the living room, whose 64 samples read 36 % in 4.2, and 46 % in 4.5 and
    # 5.2.
    "atelier_still.csv": _case(
        LIGHT,
        texts.events,
        "atelier",
        ("1:11", "Light bath", "Mat of Karin", "PIR living", "Switch Front door"),
    ),
    "pressure.csv": _case(FORCE, texts.events, "pressure", ("1:240", *PADS)),
    "pressure_samples.csv": _case(FORCE, texts.samples, "pressure", "1:40", "Pad front right"),
    "light.csv": _case(LIGHT, texts.events, "light", ("1:20",)),
    "light_control.csv": _case(
        LIGHT, texts.events, "light_control", ("1:715", "PIR room"), ("100:150",)
    ),
    "light_control_samples.csv": _case(
        LIGHT, texts.samples, "light_control", "100:200", "Light sensor room", "PIR room"
    ),
    "room.csv": _case(ROUNDING, texts.room_events),
    "room_samples.txt": _case(ROUNDING, texts.room_samples),
    "room_explain.txt": _case(
        EXACT,
        texts.explain_room,
        *(("scan", 1.5), ("warm", 2.0), ("switch", 2.0), ("swept", 1.0), ("pad", 3.0)),
        *(("tof", 2.0), ("reed", 1.0), ("eye", 2.0)),
    ),
    "room_light_explain.txt": _case(LIGHT_TEXT, texts.explain_room, ("lux", 2.0)),
    "angen_list.json": _case(EXACT, texts.listing, "angen"),
    "atelier_list.json": _case(EXACT, texts.listing, "atelier"),
    "angen_list.txt": _case(EXACT, texts.verbs, "angen", "list"),
    "angen_explain.txt": _case(
        EXACT,
        texts.explain,
        "angen",
        *(("PIR hall", 2.9), ("PIR kitchen", 49.3), ("Switch entrance", 5), ("Switch kitchen", 24)),
        ("Pressure sofa", 78),
    ),
    "light_explain.txt": _case(
        LIGHT_TEXT, texts.explain, "light", ("Light sensor area", 1), ("Light sensor spot", 2)
    ),
    "pressure_explain.txt": _case(
        EXACT, texts.explain, "pressure", ("Pad front left", 2), ("Pad drop", 1)
    ),
    "angen_coverage.csv": _case(EXACT, texts.coverage_map),
    "angen_coverage.txt": _case(
        EXACT,
        texts.verbs,
        "angen",
        "coverage --quiet --cell 0.5",
        'place --quiet --room "living room" --count 2 --cell 0.5',
    ),
    "places.txt": _case(ROUNDING, texts.places),
    "angen_apply.txt": _case(EXACT, texts.apply_layout),
    "angen_check.txt": _case(EXACT, texts.check),
    "doctor.txt": _case(EXACT, texts.doctor),
    "wrong_words.txt": _case(
        EXACT,
        texts.verbs,
        "light",
        "simulat",
        "simulate --frames 9:1",
        "simulate --sensor Ligth",
        "explain --sensor moon --time 1",
        "coverage",
        "places",
        "apply layout.json",
    ),
    "faults.txt": _case(ROUNDING, texts.faulty),
    "convert_casas.txt": _case(ROUNDING, texts.converted, "casas", "casas.txt", 25.0),
    "convert_casas.csv": _case(ROUNDING, texts.converted, "casas-csv", "casas.csv", 25.0),
    "convert_pyadlml.txt": _case(ROUNDING, texts.converted, "pyadlml", "pyadlml", 25.0),
    "convert_influx.txt": _case(ROUNDING, texts.converted, "influx", "influx.lp", 25.0),
    "convert_home_assistant.txt": _case(
        ROUNDING, texts.converted, "home-assistant", "ha.yaml", 5.0
    ),
    "convert_xes.txt": _case(ROUNDING, texts.converted, "xes", "log.xes", 5.0),
    "convert_ocel.json": _case(ROUNDING, texts.converted, "ocel", "ocel.json", 3.5),
    # The first case of a home simulates the morning: it reads the places and plans the whole day.
    **{
        f"day_{morning.home}_{table}": _case(FORCE, texts.day, morning, table)
        for morning in (ANGEN, ATELIER)
        for table in ("events.csv", "activities.csv", "people.csv")
    },
    "help.txt": _case(EXACT, texts.help_of),
    **{f"help_{verb}.txt": _case(EXACT, texts.help_of, verb) for verb in part("parts").VERBS},
    **{
        f"help_{verb}.txt": _case(EXACT, texts.help_of, verb, without_blender=True)
        for verb in part("parts").WITHOUT_BLENDER
    },
    **{
        f"help_study_{what}.txt": _case(EXACT, texts.help_of, "study", what, without_blender=True)
        for what in ("run", "report")
    },
}
