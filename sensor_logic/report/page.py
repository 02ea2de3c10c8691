# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the report as a page (HTML with embedded drawings) or as one drawing (SVG)."""

from __future__ import annotations

from collections.abc import Iterator

from ..kinds import KINDS
from .facts import Figures, PlanStorey, Report, ReportedSensor, figures
from .floor_plan import floor_plan
from .frames import strip
from .svg import INKS, plain_style, safe, shown_number, style
from .timeline import LEGEND_HEIGHT, WIDTH, legend, timeline

Numbered = list[tuple[int, ReportedSensor]]
# The rows of a timeline that fit on a sheet of paper.
ROWS = 40
HEADER = ("no.", "sensor", "kind", "room", "height m") + (
    "events", "first s", "last s", "active", "max", "not valid",
)  # fmt: skip
FIGURES_FROM = 4
PAGE_STYLE = """
:root{color-scheme:light dark;$light}
@media (prefers-color-scheme:dark){:root{$dark}}
@media print{:root{color-scheme:light;$light}}
@page{margin:14mm}
html{background:var(--paper);color:var(--ink);
font:15px/1.5 Inter,"Helvetica Neue",Helvetica,Arial,"DejaVu Sans",sans-serif}
body{max-width:1080px;margin:0 auto;padding:36px 24px 48px}
h1{font-size:27px;line-height:1.2;margin:0 0 4px}h2{font-size:18px;margin:34px 0 8px}
p{margin:4px 0 12px;color:var(--quiet);max-width:76ch}
dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(172px,1fr));gap:10px 20px;
margin:18px 0 0;padding:12px 0;border-top:1px solid var(--rule);border-bottom:1px solid var(--rule)}
dt{font-size:12px;color:var(--quiet)}dd{margin:0;overflow-wrap:anywhere}
figure{margin:0 0 14px}figure,section{break-inside:avoid}svg{display:block;width:100%;height:auto}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:13px;line-height:1.35}
th,td{padding:4px 8px;text-align:left;border-bottom:1px solid var(--grid);vertical-align:top}
th{font-weight:600;border-bottom:1px solid var(--rule);white-space:nowrap}
th:first-child,td:first-child{padding-left:0}
.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
tr{break-inside:avoid}thead{display:table-header-group}h2{break-after:avoid}
.mk{width:30px}.mk svg{width:26px;height:22px}
footer{margin-top:30px;font-size:12px;color:var(--quiet)}
@media print{html{font-size:11px}body{max-width:none;padding:0}
dt{font-size:9px}table{font-size:9.5px}
th,td{padding:2.5px 5px}h1{font-size:20px}h2{font-size:14px;margin-top:20px}}
"""


def html(report: Report) -> str:
    """Return the whole report as one HTML page without other files, for screen and print."""
    light = "".join(f"--{name}:{colours[0]};" for name, colours in INKS.items())
    dark = "".join(f"--{name}:{colours[1]};" for name, colours in INKS.items())
    css = PAGE_STYLE.replace("$light", light).replace("$dark", dark)
    css += style({name: f"var(--{name})" for name in INKS})
    title = safe(report.title)
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"/>',
        '<meta name="viewport" content="width=device-width, initial-scale=1"/>',
        f"<title>{title}: sensors</title>\n<style>{css}</style></head>\n<body>",
        f"<h1>{title}</h1><p>{safe(_summary(report))}</p>",
        "<dl>" + "".join(_fact(name, value) for name, value in report.facts) + "</dl>",
        "<h2>Timeline</h2>",
        *(_figure(*drawing) for drawing in _timelines(report)),
    ]
    for heading, about, drawing in (*_strips(report), *_plans(report)):
        parts.append(f"<section><h2>{safe(heading)}</h2><p>{safe(about)}</p>")
        parts.append(_figure(*drawing) + "</section>")
    parts += ["<h2>Sensors</h2>", _table(report), _settings(report)]
    parts.append(f"<footer>{safe(report.made_by)}</footer></body></html>")
    return "\n".join(parts) + "\n"


def svg(report: Report) -> str:
    """Return the timeline and all plans in one drawing, black on white."""
    parts, y = [], 30.0
    for drawing, height, _ in _timelines(report):
        parts.append(f'<g transform="translate(0 {y:g})">{drawing}</g>')
        y += height + 14
    for heading, about, (drawing, height, _) in _plans(report):
        parts.append(f'<text class="strong" x="0" y="{y + 20:g}">{safe(heading)}</text>')
        parts.append(f'<text class="small quiet" x="0" y="{y + 36:g}">{safe(_short(about))}</text>')
        y += 48
        parts.append(f'<g transform="translate(0 {y:g})">{drawing}</g>')
        y += height
    title = safe(report.title)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-12 0 {WIDTH + 24} {y + 8:g}" '
        f'width="{WIDTH + 24}" height="{y + 8:g}" role="img"><title>{title}</title>'
        f"<desc>{safe(_summary(report))}</desc><style>{plain_style()}</style>\n"
        f'<rect class="paper" x="-12" width="100%" height="100%"/>'
        f'<text class="strong" x="0" y="20" style="font-size:15px">{title}</text>\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )


def _short(about: str) -> str:
    """Return the first sentence of a text."""
    return about.split(". ")[0].rstrip(".")


def _summary(report: Report) -> str:
    count = len(report.sensors)
    first, last = report.span
    sensors = "one sensor" if count == 1 else f"{count} sensors"
    return f"What {sensors} reported in {shown_number(round(last - first, 3))} s."


def _fact(name: str, value: str) -> str:
    return f"<div><dt>{safe(name)}</dt><dd>{safe(value)}</dd></div>"


def _figure(drawing: str, height: float, about: str) -> str:
    return (
        f'<figure><svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:g}" '
        f'role="img" aria-label="{safe(about)}">{drawing}</svg></figure>'
    )


def _numbered(report: Report) -> Numbered:
    return list(enumerate(report.ordered(), start=1))


def _timelines(report: Report) -> Iterator[tuple[str, float, str]]:
    """Yield each part of the timeline that fits on a sheet: drawing, height in px, description."""
    numbered = _numbered(report)
    for start in range(0, len(numbered), ROWS):
        rows = numbered[start : start + ROWS]
        name = f"timeline{start // ROWS + 1}"
        drawing, height = timeline(report, rows, name)
        if start + ROWS >= len(numbered):
            drawing += "\n" + legend(report, name, height + 16)
            height += LEGEND_HEIGHT
        yield drawing, height, f"Timeline of sensors {rows[0][0]} to {rows[-1][0]}"


def _strips(report: Report) -> Iterator[tuple[str, str, tuple[str, float, str]]]:
    """Yield, for each sensor with pictures, the heading, the caption and the strip."""
    for number, sensor in _numbered(report):
        track = report.recording.tracks.get(sensor.name)
        for field, shape in sensor.shapes:
            found = None if track is None else strip(track, field, shape)
            if found is not None:
                drawing, height, caption = found
                heading = f"What {number} {sensor.name} saw"
                yield heading, caption, (drawing, height, heading)


def _plans(report: Report) -> Iterator[tuple[str, str, tuple[str, float, str]]]:
    """Yield, for each storey's plan, the heading, the caption and the drawing."""
    numbers = {sensor.name: number for number, sensor in _numbered(report)}
    kinds = {sensor.name: sensor.kind_name for sensor in report.sensors}
    for i, storey in enumerate(report.storeys, start=1):
        drawing, height = floor_plan(storey, numbers, kinds, f"plan{i}")
        heading = "Floor plan" if len(report.storeys) == 1 else f"Floor plan, storey {i}"
        yield heading, _about(report, storey), (drawing, height, heading)


def _about(report: Report, storey: PlanStorey) -> str:
    above = storey.cut - storey.floor
    return (
        f"Frame {report.plan_frame}; cut {above:.2f} m above the floor at z = "
        f"{shown_number(round(storey.floor, 3))} m. Filled: what is cut; outlined: what is below; "
        "dashed: what moves. Coloured areas are the sensors' own rays up to the surfaces that "
        "they hit, seen from above, each fan drawn separately: the more fans cover a place, the "
        "stronger the colour."
    )


def _table(report: Report) -> str:
    heights = {p.name: p.height for storey in report.storeys for p in storey.sensors}
    rows = [f"<th{_aligned(i)}>{text}</th>" for i, text in enumerate(HEADER)]
    lines = ["<tr>" + "".join(rows) + "</tr>"]
    for number, sensor in _numbered(report):
        track = report.recording.tracks.get(sensor.name)
        seen = figures(track) if track is not None and len(track) else None
        lines.append(_table_row(number, sensor, heights.get(sensor.name), seen))
    return (
        '<div class="scroll"><table><thead>' + lines[0] + "</thead><tbody>"
        + "\n".join(lines[1:]) + "</tbody></table></div>"
        "<p>Events are changes of what a sensor publishes, its first update apart; first and last "
        "are their times. Active is the share of the valid updates in which it was; max is the "
        "greatest value among these. A detector is not valid while it warms up.</p>"
    )  # fmt: skip


def _aligned(column: int) -> str:
    return ' class="n"' if column >= FIGURES_FROM else ""


def _table_row(
    number: int, sensor: ReportedSensor, height: float | None, seen: Figures | None
) -> str:
    kind = KINDS[sensor.kind_name]
    cells = [str(number), sensor.name, kind.label, sensor.room or "–"]
    cells.append("–" if height is None else f"{height:.2f}".replace("-", "−"))
    if seen is None:
        cells += ["not simulated", "", "", "", "", ""]
    else:
        cells.append(f"{seen.events}")
        cells += ["–" if t is None else f"{t:.1f}" for t in (seen.first, seen.last)]
        cells.append("–" if seen.active is None else f"{seen.active:.1%}")
        cells.append(seen.greatest_text)
        cells.append(f"{seen.invalid:.1%}" if seen.invalid else "")
    return (
        "<tr>"
        + "".join(f"<td{_aligned(i)}>{safe(cell)}</td>" for i, cell in enumerate(cells))
        + "</tr>"
    )


def _settings(report: Report) -> str:
    """Return a table of the sensors' settings that differ from their defaults."""
    rows = []
    for number, sensor in _numbered(report):
        if sensor.settings:
            text = ", ".join(f"{name} {value}" for name, value in sensor.settings)
            rows.append(
                f"<tr><td>{number}</td><td>{safe(sensor.name)}</td><td>{safe(text)}</td></tr>"
            )
    if not rows:
        return "<h2>Settings</h2><p>Every sensor has the defaults of its kind.</p>"
    return (
        "<h2>Settings that differ from the defaults</h2><table><thead><tr><th>no.</th>"
        "<th>sensor</th><th>settings</th></tr></thead><tbody>"
        + "\n".join(rows)
        + "</tbody></table>"
    )
