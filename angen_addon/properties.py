# SPDX-License-Identifier: GPL-3.0-or-later
"""Register the Blender properties of sensors, made from the dataclasses of `sensor_logic`."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Collection, Material, Object, PropertyGroup, Scene, Text

from ..sensor_logic.kinds import KINDS, NO_KIND, owner_properties
from ..sensor_logic.parameters import READING, Parameters, Spec, defaults, specs
from .runtime import handlers
from .scene.lengths import OVERRIDABLE, SUBTYPES, property_group, with_unit
from .scene.sensors import known_rooms
from .translations.dictionary import CONTEXT
from .translations.interface import SOURCE, in_context

# Decimals in the interface by unit, where the usual three are too few or too many.
PRECISIONS = {"m": 4, "m²": 6, "Ω": 0, "lx": 2, READING: 2}

# Blender types that can have a temperature.
WARM = (Object, Collection, Material)
POINTERS = {"Object": Object, "Collection": Collection, "Text": Text}


def _settings_changed(self: PropertyGroup, context: bpy.types.Context) -> None:
    handlers.settings_changed(self.id_data)


def _ignored_changed(self: Any, context: bpy.types.Context) -> None:
    # Blender does not know what this property affects. The tag reports the update to the probes.
    self.update_tag(refresh={"OBJECT"})
    _settings_changed(self, context)


def _load_changed(self: Any, context: bpy.types.Context) -> None:
    self.id_data.update_tag(refresh={"OBJECT"})
    _settings_changed(self, context)


def _owner_changed(self: Any, context: bpy.types.Context) -> None:
    if isinstance(self.id_data, Object):
        _load_changed(self, context)
    else:
        _warmth_changed(self, context)


def _warmth_changed(self: Any, context: bpy.types.Context) -> None:
    # Materials and collections have only the tag without `refresh`.
    self.id_data.update_tag()
    _settings_changed(self, context)


def _kind_changed(self: Any, context: bpy.types.Context) -> None:
    """Set the update rate to the default of the sensor's new kind, unless the user chose a rate."""
    defaults_of_kinds = {kind.update_rate for kind in KINDS.values()}
    if self.kind != NO_KIND and (
        not self.is_property_set("update_rate") or self.update_rate in defaults_of_kinds
    ):
        self.update_rate = KINDS[self.kind].update_rate
    # Its mesh can be a housing from now on, or no longer.
    _load_changed(self, context)


def _none_where_unknown(known_numbers: set[int]) -> dict[str, Any]:
    """Return getters and setters for the property `kind` that read an unknown number as "no kind".

    A newer version of the extension may have written a kind that this version does not know. The
    object is then no sensor here, but the file keeps its number. Without these functions Blender
    warns at each access.
    """
    if bpy.app.version >= (5, 0):
        return {"get_transform": lambda _, number, is_set: number if number in known_numbers else 0}

    def read(group: Any) -> int:
        number = group.get("kind", 0)
        return number if number in known_numbers else 0

    def write(group: Any, number: int) -> None:
        group["kind"] = number

    return {"get": read, "set": write}


def _tip(spec: Spec) -> str:
    return f"{spec.tip}{SOURCE}{spec.source}" if spec.source else spec.tip


def _blender_property(default: Any, spec: Spec) -> Any:
    """Return the bpy property of one parameter.

    Its hard limits are looser than the valid range. An invalid value therefore stays, and the panel
    reports it; Blender would change it silently.
    """
    facts: dict[str, Any] = {"name": with_unit(spec.label, spec.unit), "description": _tip(spec)}
    if spec.pointer:
        return PointerProperty(type=POINTERS[spec.pointer], **facts)
    facts["default"] = default
    if spec.choices:
        items = [(c.identifier, c.label, c.tip, c.number) for c in spec.choices]
        return EnumProperty(items=items, **facts)
    if isinstance(default, bool):
        return BoolProperty(**facts)
    if isinstance(default, str):
        return StringProperty(**facts)
    facts["min"], facts["soft_min"] = min(0, 2 * spec.minimum), spec.minimum
    if math.isfinite(spec.maximum):
        facts["soft_max"] = spec.maximum
    if isinstance(default, int):
        facts = {k: int(v) if k in {"min", "soft_min", "soft_max"} else v for k, v in facts.items()}
        return IntProperty(**facts)
    if spec.unit in SUBTYPES:
        facts["subtype"] = SUBTYPES[spec.unit]
    facts["precision"] = PRECISIONS.get(spec.unit, 3)
    facts["step"] = 100 if spec.unit == "rad" else 10 if spec.unit == "s" else 1
    return FloatProperty(**facts)


def _group_of(name: str, parameters: type[Parameters], update: Any = _settings_changed) -> type:
    known = defaults(parameters)
    return property_group(
        name,
        {key: _blender_property(known[key], spec) for key, spec in specs(parameters).items()},
        override=OVERRIDABLE,
        update=update,
    )


def _sensor_group(groups: dict[str, type]) -> type:
    kinds = [(NO_KIND, "None", "Not a sensor", "NONE", 0)]
    kinds += [(k.identifier, k.label, k.tip, k.icon, k.number) for k in KINDS.values()]
    properties = {
        "kind": EnumProperty(
            name="Kind",
            description="Kind of sensor that this object is",
            items=kinds,
            options=set(),
            update=_kind_changed,
            **_none_where_unknown({number for *_, number in kinds}),
        ),
        "enabled": BoolProperty(
            name="Enabled",
            description="Simulate this sensor. If off, it publishes nothing and takes no time",
            default=True,
            update=_settings_changed,
        ),
        "update_rate": FloatProperty(
            name="Update rate (Hz)",
            description="How often the sensor publishes a reading, in hertz. It cannot be animated",
            options=set(),
            default=1.0,
            min=0.0,
            soft_min=0.1,
            soft_max=100.0,
            update=_settings_changed,
        ),
        "room": StringProperty(
            name="Room",
            description="Name of the room that the sensor is in. Tables, timeline and report are "
            "sorted by room. On an object that is Ignored by sensors: the room that it encloses",
            options=set(),
            search=known_rooms,
            search_options={"SUGGESTION"},
        ),
        "housing_solid": BoolProperty(
            name="Solid Housing",
            description="Other sensors see this sensor's housing. If off, their rays and waves "
            "pass through it, so that two sensors can be in one place",
            options=set(),
            update=_load_changed,
        ),
        "preset": StringProperty(
            name="Preset",
            description="Identifier of the preset that was last applied",
            options={"HIDDEN"},
        ),
        "active": BoolProperty(
            name="Active",
            description="Output of the sensor: moved, open, pressed or lit. Drivers can read it",
        ),
        "value": FloatProperty(
            name="Value",
            description="Output of the sensor: its main reading, such as range, force or light. "
            "Drivers can read it",
            precision=4,
        ),
    }
    for kind in KINDS.values():
        properties[kind.attribute] = PointerProperty(type=groups[kind.attribute], name=kind.label)
    return property_group("AngenSensor", properties, override=OVERRIDABLE)


LOAD = property_group(
    "AngenLoad",
    {
        "mass": FloatProperty(
            name="Mass (kg)",
            description="Mass with which this animated object presses on pressure sensors, such as "
            "a person's mesh or armature. 0: no mass. Rigid bodies that physics moves have their "
            "own mass",
            min=0.0,
            soft_max=200.0,
            precision=2,
            step=10,
        ),
        "tolerance": FloatProperty(
            name="Contact tolerance",
            description="The body presses on surfaces that are less than this distance below it",
            subtype="DISTANCE",
            default=0.03,
            min=0.0,
            soft_max=0.2,
        ),
    },
    override=OVERRIDABLE,
    update=_load_changed,
)
WARMTH = property_group(
    "AngenWarmth",
    {
        "use_temperature": BoolProperty(
            name="Own temperature",
            description="Set a temperature here, which pyroelectric motion detectors sense. The "
            "temperature of a material overrides that of its object, which overrides "
            "that of its collections",
        ),
        "temperature": FloatProperty(
            name="Temperature (°C)",
            description="Temperature of the surface in degrees Celsius. Under an insulation, such "
            "as clothes, that of the skin",
            default=30.0,
            min=-273.15,
            soft_min=-20.0,
            soft_max=100.0,
            precision=1,
            step=50,
        ),
        "emissivity": FloatProperty(
            name="Emissivity",
            description="Share of a black body's radiation that the surface emits. The surface "
            "reflects its surroundings by the rest. Skin, cloth, paint, wood and glass: 0.9 to "
            "0.98; bare metal: 0.05 to 0.3",
            default=0.95,
            min=0.0,
            max=1.0,
        ),
        "insulation": FloatProperty(
            name="Insulation (clo)",
            description="Insulation over the temperature, in clo (0.155 m²·K/W). The surface is "
            "then between it and the ambient temperature, and follows both. Light summer clothes: "
            "0.5; indoor clothes in winter: 1; a duvet: 5. 0: bare",
            default=0.0,
            min=0.0,
            soft_max=6.0,
            precision=2,
            step=10,
        ),
    },
    override=OVERRIDABLE,
    update=_warmth_changed,
)
# Properties that readings depend on.
SCENE_SETTINGS = {
    "angen_seed": IntProperty(
        name="Seed",
        description="Seed of the noise of all sensors. The same file with the same seed gives the "
        "same log",
        min=0,
        options=set(),
    ),
    "angen_substeps": IntProperty(
        name="Substeps",
        description="Number of times in each frame at which sensors can read, for movement that "
        "is too fast for the frame rate. While scrubbing, sensors read whole frames "
        "only",
        default=1,
        min=1,
        soft_max=64,
        options=set(),
    ),
    "angen_luminous_efficacy": FloatProperty(
        name="Luminous efficacy (lm/W)",
        description="Lumens for each watt of Blender's light, for light sensors that read lux. "
        "683: as in Blender's glTF exporter. 179: equal-energy white, as in Radiance",
        default=683.0,
        min=0.0,
        soft_max=683.0,
        options=set(),
    ),
    "angen_light_reference": IntProperty(
        name="Reference paths",
        description="Remove most of the noise from a run with Cycles. The run first measures the "
        "light of each lamp at the first frame with this many light paths. It then corrects all "
        "later readings by this reference, although these use only a few paths (Samples). Useful "
        "for many updates. 0: off",
        default=0,
        min=0,
        soft_max=65536,
        max=1 << 20,
        options=set(),
    ),
    "angen_ambient_temperature": FloatProperty(
        name="Ambient temperature (°C)",
        description="Temperature of everything without a temperature of its own, in degrees "
        "Celsius, for pyroelectric motion detectors",
        default=20.0,
        min=-273.15,
        soft_min=-20.0,
        soft_max=45.0,
        precision=1,
        step=50,
    ),
    "angen_warmth_left": BoolProperty(
        name="Warmth left behind",
        description="Thermal arrays see for minutes that seats and beds are warm where somebody "
        "rested. Bodies are what has a temperature, and a mass or an armature",
        default=True,
        options=set(),
    ),
    "angen_ray_caster": EnumProperty(
        name="Ray caster",
        description="How the rays of sensors are cast. Both methods give the same events",
        items=[
            ("FAST", "Fast", "Cast rays again only where something moved", 0),
            ("SCENE", "Reference", "Cast every ray with Blender's scene.ray_cast", 1),
        ],
        options=set(),
    ),
}
SCENE = {
    **{
        name: prop.function(update=_settings_changed, **prop.keywords)
        for name, prop in SCENE_SETTINGS.items()
    },
    "angen_start": StringProperty(
        name="Start Time",
        description="Date and time of the scene's first frame, such as 2026-03-01T08:00. Exported "
        "files and panels then show the time of day. Empty: they show seconds",
        options=set(),
    ),
    "angen_live": BoolProperty(
        name="Live",
        description="Read the sensors at the playhead while there is no recording",
        default=True,
    ),
    "angen_recording": IntProperty(
        name="Recording",
        description="Identifier of the present recording, so that undo restores an earlier one",
        options={"HIDDEN"},
    ),
    "angen_recording_aside": IntProperty(
        name="Recording Aside",
        description="Identifier of the home's recording, while residents' day is shown",
        options={"HIDDEN"},
    ),
}
KIND_GROUPS = {
    kind.attribute: _group_of(f"Angen{kind.parameters.__name__}", kind.parameters)
    for kind in KINDS.values()
}
SENSOR = _sensor_group(KIND_GROUPS)
# The properties that kinds need of objects and materials, by the owner's type and the attribute.
OWNERS = {"Object": Object, "Material": Material}
OWNER_GROUPS = {
    made.attribute: _group_of(f"Angen{made.parameters.__name__}", made.parameters, _owner_changed)
    for owner in OWNERS
    for made in owner_properties(owner)
}
_register_groups, _unregister_groups = bpy.utils.register_classes_factory(
    (*KIND_GROUPS.values(), SENSOR, LOAD, WARMTH, *OWNER_GROUPS.values())
)


def register() -> None:
    _register_groups()
    Object.angen_sensor = PointerProperty(type=SENSOR, override=OVERRIDABLE)
    Object.angen_load = PointerProperty(type=LOAD, override=OVERRIDABLE)
    for owner in WARM:
        owner.angen_warmth = PointerProperty(type=WARMTH, override=OVERRIDABLE)
    for name, owner in OWNERS.items():
        for made in owner_properties(name):
            group = OWNER_GROUPS[made.attribute]
            setattr(owner, made.attribute, PointerProperty(type=group, override=OVERRIDABLE))
    Object.angen_ignored = BoolProperty(
        translation_context=CONTEXT,
        name="Ignored by sensors",
        description="Hide this object from all sensors, for example a box that marks a room",
        options=set(),
        update=_ignored_changed,
        override=OVERRIDABLE,
    )
    for name, prop in SCENE.items():
        setattr(Scene, name, in_context(prop))


def unregister() -> None:
    for name in reversed(SCENE):
        delattr(Scene, name)
    del Object.angen_ignored
    for name, owner in OWNERS.items():
        for made in owner_properties(name):
            delattr(owner, made.attribute)
    for owner in WARM:
        del owner.angen_warmth
    del Object.angen_load
    del Object.angen_sensor
    _unregister_groups()
