# SPDX-License-Identifier: GPL-3.0-or-later
"""The pyroelectric detector's section of the page and the tables of docs/pir.md, from data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .tables import filled_in, spread, table

PAGE = Path(__file__).resolve().parent.parent / "docs" / "pir.md"
COMMAND = "python -m benchmarks --only pir_pyroelectric"
MODELS = {
    "RANGE_SCAN": "range scan, all tilts",
    "PYROELECTRIC": "pyroelectric, {} rays a zone",
}
COLUMNS = {
    "thesis": "range scan (thesis)",
    "all tilts": "range scan, all tilts",
    "pyroelectric": "pyroelectric",
}
TEXT = """\
## The pyroelectric motion detector

Error of the peak signal over {walks} walks through the furnished room of the part above, against
300 rays a zone and 120 Hz:

{error}
Milliseconds of processor time an update of one of the home's seven detectors, a person walking:

{cost}
Share of {passes} passes detected, and the median time until then, of the two models side by side.
The pyroelectric detector has the three-tier lens, 5 m, 24 Hz; bodies 29 °C (the cat 27 °C) in a
room of 20 °C; 31 °C in that of 28 °C, 31.5 °C in that of 31 °C. What they mean: [pir.md](pir.md).

{models}"""


def section(data: dict[str, Any]) -> str:
    return TEXT.format(
        walks=data["error"][0]["walks"], passes=data["models"][0]["passes"], **tables(data)
    )


def tables(data: dict[str, Any]) -> dict[str, str]:
    return {"error": _error(data), "cost": _cost(data), "models": _models(data)}


def _error(data: dict[str, Any]) -> str:
    by = {(row["zone_rays"], row["rate"]): row for row in data["error"]}
    rates = sorted({rate for _, rate in by}, reverse=True)
    return table(
        ("rays a zone", *(f"{rate:g} Hz: rms / mean" for rate in rates)),
        (
            (f"{rays}", *(_rms_and_mean(by[rays, rate]) for rate in rates))
            for rays in sorted({rays for rays, _ in by})
        ),
    )


def _rms_and_mean(row: dict[str, Any]) -> str:
    return f"{row['rms']:.1%} / {row['mean']:+.1%}".replace("-", "−")


def _cost(data: dict[str, Any]) -> str:
    return table(
        ("model", "rays", "ms an update"),
        (
            (MODELS[row["model"]].format(row["zone_rays"]), f"{row['rays']}", spread(row["ms"], 2))
            for row in data["cost"]
        ),
    )


def _models(data: dict[str, Any]) -> str:
    return table(
        ("who moves", *COLUMNS.values()),
        ((row["situation"], *(_seen(row[name]) for name in COLUMNS)) for row in data["models"]),
    )


def _seen(found: dict[str, Any]) -> str:
    late = found["latency_s"]
    return f"{found['detected']:.0%}" + (f", {late:.2f} s" if late else "")


def filled(page: str, data: dict[str, Any]) -> str:
    """docs/pir.md with its tables made anew."""
    return filled_in(page, COMMAND, tables(data))


def write(data: dict[str, Any]) -> None:
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), data), encoding="utf-8")
