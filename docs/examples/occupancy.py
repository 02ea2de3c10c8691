# SPDX-License-Identifier: GPL-3.0-or-later
"""How well do sensors tell whether somebody is in a room? A table from a folder of days:

    angen day sample_blends/angen.blend --routine sample_blends/week.toml \\
        --layout docs/examples/presence.json --start 2026-03-02 --days 2 --seed 1 --out days
    python docs/examples/occupancy.py days

The truth is in people.csv: a room is occupied in a minute if anybody is in it for more than half of
the minute. A sensor says so if one of its states `moved`, `presence` or `occupied` is on at any
time of the minute, or was in the minutes before ("held"). A second table has the seconds from
leaving a room until its sensor is off. Needs pandas.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd

STATES = ("moved", "presence", "occupied")
KINDS = {"PIR": "motion detector", "PRESENCE_RADAR": "radar", "THERMAL_ARRAY": "thermal array"}
# Minutes for which installations go on counting a room as occupied after a motion detector.
HELD = (0, 5, 15)
# Minutes after somebody left in which a false answer is a tail: a late release, or a warm seat.
TAIL = 5
# A stay in a room is long from so many minutes on: it leaves seats and beds warm.
LONG = 10


def minutes_of(days: Path) -> pd.DatetimeIndex:
    """Return the minutes of the days, the first at midnight of the first day."""
    people = pd.read_csv(days / "people.csv", parse_dates=["time"])
    first, last = people.time.min().floor("D"), people.time.max().ceil("D")
    return pd.date_range(first, last, freq="min", inclusive="left")


def truth(days: Path, minutes: pd.DatetimeIndex) -> pd.DataFrame:
    """Return whether anybody is in each room (column) in each second (row)."""
    people = pd.read_csv(days / "people.csv", parse_dates=["time"])
    people["room"] = people.room.fillna("")
    seconds = pd.date_range(
        minutes[0], minutes[-1] + pd.Timedelta("1min"), freq="s", inclusive="left"
    )
    found = {}
    rooms = [
        people[people.person == name].set_index("time").room for name in people.person.unique()
    ]
    places = [
        room[~room.index.duplicated(keep="last")].reindex(seconds, method="ffill") for room in rooms
    ]
    for room in sorted({name for each in rooms for name in each if name}):
        found[room] = sum((place == room).astype(int) for place in places) > 0
    return pd.DataFrame(found)


def states(days: Path) -> dict[tuple[str, str], pd.Series]:
    """Return the changes of each sensor's state (1 or 0) by time, by the sensor's room and kind."""
    events = pd.read_csv(days / "events.csv", parse_dates=["time"])
    events = events[events.field.isin(STATES) & events.kind.isin(KINDS)]
    found = {}
    for (name, kind), rows in events.groupby(["sensor", "kind"]):
        state = rows.set_index("time").value.astype(float)
        found[name.split(" ", 1)[1], kind] = state[~state.index.duplicated(keep="last")]
    return found


def says(state: pd.Series, minutes: pd.DatetimeIndex) -> pd.Series:
    """Return whether a sensor with the changes `state` says "occupied" in each minute."""
    # On at the begin of a minute, or switched on within it.
    begin = state.reindex(minutes, method="ffill").fillna(0.0)
    within = state.resample("min").max().reindex(minutes).fillna(0.0)
    return (begin + within) > 0


def held(on: pd.Series, more: int) -> pd.Series:
    """Return `on`, where each true minute makes the next `more` minutes true too."""
    return on.astype(int).rolling(more + 1, min_periods=1).max().astype(bool)


def answers(
    real: pd.DataFrame, sensors: dict[tuple[str, str], pd.Series]
) -> dict[str, dict[str, pd.Series]]:
    """Return whether each room counts as occupied in each minute, by sort of sensor and by room."""
    rooms = [room for room in real if any(room == of for of, _ in sensors)]
    rows = {}
    for more in HELD:
        label = f"motion detector, held {more} min" if more else "motion detector"
        rows[label] = {r: held(sensors[r, "PIR"], more) for r in rooms if (r, "PIR") in sensors}
    for kind in ("PRESENCE_RADAR", "THERMAL_ARRAY"):
        rows[KINDS[kind]] = {r: sensors[r, kind] for r in rooms if (r, kind) in sensors}
    rows["all three"] = {
        r: sum(on.astype(int) for (of, _), on in sensors.items() if of == r) > 0 for r in rooms
    }
    rows["nobody, always"] = {r: pd.Series(False, real.index) for r in rooms}
    return {label: each for label, each in rows.items() if each}


def table(days: Path) -> pd.DataFrame:
    """Return a row for each sort of sensor.

    It has the percentage of minutes that are right in each room, and the wrong minutes of all rooms
    together: those that are missed, and those in which it says "occupied" without reason (false).
    Each false minute has one cause. `passing`: somebody is in the room, for at most half of the
    minute. `tail`: somebody was there at most TAIL minutes before. `elsewhere`: somebody is in
    another room. `empty`: nobody is at home.
    """
    minutes = minutes_of(days)
    inside = truth(days, minutes)
    share = inside.resample("min").mean()
    real, some, home = share > 0.5, share > 0.0, share.max(axis=1) > 0.0
    rows = {}
    sensors = {key: says(state, minutes) for key, state in states(days).items()}
    for label, each in answers(real, sensors).items():
        row = {room: f"{100 * (on == real[room]).mean():.1f}" for room, on in each.items()}
        row["missed"] = sum(int((real[room] & ~on).sum()) for room, on in each.items())
        row |= dict.fromkeys(("false", "passing", "tail", "elsewhere", "empty"), 0)
        for room, on in each.items():
            false = on & ~real[room]
            passing, tail = false & some[room], false & ~some[room] & held(some[room], TAIL)
            rest = false & ~passing & ~tail
            causes = {"false": false, "passing": passing, "tail": tail}
            causes |= {"elsewhere": rest & home, "empty": rest & ~home}
            for cause, which in causes.items():
                row[cause] += int(which.sum())
        rows[label] = row
    return pd.DataFrame(rows).T


def releases(days: Path) -> pd.DataFrame:
    """Return how long each sort of sensor stays on after a room was left.

    A row is for a sort of sensor and short or long stays: their number, the share of them at whose
    end the sensor is on, and of these the median and the longest time in seconds until it is off.
    Stays of less than a minute are left out, and those after which somebody comes back before that.
    """
    minutes = minutes_of(days)
    inside, rows = truth(days, minutes), []
    for (room, kind), state in states(days).items():
        if room not in inside:
            continue
        change = inside[room].astype(int).diff()
        begins, ends = change[change == 1].index, change[change == -1].index
        if inside[room].iloc[0]:
            begins = begins.insert(0, inside.index[0])
        for begin, end in zip(begins, ends, strict=False):
            later = begins[begins > end]
            before, after = state[state.index <= end], state[state.index > end]
            off = after[after == 0.0]
            until = off.index[0] if len(off) else minutes[-1]
            if (end - begin).total_seconds() < 60 or (len(later) and later[0] < until):
                continue
            is_on = len(before) > 0 and before.iloc[-1] > 0.0
            stay = "at least" if end - begin >= pd.Timedelta(LONG, "min") else "less than"
            seconds = (until - end).total_seconds() if is_on else float("nan")
            rows.append((f"{KINDS[kind]}, stays of {stay} {LONG} min", is_on, seconds))
    groups = pd.DataFrame(rows, columns=["sensor", "on", "seconds"]).groupby("sensor")
    return pd.DataFrame(
        {
            "stays": groups.size(),
            "on, %": (100 * groups.on.mean()).round().astype(int),
            "median s": groups.seconds.median().round(1),
            "longest s": groups.seconds.max().round(1),
        }
    ).astype(str)


def text(table: pd.DataFrame) -> str:
    """Return a table in Markdown."""
    head = [["", *table.columns], ["---"] * (len(table.columns) + 1)]
    rows = [[name, *row] for name, row in zip(table.index, table.to_numpy().tolist(), strict=True)]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in head + rows)


if __name__ == "__main__":
    if len(sys.argv) != 2 or not (Path(sys.argv[1]) / "people.csv").exists():
        sys.exit("occupancy: give a folder of days, as `angen day … --out DAYS` writes it")
    print(text(table(Path(sys.argv[1]))), text(releases(Path(sys.argv[1]))), sep="\n\n")
