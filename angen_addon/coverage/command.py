# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands `angen coverage` and `angen place`: maps and proposals without a window."""

from __future__ import annotations

import argparse
import csv
import io
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.coverage.grid import CoverageMap, map_csv, table
from ...sensor_logic.coverage.motions import MOTIONS
from ...sensor_logic.coverage.picture import svg
from ...sensor_logic.logs.error import AngenError, InputError
from ...sensor_logic.logs.wording import aligned
from ...sensor_logic.progress import T, Work
from ...sensor_logic.report.facts import PlanStorey, SensorInPlan
from ..commands.open_home import sensors_of
from ..output.output_files import Outputs, check_outputs
from ..plan.storeys import group_by_storey, sensor_in_plan, shapes_at
from ..process.console import DONE, ProgressText, write_message
from ..process.parser import Verb, add_names, path
from ..scene.home.evaluated_home import EvaluatedHome
from ..scene.sensors import Sensor, chosen
from . import shown as drawn
from .maps import check_mapped, cover
from .proposal import MOUNTINGS, Proposal, Wish, propose
from .settings import motion_of


def add_coverage(verbs: Any, every: argparse.ArgumentParser) -> None:
    """Add the command `angen coverage` to `verbs`, the subparsers of the command line.

    `every` is the parser of the options that every command has.
    """
    verb = verbs.add_parser(
        "coverage",
        parents=[_common_parser(every)],
        help="map where motion detectors notice a movement",
    )
    add_names(verb, "motion detector")


def _common_parser(parent: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """Return a parser with the options of `parent` and those that both commands have."""
    common = argparse.ArgumentParser(add_help=False, parents=[parent])
    common.add_argument(
        "--motion",
        choices=tuple(MOTIONS),
        default="STEP",
        metavar="|".join(MOTIONS),
        help="the motion that is tested in each cell (default STEP)",
    )
    common.add_argument(
        "--height",
        type=_positive,
        default=0.0,
        metavar="M",
        help="height above the floor: of the top for STEP, CRAWL and CAT, of the middle for CHEST "
        "and ARM",
    )
    common.add_argument(
        "--cell", type=_positive, default=0.25, metavar="M", help="side of a cell (default 0.25)"
    )
    common.add_argument(
        "--room",
        action="append",
        default=[],
        metavar="NAME",
        help="only this room; can be repeated",
    )
    common.add_argument(
        "--csv", type=path, metavar="FILE.csv", help="write a row for each cell or place"
    )
    common.add_argument(
        "--picture", type=path, metavar="FILE.svg", help="draw the map on the floor plan"
    )
    common.add_argument(
        "--save",
        type=path,
        metavar="FILE.blend",
        help="save the result in a copy of the blend file",
    )
    common.add_argument("--quiet", action="store_true", help="print no progress")
    return common


def add_place(verbs: Any, every: argparse.ArgumentParser) -> None:
    """Add the command `angen place` to `verbs`. The parameters are those of `add_coverage`."""
    place = verbs.add_parser(
        "place",
        parents=[_common_parser(every)],
        help="propose places for motion detectors; --save adds them",
    )
    place.add_argument(
        "--count", type=_whole, default=1, metavar="N", help="number of detectors (default 1)"
    )
    place.add_argument(
        "--mounting",
        choices=MOUNTINGS,
        default="WALL",
        metavar="|".join(MOUNTINGS),
        help="the surfaces to mount them on (default WALL)",
    )
    place.add_argument(
        "--mounting-height",
        type=_positive,
        default=2.3,
        metavar="M",
        help="height above the floor on walls (default 2.3)",
    )
    place.add_argument(
        "--spacing",
        type=_positive,
        default=0.5,
        metavar="M",
        help="distance between the places that are tried (default 0.5)",
    )
    place.add_argument("--like", metavar="SENSOR", help="use the parameters of this detector")
    place.add_argument("--preset", metavar="PRESET", help="use the parameters of this preset")
    place.add_argument(
        "--beside",
        action="store_true",
        help="count only the floor that the present detectors do not cover",
    )
    place.add_argument(
        "--seed",
        type=_seed,
        default=0,
        metavar="N",
        help="seed of the choice between equally good places (default 0)",
    )


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a length above 0 in m, such as 0.25")
    return value


def _whole(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of 1 or more")
    return int(text)


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of 0 or more")
    return int(text)


# m. The height of the cut above the floor, the margin around cells and detectors, and the least
# size of the plan.
CUT_M, AROUND_M, LEAST_M = 1.1, 0.7, 2.0


def picture(
    depsgraph: Any,
    sensors: Sequence[Sensor],
    coverage: CoverageMap,
    title: str,
    proposed: Sequence[SensorInPlan] = (),
    proposed_kind: str = "",
) -> str:
    """Return a coverage map as SVG, with its detectors and the `proposed` ones."""
    home = EvaluatedHome(depsgraph)
    chosen = [s for s in sensors if s.name in coverage.sensors]
    seen = [p for p in (sensor_in_plan(home, sensor) for sensor in chosen) if p is not None]
    marks = [
        replace(p, fans=(), beams=())
        for level in group_by_storey(home, seen)
        for p in level.sensors
    ]
    cells = coverage.cells
    storeys = []
    for number in range(int(cells.storey.max()) + 1):
        at = cells.at[cells.storey == number]
        if not len(at):
            at = cells.at
        floor = float(at[0, 2])
        heights = {p.name: _height(home, chosen, p.name) - floor for p in marks}
        over = [
            replace(p, height=heights[p.name]) for p in marks if -0.5 <= heights[p.name] < 2.9
        ] + [p for p in proposed if abs(p.height - floor) < 4.0]
        corners = np.concatenate([at[:, :2], *(p.at[None] for p in over)])
        low, high = corners.min(axis=0) - AROUND_M, corners.max(axis=0) + AROUND_M
        missing = np.maximum(LEAST_M - (high - low), 0.0) / 2
        view = np.stack([low - missing, high + missing])
        shapes = shapes_at(home, floor, floor + CUT_M, (view[0], view[1]))
        # Floors would hide the cells.
        shown = tuple(shape for shape in shapes if shape.role != "floor")
        storeys.append(PlanStorey(floor, floor + CUT_M, view, shown, tuple(over)))
    kinds = {s.name: s.kind.identifier for s in chosen}
    kinds |= dict.fromkeys([p.name for p in proposed], proposed_kind)
    return svg(coverage, storeys, title, kinds)


def _height(home: EvaluatedHome, sensors: Sequence[Sensor], name: str) -> float:
    sensor = next(s for s in sensors if s.name == name)
    return float(sensor.world_matrix(home.depsgraph).translation.z) * home.metres


def _check_files(options: argparse.Namespace) -> None:
    check_outputs({"--csv": options.csv, "--picture": options.picture, "--save": options.save})
    if options.picture is not None and options.picture.suffix.lower() != ".svg":
        raise InputError(f"--picture: {options.picture.name} must end in .svg")


def _coverage(options: argparse.Namespace, sensors: Sequence[Sensor], outputs: Outputs) -> None:
    """Compute the map that the options describe. Store its table and files in `outputs`."""
    selected = chosen(list(sensors), SensorChoice(tuple(options.sensor)))
    for sensor in selected:
        if options.sensor:
            check_mapped(sensor)
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    motion = motion_of(options.motion, options.height)
    run = cover(depsgraph, sensors, selected, motion, options.cell, options.room)
    found: CoverageMap = _run_with_progress(run, options)
    if options.csv is not None:
        outputs.texts[options.csv] = map_csv(found)
    if options.picture is not None:
        title = f"Coverage of {Path(bpy.data.filepath).stem}"
        outputs.texts[options.picture] = picture(depsgraph, selected, found, title)
    if options.save is not None:
        drawn.show_map(scene, found)
        drawn.keep(scene, found)
        outputs.save_blend(options.save)
    outputs.printed = table(found)


def _place(options: argparse.Namespace, sensors: Sequence[Sensor], outputs: Outputs) -> None:
    """Propose detectors as the options describe. Store the table and files in `outputs`."""
    if options.like and options.preset:
        raise AngenError("--like and --preset both set the parameters: give only one of them")
    like = chosen(list(sensors), SensorChoice((options.like,)))[0] if options.like else None
    wish = Wish(
        options.count,
        *drawn.pattern(like, options.preset or ""),
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
    found: Proposal = _run_with_progress(run, options)
    if options.csv is not None:
        outputs.texts[options.csv] = places_csv(found)
    if options.picture is not None:
        title = f"Proposal for {Path(bpy.data.filepath).stem}"
        outputs.texts[options.picture] = picture(
            depsgraph, [], found.map, title, plan_marks(found), wish.kind.identifier
        )
    if options.save is not None:
        drawn.show_proposal(scene, found, options.like or "", options.preset or "")
        bpy.ops.angen.place_accept()
        outputs.save_blend(options.save)
    outputs.printed = _table_of_places(found)


def plan_marks(proposal: Proposal) -> list[SensorInPlan]:
    """Return the proposed detectors in the form that the floor plan draws."""
    floor = float(proposal.map.cells.at[0, 2])
    return [
        SensorInPlan(name, c.pose.origin[:2], -c.pose.axes[:2, 2], float(c.pose.origin[2]) - floor)
        for c, name in zip(proposal.chosen, proposal.names, strict=True)
    ]


def _run_with_progress(work: Work[T], options: argparse.Namespace) -> T:
    """Run work with progress on standard error, and return its result.

    Raise `KeyboardInterrupt` at Ctrl-C.
    """
    begin, text = time.perf_counter(), ProgressText(options.quiet)
    with options.interrupt.watched():
        while True:
            try:
                now = next(work)
            except StopIteration as end:
                found: T = end.value
                break
            options.interrupt.check()
            if now is not None and text.is_due():
                text.write(f"{100 * now.share:.0f} %, {now.text}")
    text.clear()
    if not options.quiet:
        write_message(f"done in {time.perf_counter() - begin:.1f} s\n")
    return found


PLACE_COLUMNS = ("name", "room", "on", "x_m", "y_m", "z_m", "yaw_deg", "gain_m2")


def _place_rows(proposal: Proposal) -> list[tuple[str, ...]]:
    """Return a row of texts for each proposed detector.

    The last column is the floor area (m²) that the detector adds to the area covered by the rows
    above.
    """
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
    """Return the poses of the proposed detectors as the text of a CSV file."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(PLACE_COLUMNS)
    writer.writerows(_place_rows(proposal))
    return out.getvalue()


def _table_of_places(proposal: Proposal) -> str:
    heads = ("place", "room", "on", "x", "y", "z", "yaw °", "adds m²")
    return "\n".join([*aligned([heads, *_place_rows(proposal)]), proposal.summary() + ".\n"])


def _with_outputs(work: Callable[..., None]) -> Callable[[argparse.Namespace, Outputs], int]:
    """Return a function that checks the output files, calls `work` and returns the exit status."""

    def run(options: argparse.Namespace, outputs: Outputs) -> int:
        _check_files(options)
        work(options, sensors_of(options), outputs)
        return DONE

    return run


VERBS = {
    "coverage": Verb(add_coverage, _with_outputs(_coverage)),
    "place": Verb(add_place, _with_outputs(_place)),
}
