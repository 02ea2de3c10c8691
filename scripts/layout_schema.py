# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the JSON schema of layouts, for checks and completion in editors.

It is made from the parameters of the kinds.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from sensor_logic.kind import Kind  # noqa: E402
from sensor_logic.kinds import KINDS  # noqa: E402
from sensor_logic.layout.entries import EMPTY_KEYS, MARKS, OTHERS  # noqa: E402
from sensor_logic.parameters import READING, Spec, defaults, specs  # noqa: E402

FILE = ROOT / "sensor_logic" / "layout" / "layout.schema.json"
VECTOR = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
NAME = {"type": "string", "minLength": 1}
NO_OR_NAME = {"type": ["string", "null"]}
OUTPUT_ONLY = {"description": "Written by list --json, and not read"}
# The keys of a sensor; `_of_kind` adds the parameters.
SHAPES: dict[str, dict[str, Any]] = {
    "name": {
        "description": "Name of the sensor's object. The sensor of this name is changed, or added",
        **NAME,
    },
    "kind": {"description": "Kind of sensor; a new one needs it", "enum": list(KINDS)},
    "room": {"description": "Room that it hangs in", "type": "string"},
    "enabled": {
        "description": "false: it costs nothing and reports nothing",
        "type": "boolean",
    },
    "update_rate": {
        "description": "How often it publishes a reading (Hz)",
        "type": "number",
        "exclusiveMinimum": 0,
    },
    "location": {
        "description": "x, y, z in metres: in the home, or from what relative_to names. A new "
        "sensor needs it",
        **VECTOR,
    },
    "rotation": {"description": "XYZ Euler angles in radians, as Blender has them", **VECTOR},
    "look": {
        "description": "Instead of rotation: the direction of its −Z axis; +Y is up as far as it "
        "goes",
        **VECTOR,
    },
    "relative_to": {
        "description": "Object from whose origin and along whose axes location, rotation and look "
        "are measured, in metres whatever its scale",
        **NAME,
    },
    "parent": {
        "description": "Object that it moves with; null: none. Its place is still that in the home",
        **NO_OR_NAME,
    },
    "collection": {
        "description": "Collection that it is in, which is made where there is none; null: that of "
        "the scene itself",
        **NO_OR_NAME,
    },
    "bounds": {
        "description": "Least and greatest corner of its solid in its own axes (m): a new sensor "
        "gets the housing of this size, or a box. null: an empty",
        "type": ["array", "null"],
        "items": VECTOR,
        "minItems": 2,
        "maxItems": 2,
    },
    "preset": {
        "description": "A known part, whose values those under parameters replace",
        "type": "string",
    },
    "parameters": {
        "description": "Parameters of its kind, in SI units and radians",
        "type": "object",
    },
    "empties": {
        "description": "Empties that its parameters name, such as a magnet, by name: made where "
        "there is none",
        "type": "object",
    },
    "texts": {
        "description": "Texts that its parameters name, such as a lens table, by name: their lines",
        "type": "object",
        "additionalProperties": {"type": "array", "items": {"type": "string"}},
    },
    "library": {"description": "File that a linked sensor is of", "type": "string"},
    "simulated": OUTPUT_ONLY,
    "reading": OUTPUT_ONLY,
    "units": OUTPUT_ONLY,
}
SHAPES["empties"]["additionalProperties"] = {
    "type": "object",
    "properties": {key: SHAPES[key] for key in EMPTY_KEYS},
    "additionalProperties": False,
}
NUMBER = {"type": "number"}
LEAVES = ("DOOR", "DRAWER", "CURTAIN", "CUPBOARD")
USES = ("NONE", "STAND", "SIT", "LIE", "USE", "LAMP", "TAP", "APPLIANCE", *LEAVES)
# The properties of a mark. A test holds that Blender has the same.
MARK: dict[str, dict[str, Any]] = {
    "use": {"description": "What residents do there; NONE: nothing", "enum": list(USES)},
    "room": {"description": "Room of the place; empty: guessed", "type": "string"},
    "facing": {
        "description": "Where residents look there, or where the head lies: angle about the "
        "object's Z from its front (rad). A new mark guesses it",
        **NUMBER,
    },
    "away": {
        "description": "Distance from the front to the resident (m); 0: as near as possible",
        **NUMBER,
        "minimum": 0.0,
    },
    "motion": {
        "description": "How the leaf moves",
        "enum": ["AUTO", "LEFT", "RIGHT", "SLIDING"],
    },
    "other_side": {
        "description": "Opens to the other side, or slides to the other end",
        "type": "boolean",
    },
    "angle": {
        "description": "Angle of the leaf from shut to open (rad)",
        **NUMBER,
        "minimum": 0.0,
        "maximum": math.pi * (1 + 1e-6),
    },
    "slide": {
        "description": "Distance from shut to open (m); 0: nearly the whole width, or depth",
        **NUMBER,
        "minimum": 0.0,
    },
    "entrance": {"description": "Residents come and leave by this door", "type": "boolean"},
    "switch": {"description": "Object where the lamp is switched", **NO_OR_NAME},
}


def schema_text() -> str:
    """Return the text of the schema file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def schema() -> dict[str, Any]:
    """Return the schema (draft 7, which most editors know)."""
    sensor = {
        "type": "object",
        "properties": SHAPES,
        "required": ["name"],
        "additionalProperties": False,
        "dependencies": {"look": {"not": {"required": ["rotation"]}}},
        "allOf": [_of_kind(kind) for kind in KINDS.values()],
    }
    sensors = {"type": "array", "items": {"$ref": "#/definitions/sensor"}}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Layout of sensors in a home",
        "description": "What `angen apply` reads and `angen list --json` prints",
        "definitions": {"sensor": sensor, "sensors": sensors},
        "oneOf": [
            {"$ref": "#/definitions/sensors"},
            {
                "type": "object",
                "properties": {
                    "$schema": {"type": "string"},
                    "sensors": {"$ref": "#/definitions/sensors"},
                    OTHERS: {
                        "description": "false: switches off all sensors that the layout does not "
                        "name; true: on",
                        "type": "boolean",
                    },
                    MARKS: {
                        "description": "What residents do at objects, by the objects' names",
                        "type": "object",
                        "additionalProperties": {
                            "type": "object",
                            "properties": MARK,
                            "additionalProperties": False,
                        },
                    },
                },
                "required": ["sensors"],
                "additionalProperties": False,
            },
        ],
    }


def _of_kind(kind: Kind) -> dict[str, Any]:
    """Return the schema of the presets and parameters of a kind."""
    known = defaults(kind.parameters)
    properties = {
        name: _parameter(known[name], spec) for name, spec in specs(kind.parameters).items()
    }
    # An enum needs an item; the schema `false` rejects every value.
    presets = bool(kind.presets) and {"enum": [preset.identifier for preset in kind.presets]}
    return {
        "if": {"properties": {"kind": {"const": kind.identifier}}, "required": ["kind"]},
        "then": {
            "properties": {
                "preset": presets,
                "parameters": {"properties": properties, "additionalProperties": False},
            }
        },
    }


def _parameter(default: Any, spec: Spec) -> dict[str, Any]:
    """Return the schema of a parameter."""
    unit = f" ({spec.unit})" if spec.unit not in ("", READING) else ""
    facts = {"title": f"{spec.label}{unit}", "description": spec.tip, "default": default}
    if spec.pointer:
        return facts | NO_OR_NAME
    if spec.choices:
        return facts | {"enum": [choice.identifier for choice in spec.choices]}
    if isinstance(default, bool):
        return facts | {"type": "boolean"}
    if isinstance(default, str):
        return facts | {"type": "string"}
    facts["type"] = "integer" if isinstance(default, int) else "number"
    facts["exclusiveMinimum" if spec.positive else "minimum"] = spec.minimum
    if math.isfinite(spec.maximum):
        # Blender stores angles in single precision, in which π is rounded up.
        facts["maximum"] = spec.maximum * (1 + 1e-6) if spec.unit == "rad" else spec.maximum
    return facts


if __name__ == "__main__":
    FILE.write_text(schema_text(), encoding="utf-8")
