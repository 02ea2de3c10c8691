# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the history that Home Assistant exports (*History → Download data*) as CSV.

The header is `entity_id,state,last_changed`. The file lists one entity after the other, with times
in UTC.

The kind of an entity's sensor is guessed from the entity's name, such as
`binary_sensor.hall_motion`. The name can also end with a field of this program's sensors, as in
`sensor.pad_force_n`.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from ..kinds import KINDS
from ..log import Event, Value
from . import home_assistant, source
from .source import ParsedLog

HEADER = ("entity_id", "state", "last_changed")
# The header, or a line of the messages that `home_assistant` writes.
BEGINS = rb"\"?entity_id\"?,\"?state\"?,\"?last_changed\b|\{[^\n]*\"topic\""
STATES = {"on": True, "off": False, "open": True, "closed": False}
BINARY, NUMBER = {"binary_sensor", "input_boolean"}, "sensor"
# The quantity by the domain, or by a word in the name. Any other binary sensor detects motion.
OF_DOMAIN = {"light": "light", "cover": "opening"}
OF_WORD = {
    **dict.fromkeys(("door", "window", "contact", "opening", "open", "gate"), "opening"),
    **dict.fromkeys(("bed", "seat", "chair", "pad", "mat", "pressure", "occupied"), "occupancy"),
    **dict.fromkeys(("light", "lamp"), "light"),
    **dict.fromkeys(("illuminance", "lux"), "illuminance"),
    "distance": "distance",
}


class Entity(NamedTuple):
    """The sensor and the field whose values an entity of Home Assistant reports.

    `type` is the type of the field's values.
    """

    sensor: str
    kind: str
    field: str
    type: type


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
        rows = [(reader.line_num, [row[column] or "" for column in HEADER]) for row in reader]
    entities = entities_of(dict.fromkeys(name for _, (name, _, _) in rows))
    for line, (name, state, changed) in rows:
        entity = entities.get(name)
        value = _value(entity, state)
        if entity is None or value is None:
            left_out.add(line, f"'{name} {state}'")
            continue
        try:
            time = datetime.fromisoformat(changed)
        except ValueError:
            raise ValueError(f"line {line}: '{changed}' is not a time") from None
        time = time if time.tzinfo else time.replace(tzinfo=UTC)
        sensor, kind, field, _ = entity
        found.changes.append(Event(time, sensor, field, 0.0, kind, value, line))
    # The file lists one entity after the other.
    found.changes.sort(key=lambda change: change.time)
    found.notes += [left_out.text] if left_out.count else []
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
        has_all = [k.identifier for k in KINDS.values() if wanted <= {f.name for f in k.events}]
        for name, entity in found.items():
            if has_all and entity.sensor == sensor:
                found[name] = entity._replace(kind=has_all[0])
    return found


def _entity(name: str) -> Entity | None:
    domain, _, thing = name.partition(".")
    published = [(kind, field) for kind in KINDS.values() for field in kind.events]
    for kind, field in published:
        if thing.endswith(f"_{field.name}") and _fits(domain, field.type):
            sensor = thing.removesuffix(f"_{field.name}")
            return Entity(sensor, kind.identifier, field.name, field.type)
    words = [OF_WORD[word] for word in thing.split("_") if word in OF_WORD]
    quantity = OF_DOMAIN.get(domain, next(iter(words), "motion"))
    for kind, field in published:
        if field.quantity == quantity and (domain in OF_DOMAIN or _fits(domain, field.type)):
            return Entity(thing, kind.identifier, field.name, field.type)
    return None


def _fits(domain: str, field_type: type) -> bool:
    return domain in BINARY if field_type is bool else domain == NUMBER


def _value(entity: Entity | None, state: str) -> Value | None:
    """Return the value that a state stands for; None for "unavailable" or an unknown entity."""
    if entity is None or state.lower() in {"unavailable", "unknown"}:
        return None
    if entity.type is bool:
        return STATES.get(state.lower())
    if entity.type is str:
        return "" if state == home_assistant.NO_TEXT else state
    return state if source.is_number(state) else None
