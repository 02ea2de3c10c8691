# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the history that Home Assistant exports (*History → Download data*) as CSV.

The header is `entity_id,state,last_changed`. The file lists one entity after the other, with times
in UTC.

An entity's name says what its sensor measures, by the last word that is known, such as
`binary_sensor.hall_motion`. The name can also end with a field of this program's sensors, as in
`sensor.pad_force_n`. Other entities are left out.

The file has no units, so numbers of other programs' entities need a unit that the user gives. A
column `unit_of_measurement`, as scripts add it, is read.
"""

from __future__ import annotations

import csv
import re
from collections import defaultdict
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from ..fields import LOGGED_KINDS
from ..log import Event, Value
from ..wording import listed
from . import home_assistant, source
from .source import ParsedLog
from .units import MOST, UNITS, UnitOf

HEADER = ("entity_id", "state", "last_changed")
UNIT = "unit_of_measurement"
# The header, or a line of the messages that `home_assistant` writes.
BEGINS = rb"\"?entity_id\"?,\"?state\"?,\"?last_changed\b|\{[^\n]*\"topic\""
STATES = {"on": True, "off": False, "open": True, "closed": False}
BINARY, NUMBER = {"binary_sensor", "input_boolean"}, "sensor"
# The quantity, or the field, by the domain or by a word in the name.
OF_DOMAIN = {"light": "light", "cover": "opening"}
OF_WORD = {
    **dict.fromkeys(("motion", "pir", "movement", "moving", "occupancy"), "motion"),
    **dict.fromkeys(("presence", "target"), "presence"),
    **dict.fromkeys(("door", "window", "contact", "opening", "open", "gate"), "opening"),
    **dict.fromkeys(("bed", "seat", "chair", "pad", "mat", "pressure", "occupied"), "occupancy"),
    **dict.fromkeys(("light", "lamp"), "light"),
    **dict.fromkeys(("illuminance", "lux"), "illuminance"),
    "distance": "distance",
}
# What else entities report, and what devices report about themselves: `front_door_battery`.
OTHER = set(
    """
    battery charging connectivity connection online status wan update problem fault error tamper
    power plug running lock locked safety smoke gas co moisture leak water heat cold sound noise
    vibration voltage current energy signal strength rssi linkquality lqi temperature humidity
    co2 uptime speed angle firmware ping duration timeout delay threshold sensitivity enabled
    enable fan heater heating pump switch outlet mode alarm siren led
    """.split()  # noqa: SIM905
)
KNOWN = OTHER | OF_WORD.keys()


class Entity(NamedTuple):
    """The sensor and the field whose values an entity of Home Assistant reports.

    `type` is the type of the field's values. `is_own` says that the entity's name has the field's
    name, and so its unit.
    """

    sensor: str
    kind: str
    field: str
    type: type
    is_own: bool = False


def read(path: Path) -> ParsedLog:
    """Read a history, or the file of messages that `home_assistant.write` makes.

    The changes are sorted by time.
    """
    with open(path, "rb") as file:
        if file.read(4).removeprefix(b"\xef\xbb\xbf").startswith(b"{"):
            return home_assistant.read(path)
    found = ParsedLog([], in_utc=True)
    left_out = source.RowTally("state", "left out")
    with open(path, newline="", encoding="utf-8-sig") as text:
        reader = csv.DictReader(text)
        rows = [
            (reader.line_num, [row.get(column) or "" for column in (*HEADER, UNIT)])
            for row in reader
        ]
    names = dict.fromkeys(name for _, (name, *_) in rows)
    entities = entities_of(names)
    published = {f.name: f.unit for kind in LOGGED_KINDS.values() for f in kind.events}
    for line, (name, state, changed, unit) in rows:
        entity = entities.get(name)
        if entity is None:
            continue
        sensor, kind, field, _, is_own = entity
        value = _value(entity, state)
        if value is None:
            # Such rows have no unit either.
            left_out.add(line, f"'{name} {state}'")
            continue
        if published[field] in UNITS:
            own = published[field] if is_own else ""
            origin = UnitOf(name, unit or own, bool(unit))
            before = found.units.setdefault((sensor, field), origin)
            if before != origin:
                units = " and ".join(f"'{one}'" if one else "none" for one in (before.unit, unit))
                raise ValueError(
                    f"line {line}: {name} has had two units, {units}: write its numbers in one"
                )
        try:
            time = datetime.fromisoformat(changed)
        except ValueError:
            raise ValueError(f"line {line}: '{changed}' is not a time") from None
        time = time if time.tzinfo else time.replace(tzinfo=UTC)
        found.changes.append(Event(time, sensor, field, 0.0, kind, value, line))
    # Entities without any reading, whose unit a user may give.
    for name, (sensor, _, field, *_) in entities.items():
        if published[field] in UNITS:
            found.units.setdefault((sensor, field), UnitOf(name))
    # The file lists one entity after the other.
    found.changes.sort(key=lambda change: change.time)
    found.notes += [left_out.text] if left_out.count else []
    if unknown := [name for name in names if name not in entities]:
        found.notes.append(
            "left out, because their names do not say that they are a sensor of a known kind: "
            f"{listed(unknown, MOST)}; rename them in the file, such as binary_sensor.hall_motion"
        )
    return found


def entities_of(names: Iterable[str]) -> dict[str, Entity]:
    """Return the sensor and the field of each entity of Home Assistant, by the entity's name.

    Entities that match no field of any kind are left out.
    """
    found = {name: entity for name in names if (entity := _entity(name)) is not None}
    fields: dict[str, set[str]] = defaultdict(set)
    for entity in found.values():
        fields[entity.sensor].add(entity.field)
    # Kinds share names of fields: use the first kind that has all fields of the sensor.
    for sensor, wanted in fields.items():
        has_all = [
            k.identifier for k in LOGGED_KINDS.values() if wanted <= {f.name for f in k.events}
        ]
        for name, entity in found.items():
            if has_all and entity.sensor == sensor:
                found[name] = entity._replace(kind=has_all[0])
    return found


def _entity(name: str) -> Entity | None:
    domain, _, thing = name.partition(".")
    published = [(kind, field) for kind in LOGGED_KINDS.values() for field in kind.events]
    for kind, field in published:
        if thing.endswith(f"_{field.name}") and _fits(domain, field.type):
            sensor = thing.removesuffix(f"_{field.name}")
            return Entity(sensor, kind.identifier, field.name, field.type, is_own=True)
    # Home Assistant names an entity after its device, and then after what it measures.
    words = [word for word in re.split("[^a-z0-9]+", thing.lower()) if word in KNOWN]
    quantity = OF_DOMAIN.get(domain) or OF_WORD.get(words[-1] if words else "")
    for kind, field in published:
        is_meant = quantity in (field.quantity, field.name)
        if is_meant and (domain in OF_DOMAIN or _fits(domain, field.type)):
            return Entity(thing, kind.identifier, field.name, field.type)
    return None


def _fits(domain: str, field_type: type) -> bool:
    return domain in BINARY if field_type is bool else domain == NUMBER


def _value(entity: Entity, state: str) -> Value | None:
    """Return the value that a state stands for; None for "unavailable"."""
    if state.lower() in {"unavailable", "unknown"}:
        return None
    if entity.type is bool:
        return STATES.get(state.lower())
    if entity.type is str:
        return "" if state == home_assistant.NO_TEXT else state
    return state if source.is_number(state) else None
