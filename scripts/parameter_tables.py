# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/parameters.md from the parameter dataclasses, so that both always agree."""

import math
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from sensor_logic.kind import Kind  # noqa: E402
from sensor_logic.kinds import KINDS  # noqa: E402
from sensor_logic.parameters import Spec, defaults, format_quantity, specs  # noqa: E402
from sensor_logic.wording import OF_THRESHOLD  # noqa: E402

PAGE = ROOT / "docs" / "parameters.md"
HEAD = """\
# Parameters

After this page you know each parameter of each kind, with its limits and the source of its default.

Written by `python scripts/parameter_tables.py` from `sensor_logic`; do not edit.
A script reads and writes them as `obj.angen_sensor.<kind>.<name>`, in SI units and radians,
whatever the scene's unit scale. Panels show and read lengths in the scene's own unit.
"""


def page() -> str:
    """Return the text of docs/parameters.md."""
    return HEAD + "".join(_section(kind) for kind in KINDS.values())


def _section(kind: Kind) -> str:
    """Return the section of a kind."""
    title = f"\n## {kind.label}: `{kind.attribute}`\n\n"
    title += f"Default `update_rate` {kind.update_rate:g} Hz.\n\n"
    rows = [
        f"| `{name}` | {_value(default, spec)} | {_limits(default, spec)} "
        f"| {spec.tip} | {spec.source} |\n"
        for (name, spec), default in zip(
            specs(kind.parameters).items(), defaults(kind.parameters).values(), strict=True
        )
    ]
    return (
        title
        + "| name | default | valid | meaning | source |\n|---|---|---|---|---|\n"
        + "".join(rows)
        + f"\nPublishes {_published(kind)}.\n"
    )


def _published(kind: Kind) -> str:
    """Return the fields of a kind's samples with their units."""
    units = {"": "", "rad": " (rad)", OF_THRESHOLD: " (1: the threshold)"}
    return ", ".join(
        f"`{field.name}`{units.get(field.unit, f' ({field.unit})')}" for field in kind.samples
    )


def _value(value: object, spec: Spec) -> str:
    """Return a default value with its unit."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, (int, float)):
        return format_quantity(value, spec.unit)
    return f"`{value}`" if value else "none"


def _limits(default: object, spec: Spec) -> str:
    """Return the limits of a parameter, or its choices."""
    if spec.choices:
        return ", ".join(f"`{choice.identifier}`" for choice in spec.choices)
    if isinstance(default, bool) or not isinstance(default, (int, float)):
        return ""
    sign = ">" if spec.positive else "≥"
    found = [f"{sign} {format_quantity(spec.minimum, spec.unit)}"]
    if math.isfinite(spec.maximum):
        found.append(f"≤ {format_quantity(spec.maximum, spec.unit)}")
    return ", ".join(found)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
