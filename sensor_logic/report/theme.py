# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours, and a mark for each kind of sensor that differs from the others also without colour."""

from __future__ import annotations

from ..kinds import KINDS
from .svg import BLUE, BROWN, GREEN, ORANGE, PURPLE, SKY, YELLOW, coordinate, safe

# Name → colour on white and on black.
INKS = {
    "paper": ("#ffffff", "#14171a"),
    "ink": ("#1c2024", "#e8eaec"),
    "quiet": ("#5b636b", "#a3abb3"),
    "grid": ("#e4e7ea", "#2a2f35"),
    "rule": ("#b9c0c6", "#454c54"),
    "wall": ("#3b4248", "#98a0a8"),
    "solid": ("#cfd4d8", "#4b535b"),
    "low": ("#f3f5f6", "#1d2125"),
    "line": ("#a9b1b8", "#5d656d"),
    "kind1": (BLUE, SKY),
    "kind2": (ORANGE, "#f0803c"),
    "kind3": (GREEN, "#2fc197"),
    "kind4": (YELLOW, "#f0b73c"),
    "kind5": (PURPLE, "#dd9abf"),
    "kind6": (BROWN, "#c89b6d"),
    "onkind": ("#ffffff", "#14171a"),
}
HUES = 6

STYLE = """
text{font-family:"Inter","Helvetica Neue",Helvetica,Arial,"DejaVu Sans",sans-serif;font-size:12px;
fill:$ink}
.small{font-size:10.5px}.quiet{fill:$quiet}.strong{font-weight:600}
.mark{font-size:9.5px;font-weight:600;fill:$onkind;text-anchor:middle}
.end{text-anchor:end}.mid{text-anchor:middle}
.grid{stroke:$grid;fill:none}.rule{stroke:$rule;fill:none}.hatch{stroke:$ink;stroke-width:1.1}
.dot{fill:$quiet}.paper{fill:$paper}.lead{stroke:$quiet;stroke-width:.7;fill:none}
.wall{fill:$wall;stroke:$wall;stroke-width:.8;stroke-linejoin:round}
.solid{fill:$solid;stroke:$wall;stroke-width:.7;stroke-linejoin:round}
.hollow{fill:none;stroke:$wall;stroke-width:.9}
.low{fill:$low;stroke:$line;stroke-width:.7;stroke-linejoin:round}
.floor{fill:none;stroke:$grid;stroke-width:.7}
.moving{fill:$paper;stroke:$wall;stroke-width:.7;stroke-dasharray:2.5 1.5}
.fields{opacity:.55}.first{stroke-opacity:1;stroke-width:1.2}
.scale{stroke:$ink;stroke-width:1.4;fill:none}
"""
HUE_STYLE = """
.bar$n{stroke:$kind$n;fill:none}.fill$n{fill:$kind$n}
.curve$n{stroke:$kind$n;stroke-width:1.1;fill:$kind$n;fill-opacity:.16;stroke-linejoin:round}
.fan$n{fill:$kind$n;fill-opacity:.1;stroke:$kind$n;stroke-opacity:.6;stroke-width:.5}
.beam$n{stroke:$kind$n;stroke-width:1.2;fill:none}
.pad$n{fill:$kind$n;fill-opacity:.35;stroke:$kind$n;stroke-width:1}
"""


def style(colours: dict[str, str]) -> str:
    """The CSS of all drawings, with these colours by name."""
    text = "".join(HUE_STYLE.replace("$n", str(n)) for n in range(1, HUES + 1)) + STYLE
    for name in sorted(colours, key=len, reverse=True):
        text = text.replace(f"${name}", colours[name])
    return text.strip()


def plain_style() -> str:
    """The CSS of a standalone drawing, black on white."""
    return style({name: light for name, (light, _) in INKS.items()})


def hue(kind_name: str) -> int:
    """1 … HUES for a kind, in the order of the kinds' numbers."""
    return (KINDS[kind_name].number - 1) % HUES + 1


def mark(kind_name: str, x: float, y: float, label: str, about: str = "") -> str:
    """A small shape in the colour of the kind with a label in it, centred at (x, y)."""
    kind = f'class="fill{hue(kind_name)}"'
    half = 8.0 if len(label) < 3 else 9.5
    shapes = {
        1: f'<circle {kind} r="{half}"/>',
        2: f'<rect {kind} x="{-half}" y="-7" width="{2 * half}" height="14" rx="1"/>',
        3: f'<path {kind} d="M{-half - 3} 0L0 {-half - 1.5}L{half + 3} 0L0 {half + 1.5}Z"/>',
        4: f'<path {kind} d="M{-half - 1} 7L{1 - half} -7H{half - 1}L{half + 1} 7Z"/>',
        5: f'<path {kind} d="M{-half} -4L0 -9L{half} -4V4L0 9L{-half} 4Z"/>',
        6: f'<path {kind} d="M{-half - 4} 7L0 {-half - 3}L{half + 4} 7Z"/>',
    }
    title = f"<title>{safe(about)}</title>" if about else ""
    return (
        f'<g transform="translate({coordinate(x)} {coordinate(y)})">{title}'
        f'{shapes[hue(kind_name)]}<text class="mark" y="3.4">{safe(label)}</text></g>'
    )
