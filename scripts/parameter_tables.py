# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/parameters.md from the parameter dataclasses, so that both always agree."""

import math
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from sensor_logic.kind import Kind  # noqa: E402
from sensor_logic.kinds import KINDS  # noqa: E402
from sensor_logic.logs.wording import OF_THRESHOLD  # noqa: E402
from sensor_logic.parameters import Spec, defaults, format_quantity, specs  # noqa: E402

PAGE = ROOT / "docs" / "parameters.md"
HEAD = """\
# Parameters

After this page you know each kind's parameters with their limits and sources, its presets, and
what it publishes.

Written by `python scripts/parameter_tables.py` from `sensor_logic`; do not edit.
A script reads and writes them as `obj.angen_sensor.<kind>.<name>`, in SI units and radians,
whatever the scene's unit scale. Panels show and read lengths in the scene's own unit.

Presets are named by their identifiers: in layouts (`"preset": "HC_SR501"`), in
`home.add(…, preset=…)` and in `angen place --preset`. A preset sets some of the parameters
and leaves the others as they are.
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
        + _choices(kind)
        + _presets(kind)
        + _published(kind)
    )


def _choices(kind: Kind) -> str:
    """Return a table of the choices of a kind's parameters; "" if no parameter has choices."""
    rows = [
        f"| `{name}` | `{choice.identifier}` | {choice.label} | {choice.tip} |\n"
        for name, spec in specs(kind.parameters).items()
        for choice in spec.choices
    ]
    head = "\n**Choices**\n\n| parameter | choice | in the window | meaning |\n|---|---|---|---|\n"
    return head + "".join(rows) if rows else ""


def _presets(kind: Kind) -> str:
    """Return a table of a kind's presets."""
    rows = [
        f"| `{preset.identifier}` | {preset.label} | {preset.source} |\n" for preset in kind.presets
    ]
    text = f"**Presets.** A sensor that is added from a menu has `{kind.part}`.\n\n"
    return (
        f"\n{text if kind.part else '**Presets**' + chr(10) * 2}"
        + "| preset | in the window | source |\n|---|---|---|\n"
        + "".join(rows)
    )


def _published(kind: Kind) -> str:
    """Return a table of the fields that a kind publishes."""
    units = {"": "", OF_THRESHOLD: "1 is the threshold"}
    types = {bool: "0 or 1", str: "text", int: "count"}
    events = {field.name: field for field in kind.events}
    samples = {field.name: field for field in kind.samples}
    rows = []
    for name, field in (events | samples).items():
        files = [
            file for file, fields in (("events", events), ("samples", samples)) if name in fields
        ]
        unit = units.get(field.unit, field.unit) or types.get(field.type, "")
        # A field can be declared twice, and its tip once.
        tip = field.tip or (events[name].tip if name in events else "")
        rows.append(f"| `{name}` | {unit} | {', '.join(files)} | {tip} |\n")
    head = "\n**Published fields**\n\n| field | unit | in | meaning |\n|---|---|---|---|\n"
    return head + "".join(rows)


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
