# SPDX-License-Identifier: GPL-3.0-or-later
"""What are simulated days worth for a real home? Prints the tables of docs/sim_to_real.md.

    python docs/examples/sim_to_real.py DATA --days DAYS [DAYS …]

DATA is the folder of the real logs that docs/sim_to_real.md names, DAYS are folders of `angen day`.
A recogniser learns from these days, from the same days with sensors that are on by a rule (the
control), or from other real homes; and from none, one or more days of the real home. It is tried
on all other days of that home. Needs scikit-learn and the package (`pip install scikit-learn .`).

The folder `--twin` has a TOML file for each home, which says what its sensors and activities are
called in the simulated days, and `rules.toml`, the control. Each minute is a sample, and each
activity counts alike (macro F1). Each figure is the mean over seeds, which draw the real days and
grow the forest, with its range. The same real days stand in all rows of a column.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

try:
    import numpy as np
    from recogniser import (
        AngenError,
        Day,
        InputError,
        forest_guess,
        joined,
        read_home,
        rules_of,
        samples_of,
        scores,
        sensors_of,
        tried,
    )  # fmt: skip
except ModuleNotFoundError as error:
    raise SystemExit(
        f"sim_to_real: {error}: run `pip install scikit-learn .` in the repository's folder"
    ) from None

WINDOW_S = 60
TWIN = Path(__file__).with_name("twin")


def figure(found: np.ndarray | None) -> str:
    """The mean of F1 over seeds, with its range."""
    if found is None:
        return ""
    return f"{found.mean():.3f} ({found.min():.2f}–{found.max():.2f})"


def change(found: np.ndarray, beside: np.ndarray) -> str:
    """How much more F1 is than beside it on the same real days, and for how many seeds."""
    more = found - beside
    return f"{more.mean():+.3f} ({np.sum(more > 0)} of {len(more)})"


def table(
    simulated: Sequence[Day], others: Sequence[Day], real: Sequence[Day],
    rules: dict[str, list[str]], without: Sequence[str], numbers: Sequence[int], seeds: int,
) -> None:  # fmt: skip
    """Print a table: what is learnt from, and F1 for each number of real days."""
    known = set(sensors_of(simulated)) & set(sensors_of(real))
    sensors = sorted(name for name in known if not name.startswith(tuple(without)))
    if not sensors:
        raise InputError("no sensor has the same name in both: give names in a table [sensors]")
    ruled = [day.by_rules(rules) for day in simulated]
    learnt: dict[str, Sequence[Day]] = {
        "real days alone": (), "simulated days": simulated,
        "control: their activities, sensors by rules": ruled,
    }  # fmt: skip
    if others:
        learnt["other real homes"] = others
    print(f"{len(simulated)} simulated days, {len(real)} real ones; {', '.join(sensors)}\n")

    def row(name: str, cells: Sequence[str]) -> None:
        print(f"| {name} | {' | '.join(cells)} |", flush=True)

    row("learnt from, and real days:", [f"{number}" if number else "none" for number in numbers])
    print("|---" * (len(numbers) + 1) + "|")
    found = {}
    for name, days in learnt.items():
        found[name] = [
            tried(days, real, number, sensors, WINDOW_S, seeds)[:, 1] if days or number else None
            for number in numbers
        ]
        row(name, [figure(of) for of in found[name]])
        if days is ruled:
            both = zip(found["simulated days"], found[name], strict=True)
            row("**simulated against the control**", [change(ours, rule) for ours, rule in both])
    whole = one_left_out(real, sensors, min(seeds, 3))
    print(
        f"\nAll real days but one, tried on that one, each in turn: {figure(whole)}\n", flush=True
    )


def one_left_out(real: Sequence[Day], sensors: Sequence[str], seeds: int) -> np.ndarray:
    """F1 (seeds,) on all days together, each guessed by what all others taught."""
    days = [samples_of(day, sensors, WINDOW_S) for day in real]
    true = joined(days)[1]
    found = []
    for seed in range(seeds):
        guessed = [
            forest_guess(joined([*days[:n], *days[n + 1 :]]), day, seed)
            for n, day in enumerate(days)
        ]
        found.append(scores(np.concatenate(guessed), true)[1])
    return np.array(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("data", type=Path, metavar="DATA", help="folder of the real logs")
    parser.add_argument("--days", nargs="+", type=Path, required=True, metavar="DAYS")
    parser.add_argument("--home", default="ordonez_b", help="what is tried on (ordonez_b)")
    parser.add_argument("--twin", type=Path, default=TWIN, help="folder of names and rules")
    parser.add_argument("--real", nargs="+", type=int, default=[0, 1, 2, 4], metavar="N")
    parser.add_argument("--without", nargs="+", metavar="NAME", default=[],
                        help="a second table without sensors whose names begin so")  # fmt: skip
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    try:
        homes = {
            path.stem: read_home(path, logs=given.data)
            for path in sorted(given.twin.glob("*.toml"))
            if path.stem not in ("routine", "rules")
        }
        if given.home not in homes:
            raise InputError(f"--home: give one of {', '.join(homes)}")
        real = homes.pop(given.home)
        if not 0 <= max(given.real) < len(real):
            raise InputError(f"--real: {given.home} has {len(real)} days; one is to be tried")
        simulated = [day for path in given.days for day in read_home(path)]
        others = [day for days in homes.values() for day in days]
        rules = rules_of(given.twin / "rules.toml")
        for without in ([], given.without)[: 1 + bool(given.without)]:
            arguments = simulated, others, real, rules, without, given.real, given.seeds
            table(*arguments)
    except (AngenError, OSError) as error:
        raise SystemExit(f"sim_to_real: {error}") from None


if __name__ == "__main__":
    main()
