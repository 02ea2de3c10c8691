# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a study: one HTML page without other files, and its pictures as files."""

from __future__ import annotations

import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import pandas
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure
from scipy.stats import t

from ..sensor_logic.logs.error import InputError, explained
from ..sensor_logic.logs.files import write_files
from ..sensor_logic.logs.wording import plural
from ..sensor_logic.palette import BLUE, GREEN, ORANGE, PURPLE, SKY, YELLOW
from ..sensor_logic.report.page import PAGE_STYLE
from ..sensor_logic.report.svg import INKS, safe
from .results import CSV, FACTS
from .study import COLUMNS, SENSORS

REPORT, PICTURES = "report.html", "pictures"
BEST, MOST_ROWS, MOST_MAPS = 10, 2000, 6
VERSIONS = ("angen_sensors", "blender", "numpy", "python")
# Columns that are neither varied nor measured.
NOT_MEASURED = ("run", "seed", "digest", "error", *VERSIONS)
CONFIDENCE = 0.95
# Number of bins, with equally many runs each, for a varied parameter with many values.
BINS = 8
# A varied parameter with more values than this is shown in bins.
FEW = 24
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, YELLOW)
MARKS = "osD^v<"
WIDTH, HEIGHT = 9.0, 2.9
ACROSS = 3
# The most lines in one picture that can be distinguished.
MOST_LINES = 6


def write(folder: Path) -> Path:
    """Write the report and its pictures into the folder of a study, and return the page's path.

    Raise `InputError` if the results cannot be read, or if the report cannot be written.
    """
    facts = _facts(folder)
    with (
        explained(f"cannot read {folder / CSV}", OSError),
        explained(f"{folder / CSV} does not belong to this study", ValueError),
    ):
        results = read(folder / CSV, facts["varied"])
    page, pictures = html(facts, results)
    with explained(f"cannot write in {folder}", OSError):
        (folder / PICTURES).mkdir(exist_ok=True)
        texts = {
            folder / PICTURES / f"{number:02d} {_file_name(picture.about)}.svg": picture.svg + "\n"
            for number, picture in enumerate(pictures, 1)
        }
        write_files({folder / REPORT: page, **texts})
    return folder / REPORT


def _facts(folder: Path) -> dict[str, Any]:
    """Return the description of a study, such as its name and homes, from the study's folder."""
    try:
        found: dict[str, Any] = json.loads((folder / FACTS).read_text(encoding="utf-8"))
        return found
    except OSError as error:
        raise InputError(
            f"{folder} has no results of a study ({error.strerror}): run `angen study run` first"
        ) from None
    except ValueError:
        raise InputError(
            f"{folder / FACTS} is damaged: run the study again into a new folder"
        ) from None


def _file_name(about: str) -> str:
    """Return a picture's title as a part of a file name."""
    return re.sub(r"[^\w ,.-]+", "_", about)[:80]


# The table of results.


@dataclass(frozen=True)
class Results:
    """The results of a study.

    Attributes
    ----------
    rows : DataFrame
        The runs with at least one measure. The `varied` columns and the seed are text, the
        `measured` ones numbers. The column `setting` numbers the combinations of varied values.
    varied, measured : list of str
        The columns with varied values, and those with measures.
    errors : Series
        The number of runs with each error.
    partly : int
        The number of runs that have errors, but also some measures.
    """

    rows: pandas.DataFrame
    varied: list[str]
    measured: list[str]
    errors: pandas.Series[int]
    partly: int

    @property
    def settings(self) -> pandas.DataFrame:
        """The first run of each combination of varied values, as rows."""
        return self.rows.drop_duplicates("setting").set_index("setting")


def read(path: Path, varied: Sequence[str]) -> Results:
    """Read the results from results.csv; raise `OSError` or `ValueError` if that fails."""
    names = list(pandas.read_csv(path, nrows=0))
    for name in (*varied, "run", "seed", "error"):
        if name not in names:
            raise ValueError(f"the column {name!r} is missing")
    texts = [name for name in names if name in (*varied, *NOT_MEASURED)]
    measured = [name for name in names if name not in texts]
    table = pandas.read_csv(
        path,
        dtype={name: str if name in texts else float for name in names},
        keep_default_na=False,
        na_values={name: [""] for name in measured},
        float_precision="round_trip",
    ).replace([math.inf, -math.inf], math.nan)
    failed = table["error"] != ""
    counted = [name for name in measured if name not in COLUMNS]
    partly = failed & table[counted].notna().any(axis=1)
    errors = table[failed].groupby("error", sort=False).size()
    rows = table[~failed | partly]
    numbers = rows.groupby(list(varied), sort=False).ngroup() if varied else 0
    rows = rows.assign(setting=numbers)
    errors = errors.sort_values(ascending=False, kind="stable")
    return Results(rows, list(varied), measured, errors, int(partly.sum()))


class Means(NamedTuple):
    """Means over groups of runs: a row for each group, a column for each measure.

    `value` has the means. `half` is half the width of the confidence interval over seeds, or NaN
    with a single seed.
    """

    value: pandas.DataFrame
    half: pandas.DataFrame


def means(rows: pandas.DataFrame, keys: Sequence[pandas.Series], measures: Sequence[str]) -> Means:
    """Return the mean of each measure over the runs that have the same `keys`.

    Runs with the same seed are averaged first, so that each seed counts once. The confidence
    interval follows from Student's t over the means of the seeds.

    Parameters
    ----------
    rows : DataFrame
        Runs as rows.
    keys : sequence of Series
        The values to group by, one for each row.
    measures : sequence of str
        The columns to average.
    """
    seeds = rows[list(dict.fromkeys(measures))].groupby([*keys, rows["seed"]]).mean()
    groups = seeds.groupby(level=list(range(len(keys))))
    count = groups.count()
    quantile = t.ppf(0.5 + CONFIDENCE / 2, (count - 1).where(count > 1))
    return Means(groups.mean(), quantile * groups.std() / np.sqrt(count))


class Levels(NamedTuple):
    """The levels of a varied parameter: its values in order or, if there are many, bins of values.

    Attributes
    ----------
    labels : list of str
        The text of each level.
    at : sequence of float
        The position of each level on an axis.
    number : Series
        The index of the level of each run.
    """

    labels: list[str]
    at: Sequence[float]
    number: pandas.Series[int]


def levels(values: pandas.Series[str]) -> Levels:
    """Return the levels of a column of texts.

    Values that are all numbers are sorted; more than `FEW` of them are put into bins.
    """
    if not is_numeric(values):
        codes, names = pandas.factorize(values)
        return Levels(list(names), range(len(names)), pandas.Series(codes, values.index))
    numbers = values.astype(float)
    codes, unique = pandas.factorize(numbers, sort=True)
    if len(unique) <= FEW:
        labels = [f"{value:.4g}" for value in unique]
        return Levels(labels, list(unique), pandas.Series(codes, values.index))
    parts = np.array_split(numbers.sort_values(kind="stable").index, BINS)
    at = [float(numbers[part].mean()) for part in parts]
    of = pandas.Series({row: bin for bin, part in enumerate(parts) for row in part})
    return Levels([f"{value:.3g}" for value in at], at, of.reindex(values.index))


def is_numeric(values: Iterable[str]) -> bool:
    """Return whether all values are finite numbers."""
    return bool(np.isfinite(pandas.to_numeric(pandas.Series(values), errors="coerce")).all())


def main_measures(results: Results, best: str = "") -> list[str]:
    """Return the measures that the report shows, beginning with `best` if it is measured.

    Measures of single sensors, such as "events NAME", are not among them.
    """
    whole = [n for n in results.measured if " " not in n and n not in ("sensors_on", "seconds")]
    first = [best] * (best in results.measured)
    return first + [name for name in whole if name != best] + ["seconds"]


def rank_settings(results: Results, value: pandas.Series[float], way: str) -> pandas.DataFrame:
    """Return the combinations of varied values, best first.

    `value` has the mean of the main measure for each combination; a combination without one is left
    out. If `way` is "least", small values are best; if it is "most", large ones are.
    """
    order = (value if way == "least" else -value).dropna().sort_values(kind="stable")
    return results.settings.loc[order.index]


def results_to_plot(results: Results, ranked: pandas.DataFrame) -> Results:
    """Return the results with only those varied parameters that pictures can show.

    A parameter with many texts as values is left out. Too many sets of sensors are replaced by the
    number of enabled sensors; for each number, only the set that is first in `ranked` is kept.
    """
    rows = results.rows
    many = {k for k in results.varied if rows[k].nunique() > FEW and not is_numeric(rows[k])}
    varied = [key for key in results.varied if key not in many]
    if SENSORS not in many or "sensors_on" not in results.measured:
        return replace(results, varied=varied)
    best = ranked.drop_duplicates("sensors_on").set_index("sensors_on")[SENSORS]
    shown = rows[rows[SENSORS] == rows["sensors_on"].map(best)]
    number = {"sensors on": shown["sensors_on"].map("{:g}".format)}
    return replace(results, rows=shown.assign(**number), varied=[*varied, *number])


# The page.


class Plot(NamedTuple):
    """A picture with its title."""

    about: str
    svg: str


def html(facts: dict[str, Any], results: Results) -> tuple[str, list[Plot]]:
    """Return the page, and the pictures that it shows.

    `facts` is the content of the file that describes the study.
    """
    light, dark = (
        "".join(f"--{name}:{colours[number]};" for name, colours in INKS.items())
        for number in (0, 1)
    )
    well, failed = len(results.rows) - results.partly, int(results.errors.sum())
    values: dict[str, Any] = {
        "style": PAGE_STYLE.replace("$light", light).replace("$dark", dark),
        "title": Path(facts["name"]).stem,
        "runs": plural(facts["runs"], "run"),
        "well": well,
        "failed": failed,
        "missing": facts["runs"] - well - failed,
        "facts": list(_fact_rows(facts, results)),
        "csv": CSV,
        "errors": list(results.errors.items()),
        "all": None,
    }
    if len(results.rows):
        values |= _sections(results, *(facts["best"] or ("", "")))
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        autoescape=True,
        keep_trailing_newline=True,
        finalize=lambda value: value if isinstance(value, Markup) else Markup(safe(str(value))),
    )
    page = environment.get_template(REPORT).render(values)
    return page, [*values.get("curves", ()), *values.get("maps", ())]


def _fact_rows(facts: dict[str, Any], results: Results) -> Iterator[tuple[str, str]]:
    """Yield the rows of the table that describes the study, as pairs of a name and a text."""
    yield "home", ", ".join(facts["homes"])
    yield "what varied", ", ".join(facts["varied"]) or "nothing"
    yield "seeds for each setting", str(facts["seeds"])
    rows = results.rows
    if len(rows) and "seconds" in rows:
        seconds = rows["seconds"]
        yield "simulated for", f"{seconds.sum():.0f} s of computing, {seconds.mean():.2f} s per run"
    for name in VERSIONS:
        if name in rows:
            yield name, ", ".join(rows[name].unique())


def _sections(results: Results, best: str, way: str) -> dict[str, Any]:
    """Return the values that the template needs for the sections with results."""
    measures = main_measures(results, best)
    settings = results.settings
    shown = [name for name in (*measures, "sensors_on") if name in results.measured]
    found = means(results.rows, [results.rows["setting"]], shown)
    has_best = best in results.measured
    order = rank_settings(results, found.value[best], way) if has_best else settings
    tables: dict[str, Any] = {"name": best, "way": way, "table": None, "by_number": None}
    if has_best:
        costs = [n for n in ("sensors_on", "seconds") if n in results.measured and n != best]
        tables["table"] = _table(results, order[:BEST], [best, *costs], found)
        if "sensors_on" in results.measured:
            first = order.drop_duplicates("sensors_on").sort_values("sensors_on")
            columns = ["sensors_on", *(name for name in measures if name != "seconds")]
            if len(first) > 1:
                tables["by_number"] = _table(results, first, columns, found)
    drawn = results_to_plot(results, order)
    pairs = list(combinations(drawn.varied, 2))[:MOST_MAPS]
    return {
        "main": measures[0],
        "best": tables,
        "fewer": len(drawn.rows) < len(results.rows),
        "curves": list(_curves(drawn, measures)) if drawn.varied else [],
        "maps": [heat_map(drawn, measures[0], pair) for pair in pairs],
        "settings": len(settings),
        "all": _table(results, settings[:MOST_ROWS], measures, found),
    }


def _curves(results: Results, measures: Sequence[str]) -> Iterator[Plot]:
    """Yield pictures with the curves of measures against the varied parameters."""
    for measure in measures:
        yield Plot(f"{measure} against what varied", curves(results, [measure], measure))
    for measure in ("events", "active"):
        columns = [name for name in results.measured if name.startswith(f"{measure} ")]
        if 1 < len(columns) <= MOST_LINES:
            about = f"{measure} of each sensor against the varied parameters"
            yield Plot(about, curves(results, columns, measure))


def _table(
    results: Results, settings: pandas.DataFrame, measures: Sequence[str], found: Means
) -> dict[str, Any]:
    """Return a table of combinations of varied values, as the template needs it."""
    plain = settings[results.varied].map(_short) if results.varied else settings[[]]
    value, half = (table.loc[settings.index, measures].to_numpy() for table in found)
    cells = [map(_cell, *row) for row in zip(value.tolist(), half.tolist(), strict=True)]
    rows = list(zip(plain.to_numpy().tolist(), map(list, cells), strict=True))
    return {"varied": results.varied, "measures": measures, "rows": rows}


def _short(value: str) -> str:
    """Return a number with six digits; return any other text as it is."""
    return f"{float(value):.6g}" if is_numeric([value]) else value


def _cell(value: float, half: float) -> tuple[str, str]:
    """Return a mean with all digits, for sorting, and as text with its confidence interval."""
    if math.isnan(value):
        return "", ""
    return repr(value), f"{value:.4g}" + ("" if math.isnan(half) else f" ± {half:.2g}")


# Pictures.


def curves(results: Results, measures: Sequence[str], label: str) -> str:
    """Plot measures against each varied parameter, and return the SVG.

    Points are means over all runs with the same value of the parameter. Bars are confidence
    intervals over seeds.
    """
    drawing, axes = _axes(len(results.varied))
    for axis, key in zip_longest(axes, results.varied):
        if key is None:
            axis.set_visible(False)
            continue
        values = results.rows[key]
        found, line = levels(values), is_numeric(values)
        mean = means(results.rows, [found.number], measures)
        for measure, colour, mark in zip(measures, COLOURS, MARKS, strict=False):
            half = mean.half[measure].fillna(0.0)
            axis.errorbar(
                found.at,
                mean.value[measure],
                yerr=half if half.any() else None,
                color=colour,
                marker=mark,
                markersize=4,
                capsize=3,
                linestyle="-" if line else "",
                label=measure.removeprefix(label).strip() if len(measures) > 1 else "_",
            )
        if not line:
            names = [name[:24] for name in found.labels]
            axis.set_xticks(found.at, names, rotation=25, ha="right")
            axis.margins(x=0.15)
        axis.set_xlabel(key)
        axis.grid(color="#ddd")
        axis.set_axisbelow(True)
    axes[0].set_ylabel(label)
    if len(measures) > 1:
        axes[0].legend(frameon=False, fontsize="small")
    return _svg(drawing)


def heat_map(results: Results, measure: str, keys: tuple[str, str]) -> Plot:
    """Plot the mean of a measure for each pair of values of two varied parameters, `keys`.

    Each cell also shows half the width of the confidence interval.
    """
    across, up = (levels(results.rows[key]) for key in keys)
    found = means(results.rows, [up.number.rename("up"), across.number.rename("across")], [measure])
    values, halves = (
        table[measure].unstack().reindex(range(len(up.labels))).to_numpy() for table in found
    )
    drawing, (axis,) = _axes(1, height=max(2.2, 0.36 * len(up.labels) + 1.2))
    image = axis.imshow(values, origin="lower", aspect="auto", cmap="cividis")
    middle = (np.nanmin(values) + np.nanmax(values)) / 2
    for (y, x), value in np.ndenumerate(values):
        if np.isfinite(value) and len(across.labels) <= 10:
            half = "" if np.isnan(halves[y, x]) else f"\n± {halves[y, x]:.2g}"
            colour = "white" if value < middle else "black"
            text = f"{value:.3g}{half}"
            axis.text(x, y, text, ha="center", va="center", fontsize=7, color=colour)
    axis.set_xticks(range(len(across.labels)), [label[:24] for label in across.labels])
    axis.set_yticks(range(len(up.labels)), [label[:24] for label in up.labels])
    axis.set_xlabel(keys[0])
    axis.set_ylabel(keys[1])
    drawing.colorbar(image, ax=axis, label=measure)
    return Plot(f"{measure} over {keys[0]} and {keys[1]}", _svg(drawing))


def _axes(count: int, height: float = HEIGHT) -> tuple[Any, Any]:
    """Return a figure with `count` axes, three in a row."""
    across = min(max(count, 1), ACROSS)
    down = -(-max(count, 1) // across)
    width = WIDTH if across > 1 else WIDTH * 0.6
    drawing = Figure(figsize=(width, height * down), layout="constrained")
    return drawing, drawing.subplots(down, across, sharey=count > 1, squeeze=False).ravel()


def _svg(drawing: Figure) -> str:
    """Return a figure as an SVG element."""
    # Text remains text, and the same numbers give the same bytes.
    out = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "angen", "svg.fonttype": "none"}):
        drawing.savefig(out, format="svg", metadata={"Date": None})
    return "".join(out.getvalue().partition("<svg")[1:]).rstrip()
