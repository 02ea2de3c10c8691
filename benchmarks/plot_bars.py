# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacked horizontal bars as SVG: what a whole is made of, a row each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from sensor_logic.report.svg import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    YELLOW,
    shown_number,
    ticks,
)

from .plot import STYLE, WIDTH

COLOURS = (BLUE, SKY, GREEN, PURPLE, ORANGE, YELLOW, BLACK)
LEFT, RIGHT, TOP, ROW, BAR, BOTTOM, LINE = 170, 70, 72, 44, 26, 52, 18
# Of characters in the legend, in pixels.
CHARACTER = 7.0


def bars(title: str, unit: str, rows: Sequence[tuple[str, Mapping[str, float], str]]) -> str:
    """Rows of (name, value by part, what stands behind the bar); all have the same parts."""
    height = TOP + ROW * len(rows) + BOTTOM
    right = WIDTH - RIGHT
    most = max(sum(parts.values()) for _, parts, _ in rows)
    marks = ticks(0.0, most, 8)
    scale = (right - LEFT) / marks[-1]
    text = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'width="{WIDTH}" height="{height}"><title>{escape(title)}</title>'
        f"<style>{STYLE}</style>",
        '<rect width="100%" height="100%" fill="#fff"/>',
        f'<text x="20" y="24" style="font-weight:600">{escape(title)}</text>',
    ]
    text += _legend(list(rows[0][1]))
    base = TOP + ROW * len(rows)
    for mark in marks:
        x = LEFT + mark * scale
        text.append(f'<path class="grid" d="M{x:.1f} {TOP}V{base}"/>')
        text.append(
            f'<text x="{x:.1f}" y="{base + 18}" text-anchor="middle">{shown_number(mark)}</text>'
        )
    middle = (LEFT + right) / 2
    text.append(f'<text x="{middle}" y="{base + 40}" text-anchor="middle">{escape(unit)}</text>')
    for index, (name, parts, behind) in enumerate(rows):
        top = TOP + ROW * index + (ROW - BAR) / 2
        line = top + BAR / 2 + 4
        text.append(f'<text x="{LEFT - 8}" y="{line}" text-anchor="end">{escape(name)}</text>')
        x = float(LEFT)
        for value, colour in zip(parts.values(), COLOURS, strict=False):
            text.append(
                f'<rect x="{x:.1f}" y="{top:g}" width="{value * scale:.1f}" height="{BAR}" '
                f'fill="{colour}"/>'
            )
            x += value * scale
        text.append(f'<text x="{x + 8:.1f}" y="{line}">{escape(behind)}</text>')
    return "\n".join([*text, "</svg>"]) + "\n"


def _legend(names: Sequence[str]) -> list[str]:
    text, x = [], 20.0
    for name, colour in zip(names, COLOURS, strict=False):
        text.append(f'<rect x="{x:.0f}" y="40" width="12" height="12" fill="{colour}"/>')
        text.append(f'<text class="small" x="{x + LINE:.0f}" y="50">{escape(name)}</text>')
        x += LINE + 14 + CHARACTER * len(name)
    return text
