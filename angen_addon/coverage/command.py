# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen coverage` and `angen place`: maps and proposals without a window."""

from __future__ import annotations

import argparse
import csv
import io
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.coverage.detectors import DETECTOR
from ...sensor_logic.coverage.grid import CoverageMap, map_csv, table
from ...sensor_logic.error import AngenError, InputError
from ...sensor_logic.report.facts import SensorInPlan
from ...sensor_logic.wording import aligned
from ..commands.console import DONE, tell
from ..commands.home import sensors_of
from ..commands.parser import Verb
from ..commands.progress import LOG_INTERVAL_S, TERMINAL_INTERVAL_S
from ..output.output_files import Outputs, check_outputs
from ..scene.sensors import Sensor, chosen
from . import ghosts, kept, mesh
from .arguments import add_coverage, add_place
from .maps import MapProgress, cover
from .plans import picture
from .proposal import Proposal, Wish, propose
from .settings import motion_of


def _check_files(options: argparse.Namespace) -> None:
    """Raises AngenError where the results could not be written."""
    check_outputs({"--csv": options.csv, "--picture": options.picture, "--save": options.save})
    if options.picture is not None and options.picture.suffix.lower() != ".svg":
        raise InputError(f"--picture: {options.picture.name} must end in .svg")


def _coverage(options: argparse.Namespace, sensors: Sequence[Sensor], outputs: Outputs) -> None:
    """Maps what the options ask for; says the table of its rooms."""
    asked = chosen(list(sensors), SensorChoice(tuple(options.sensor)))
    for sensor in asked:
        if options.sensor and sensor.kind is not DETECTOR:
            raise AngenError(f"'{sensor.name}' is no motion detector (PIR)")
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    motion = motion_of(options.motion, options.height)
    run = cover(depsgraph, sensors, asked, motion, options.cell, options.room)
    found: CoverageMap = _through(run, options)
    if options.csv is not None:
        outputs.texts[options.csv] = map_csv(found)
    if options.picture is not None:
        title = f"Coverage of {Path(bpy.data.filepath).stem}"
        outputs.texts[options.picture] = picture(depsgraph, asked, found, title)
    if options.save is not None:
        mesh.show(scene, found)
        kept.keep(scene, found)
        outputs.save_blend(options.save)
    outputs.said = table(found)


def _place(options: argparse.Namespace, sensors: Sequence[Sensor], outputs: Outputs) -> None:
    """Proposes what the options ask for; says a table of the places."""
    if options.like and options.preset:
        raise AngenError("--like and --preset both tell the parameters: give one of them")
    like = chosen(list(sensors), SensorChoice((options.like,)))[0] if options.like else None
    parameters, rate = ghosts.pattern(like, options.preset or "")
    wish = Wish(
        options.count,
        parameters,
        rate,
        tuple(options.room),
        options.mounting,
        options.mounting_height,
        options.spacing,
        options.seed,
        options.beside,
    )
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    motion = motion_of(options.motion, options.height)
    run = propose(depsgraph, sensors, wish, motion, options.cell)
    found: Proposal = _through(run, options)
    if options.csv is not None:
        outputs.texts[options.csv] = places_csv(found)
    if options.picture is not None:
        title = f"Proposal for {Path(bpy.data.filepath).stem}"
        outputs.texts[options.picture] = picture(depsgraph, [], found.map, title, marks(found))
    if options.save is not None:
        ghosts.show(scene, found, options.like or "", options.preset or "")
        mesh.show(scene, found.map)
        kept.keep(scene, found.map)
        bpy.ops.angen.place_accept()
        outputs.save_blend(options.save)
    outputs.said = _places(found)


def marks(proposal: Proposal) -> list[SensorInPlan]:
    """The proposed detectors as a plan shows them."""
    floor = float(proposal.map.cells.at[0, 2])
    return [
        SensorInPlan(name, c.pose.origin[:2], -c.pose.axes[:2, 2], float(c.pose.origin[2]) - floor)
        for c, name in zip(proposal.chosen, proposal.names, strict=True)
    ]


def _through(run: Iterator[Any], options: argparse.Namespace) -> Any:
    """The last thing of a generator, with progress. Raises KeyboardInterrupt on Ctrl-C."""
    terminal = sys.stderr.isatty()
    interval = TERMINAL_INTERVAL_S if terminal else LOG_INTERVAL_S
    begin = shown = time.perf_counter()
    told = None
    with options.interrupt.watched():
        for told in run:
            options.interrupt.check()
            now = time.perf_counter()
            if isinstance(told, MapProgress) and not options.quiet and now - shown >= interval:
                shown = now
                text = f"{100 * told.share:.0f} %, {told.text}"
                start, end = ("\r", "") if terminal else ("", "\n")
                tell(f"{start}{text:<60}{end}")
    if not options.quiet:
        if terminal:
            tell("\r" + " " * 60 + "\r")
        tell(f"done in {time.perf_counter() - begin:.1f} s\n")
    return told


PLACE_COLUMNS = ("name", "room", "on", "x_m", "y_m", "z_m", "yaw_deg", "gain_m2")


def _rows(proposal: Proposal) -> list[tuple[str, ...]]:
    """Each place with the floor (m²) that it alone adds to those before it."""
    covered, area = proposal.map.covered, proposal.map.cells.size**2
    before = np.zeros(len(proposal.map.cells), bool)
    rows = []
    for number, (candidate, name) in enumerate(zip(proposal.chosen, proposal.names, strict=True)):
        gain = int((covered[number] & ~before).sum()) * area
        before |= covered[number]
        at = [f"{v:.3f}" for v in candidate.pose.origin.tolist()]
        rows.append(
            (name, candidate.room, candidate.on, *at, f"{candidate.yaw:.1f}", f"{gain:.2f}")
        )
    return rows


def places_csv(proposal: Proposal) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(PLACE_COLUMNS)
    writer.writerows(_rows(proposal))
    return out.getvalue()


def _places(proposal: Proposal) -> str:
    heads = ("place", "room", "on", "x", "y", "z", "yaw °", "adds m²")
    return "\n".join([*aligned([heads, *_rows(proposal)]), proposal.summary() + ".\n"])


def _with_files(work: Callable[..., None]) -> Callable[[argparse.Namespace, Outputs], int]:
    def run(options: argparse.Namespace, outputs: Outputs) -> int:
        _check_files(options)
        work(options, sensors_of(options), outputs)
        return DONE

    return run


VERBS = {
    "coverage": Verb(add_coverage, _with_files(_coverage)),
    "place": Verb(add_place, _with_files(_place)),
}
