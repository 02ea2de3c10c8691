# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the nodes of materials, and make the materials of light scenes.

A *pane* is thin glass, as in a window. Lamps and the sun must shine through it. But Cycles sends no
shadow ray through refraction, so that a pane of glass hides all lamps behind it.

A plane-parallel pane does not bend the light that passes. So in a light scene, each face of a thin,
flat, smooth pane reflects by Fresnel's equations. It lets the rest pass straight, tinted by the
glass. A closed pane, including all reflections between its faces, then lets (1 − R)/(1 + R) pass.
At an index of refraction of 1.5 that is 92 % from the front. A single sheet of faces stands for
both faces of a pane. The user's materials are not changed.

Reference: Born and Wolf, Principles of Optics, section 1.5 (Fresnel's formulae).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import bpy
import numpy as np

from ....sensor_logic.model import Array
from ..instances import with_instanced
from ..sensors import unit_scale

GREY = np.full(3, 0.5)
CLEAR = {"BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION"}
DEEPEST = 8
# Reflectance of window glass (n = 1.5) from the front.
FRONT_FRESNEL = 0.04
COLOURED = {"BSDF_DIFFUSE", "BSDF_TRANSLUCENT", "BSDF_GLOSSY", "BSDF_METALLIC"}
# Rougher glass scatters, and Cycles then sends shadow rays through it.
SMOOTH = 0.02
# m: the greatest thickness of glazing, with its cavities.
THIN = 0.05
# m: smaller objects of glass, such as bottles, hide little.
LARGE = 0.3
# The least fraction of a pane's area that is aligned with its sides, and the cosine of the largest
# angle (8°) that counts as aligned.
FLAT, ALIGNED = 0.9, 0.99


def has_nodes(owner: Any) -> bool:
    """Return whether a lamp or a world uses nodes. Since Blender 5.0, each node tree is used."""
    return bool(owner.node_tree and (bpy.app.version >= (5, 0) or owner.use_nodes))


class Nodes:
    """A new material, to which nodes are added. `own` registers a new datablock."""

    def __init__(self, own: Any) -> None:
        self.material = own(bpy.data.materials.new(".angen_light"))
        if not self.material.node_tree:
            self.material.use_nodes = True
        self._tree = self.material.node_tree
        self._tree.nodes.clear()

    def add(self, kind: str, operation: str = "", **inputs: Any) -> Any:
        """Add a node, set its inputs, and return it.

        An input is named in lower case, or by `_` and its index. Its value is a constant, or the
        output socket of another node, which is then linked.
        """
        node = self._tree.nodes.new(kind)
        if operation:
            node.operation = operation
        for name, source in inputs.items():
            to = node.inputs[int(name[1:]) if name[1:].isdigit() else name.capitalize()]
            if isinstance(source, bpy.types.NodeSocket):
                self._tree.links.new(source, to)
            else:
                to.default_value = source
        return node

    def vector(self, name: str) -> Any:
        """Add an Attribute node for the attribute `name`, and return its vector output."""
        node = self.add("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs["Vector"]


class Surfaces:
    """The reflectances of materials, by session uid. Make a new object after materials changed."""

    def __init__(self) -> None:
        self._materials: dict[int, Any] = {}
        self._known: dict[int, Array] = {0: np.full(3, 0.8)}

    def reflectance(self, uid: int) -> Array:
        """Return the reflectance (3,) of a material; without one (uid 0), Cycles's default grey."""
        if uid not in self._known:
            self._materials = self._materials or {m.session_uid: m for m in bpy.data.materials}
            material = self._materials.get(uid)
            self._known[uid] = self._known[0] if material is None else _reflectance(material)
        return self._known[uid]


def _reflectance(material: Any) -> Array:
    shown = np.array(material.diffuse_color[:3], np.float64)
    tree = material.node_tree
    outputs = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"] if tree else []
    if not outputs or not outputs[0].inputs["Surface"].links:
        return shown
    return _reflected(outputs[0].inputs["Surface"], shown, DEEPEST)


def _reflected(socket: Any, shown: Array, depth: int) -> Array:
    """Return the fraction (3,) that the shader linked to a socket reflects; half if unknown.

    `shown` (3,) is the material's viewport colour, used if a colour input is linked. `depth` is the
    most nodes to follow.
    """
    if not socket.links or depth == 0:
        return np.zeros(3)
    node = socket.links[0].from_node
    if node.type == "MIX_SHADER":
        one, two = (_reflected(node.inputs[i], shown, depth - 1) for i in (1, 2))
        factor = _factor(node.inputs[0], depth - 1)
        return np.asarray((1.0 - factor) * one + factor * two, np.float64)
    if node.type == "BSDF_PRINCIPLED":
        through, alpha = _value(node, "Transmission Weight"), _value(node, "Alpha")
        return _colour(node, "Base Color", shown) * alpha * (1.0 - through)
    if node.type in COLOURED:
        return _colour(node, "Color", shown)
    return np.zeros(3) if node.type in CLEAR | {"EMISSION"} else GREY


def _factor(socket: Any, depth: int) -> float:
    """Return the factor of a mix node for a shadow ray that comes from the front."""
    if not socket.is_linked or depth == 0:
        return float(socket.default_value)
    link = socket.links[0]
    node = link.from_node
    if node.type == "LIGHT_PATH":
        return float(link.from_socket.name == "Is Shadow Ray")
    if node.type == "NEW_GEOMETRY":
        return 0.0
    if node.type == "FRESNEL":
        return FRONT_FRESNEL
    if node.type == "MATH" and node.operation == "MULTIPLY":
        return _factor(node.inputs[0], depth - 1) * _factor(node.inputs[1], depth - 1)
    return 0.5


def _value(node: Any, name: str) -> float:
    socket = node.inputs.get(name)
    return 0.0 if socket is None else float(socket.default_value)


def _colour(node: Any, name: str, otherwise: Array) -> Array:
    socket = node.inputs[name]
    return otherwise if socket.is_linked else np.array(socket.default_value[:3], np.float64)


def glows(material: Any) -> bool:
    """Return whether the nodes of a material can emit light."""
    for node in _nodes(material.node_tree, set()):
        if node.type in {"EMISSION", "BACKGROUND"}:
            return True
        strength = node.inputs.get("Emission Strength")
        if strength is not None and (strength.is_linked or strength.default_value != 0.0):
            colour = node.inputs.get("Emission Color")
            if colour is None or colour.is_linked or any(colour.default_value[:3]):
                return True
    return False


def is_clear(material: Any) -> bool:
    """Return whether the nodes of a material can let light pass."""
    for node in _nodes(material.node_tree, set()):
        if node.type in CLEAR or node.type == "BSDF_TRANSLUCENT":
            return True
        for name, opaque in (("Alpha", 1.0), ("Transmission Weight", 0.0)):
            socket = node.inputs.get(name) if node.type == "BSDF_PRINCIPLED" else None
            if socket is not None and (socket.is_linked or socket.default_value != opaque):
                return True
    return False


def _nodes(tree: Any, seen: set[int]) -> Any:
    if tree is None or tree.as_pointer() in seen:
        return
    seen.add(tree.as_pointer())
    for node in tree.nodes:
        yield node
        if node.type == "GROUP":
            yield from _nodes(node.node_tree, seen)


class Glass(NamedTuple):
    """The properties of smooth glass.

    Attributes
    ----------
    tint
        The factors (red, green, blue) by which one face tints light.
    ior
        The index of refraction.
    """

    tint: tuple[float, float, float]
    ior: float


class Panes:
    """Makes stand-ins: objects that replace the user's panes of glass in a light scene.

    `own` is a function that registers each new datablock.
    """

    def __init__(self, scene: Any, depsgraph: Any, own: Callable[[Any], Any]) -> None:
        self._metres = unit_scale(scene)
        self._depsgraph = depsgraph
        self._own = own
        self._made: dict[tuple[Glass, bool], Any] = {}

    def stand_in(self, obj: Any, is_copy: bool = False) -> Any:
        """Return an object without panes as it is, or else a copy whose panes let light pass.

        If `is_copy`, `obj` was made for this scene and has no modifiers. It is then changed itself.
        """
        panes = self._panes(obj, is_copy)
        if not panes:
            return obj
        copy = obj if is_copy else self._own(obj.copy())
        for number, pane in panes.items():
            slot = copy.material_slots[number]
            slot.link, slot.material = "OBJECT", self._material(*pane)
        return copy

    def is_pane(self, obj: Any) -> bool:
        """Return whether an object has panes of thin glass."""
        return bool(self._panes(obj, False))

    def _panes(self, obj: Any, is_copy: bool) -> dict[int, tuple[Glass, bool]]:
        """Return the panes of an object, as `panes_of` does.

        If `is_copy`, `obj` was made for this scene and has no modifiers.
        """
        if not any(slot.material and glass_of(slot.material) for slot in obj.material_slots):
            return {}
        return panes_of(obj if is_copy else obj.evaluated_get(self._depsgraph), self._metres)

    def _material(self, glass: Glass, is_sheet: bool) -> Any:
        key = glass, is_sheet
        if key not in self._made:
            nodes = Nodes(self._own)
            # The node inverts the index on back faces, as for rays from within the glass.
            back = nodes.add("ShaderNodeNewGeometry").outputs["Backfacing"]
            inverse = 1.0 / glass.ior - glass.ior
            index = nodes.add("ShaderNodeMath", "MULTIPLY_ADD", _0=back, _1=inverse, _2=glass.ior)
            share = nodes.add("ShaderNodeFresnel", _0=index.outputs[0]).outputs[0]
            if is_sheet:
                twice = nodes.add("ShaderNodeMath", "MULTIPLY", _0=share, _1=2.0)
                more = nodes.add("ShaderNodeMath", "ADD", _0=share, _1=1.0)
                both = nodes.add(
                    "ShaderNodeMath", "DIVIDE", _0=twice.outputs[0], _1=more.outputs[0]
                )
                share = both.outputs[0]
            through = nodes.add("ShaderNodeBsdfTransparent", color=(*glass.tint, 1.0))
            mirror = nodes.add("ShaderNodeBsdfGlossy", color=(1.0,) * 4, roughness=0.0)
            mixed = nodes.add(
                "ShaderNodeMixShader", _0=share, _1=through.outputs[0], _2=mirror.outputs[0]
            )
            nodes.add("ShaderNodeOutputMaterial", surface=mixed.outputs[0])
            self._made[key] = nodes.material
        return self._made[key]


def glass_of(material: Any) -> Glass | None:
    """Return the glass of a smooth and clear material; None for other or animated materials."""
    tree = material.node_tree
    if tree is None or material.animation_data or tree.animation_data:
        return None
    outputs = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL" and n.is_active_output]
    if len(outputs) != 1 or outputs[0].inputs["Volume"].links or not outputs[0].inputs[0].links:
        return None
    node = outputs[0].inputs[0].links[0].from_node
    if any(socket.is_linked for socket in node.inputs) or not _refracts(node):
        return None
    if node.type == "BSDF_PRINCIPLED":
        values = {socket.name: socket.default_value for socket in node.inputs}
        if values["Transmission Weight"] < 1.0 or values["Alpha"] < 1.0 or values["Metallic"] > 0.0:
            return None
        # Cycles takes half of the colour at each of the two faces.
        red, green, blue = (max(part, 0.0) ** 0.5 for part in values["Base Color"][:3])
        return Glass((red, green, blue), values["IOR"])
    red, green, blue = node.inputs["Color"].default_value[:3]
    return Glass((red, green, blue), node.inputs["IOR"].default_value)


def panes_of(evaluated: Any, metres: float) -> dict[int, tuple[Glass, bool]]:
    """Return the panes of an evaluated object, without glass that is thick or curved.

    Parameters
    ----------
    evaluated
        The evaluated object.
    metres
        The length of a Blender unit, in m.

    Returns
    -------
    dict
        By index of the material slot: the glass, and whether each pane is a single sheet of faces.
    """
    found: dict[int, tuple[Glass, bool]] = {}
    if evaluated.type != "MESH":
        return found
    for number, slot in enumerate(evaluated.material_slots):
        glass = slot.material and glass_of(slot.material.original)
        if glass:
            sheets = {_is_sheet(*part) for part in _parts(evaluated, number, metres)}
            if len(sheets) == 1 and None not in sheets:
                found[number] = glass, bool(sheets.pop())
    return found


def hides_lamps(material: Any) -> bool:
    """Return whether a material has smooth glass through which Cycles sends no shadow rays."""
    nodes = material.node_tree.nodes if material.node_tree else ()
    opens = any(node.type in {"BSDF_TRANSPARENT", "LIGHT_PATH"} for node in nodes)
    return not opens and any(_refracts(node) for node in nodes)


def opaque_glass(view_layer: Any) -> dict[str, str]:
    """Return the visible objects whose glass hides lamps from light sensors.

    The keys are names of objects, and the values names of the glass materials. Thin, flat, plain
    panes and objects no larger than a bottle are left out.
    """
    found = {}
    metres = unit_scale(view_layer.id_data)
    for obj, holder in with_instanced(view_layer):
        glass = [
            number
            for number, slot in enumerate(obj.material_slots)
            if slot.material is not None and hides_lamps(slot.material)
        ]
        if not glass or obj.angen_ignored or not holder.visible_get(view_layer=view_layer):
            continue
        evaluated = obj.evaluated_get(view_layer.depsgraph)
        if max(evaluated.dimensions) * metres < LARGE:
            continue
        panes = panes_of(evaluated, metres)
        for number in glass:
            if number not in panes:
                found[obj.name] = obj.material_slots[number].material.name
    return found


def _refracts(node: Any) -> bool:
    rough = node.inputs.get("Roughness")
    if rough is None or rough.is_linked or rough.default_value > SMOOTH:
        return False
    if node.type == "BSDF_PRINCIPLED":
        through = node.inputs["Transmission Weight"]
        return bool(through.is_linked or through.default_value > 0.0)
    return node.type in {"BSDF_GLASS", "BSDF_REFRACTION"}


def _parts(evaluated: Any, slot: int, metres: float) -> list[tuple[Array, Array]]:
    """Return the connected parts of the faces with a material slot.

    Each part has the corners (n, 3, 3) of its triangles in m, and their area vectors (n, 3) in m².
    """
    mesh = evaluated.data
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    corners, of = np.empty(count * 3, np.int32), np.empty(count, np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    mesh.loop_triangles.foreach_get("material_index", of)
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    matrix = np.array(evaluated.matrix_world, np.float64)[:3, :3] * metres
    places = points.reshape(-1, 3) @ matrix.T
    triangles = corners.reshape(-1, 3)[of == slot]
    if not len(triangles):
        return []
    # Imported files may have separate faces: corners at the same place count as one.
    _, same = np.unique(np.round(places, 5), axis=0, return_inverse=True)
    labels = _connected(same.ravel()[triangles], len(places))
    corners_at = places[triangles]
    edges = corners_at[:, 1:] - corners_at[:, :1]
    areas = np.cross(edges[:, 0], edges[:, 1]) / 2.0
    return [(corners_at[labels == label], areas[labels == label]) for label in np.unique(labels)]


def _connected(triangles: Any, count: int) -> Any:
    """Return a label (n,) for each triangle (n, 3), equal for triangles that are connected."""
    labels = np.arange(count)
    while True:
        lowest = labels[triangles].min(axis=1)
        before = labels.copy()
        np.minimum.at(labels, triangles.ravel(), np.repeat(lowest, 3))
        labels = labels[labels]
        if np.array_equal(before, labels):
            return labels[triangles[:, 0]]


def _is_sheet(corners: Array, areas: Array) -> bool | None:
    """Return True for a single flat sheet of glass, and False for a thin, flat, closed pane.

    Return None for any other shape. The parameters are a part as `_parts` returns it.
    """
    sizes = np.linalg.norm(areas, axis=1)
    whole = sizes.sum()
    _, axes = np.linalg.eigh((areas / np.maximum(sizes, 1e-300)[:, None]).T @ areas)
    normal = axes[:, -1]
    flat = sizes[np.abs(areas @ normal) >= ALIGNED * sizes].sum() >= FLAT * whole
    if not flat or np.ptp(corners.reshape(-1, 3) @ normal) > THIN:
        return None
    open_area = float(np.linalg.norm(areas.sum(axis=0)))
    if open_area <= 1e-3 * whole:
        return False
    return True if open_area >= FLAT * whole else None
