# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the home, procedural, without image files; `get` makes each at its first use."""

from collections.abc import Callable

import bpy

Colour = tuple[float, float, float]


class Nodes:
    """A material's node tree, with short methods to add and link nodes."""

    def __init__(self, name: str, colour: Colour) -> None:
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        # The colour of the solid view is lighter: its lamps leave walls seen from above in the
        # dark.
        self.material.diffuse_color = (*(c**0.6 for c in colour), 1.0)
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.output = self.tree.nodes.new("ShaderNodeOutputMaterial")

    def add(self, kind: str, inputs: dict | None = None, **settings: object) -> bpy.types.Node:
        """Return a new node of type ShaderNode`kind`; an input is a value or a node's output."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for key, value in settings.items():
            setattr(node, key, value)
        for key, value in (inputs or {}).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[key])
            else:
                node.inputs[key].default_value = value
        return node

    def math(self, operation: str, a: object, b: object = 0.0) -> bpy.types.NodeSocket:
        """Return the output of a math node."""
        return self.add("Math", {0: a, 1: b}, operation=operation).outputs[0]

    def principled(self, inputs: dict) -> bpy.types.Material:
        """Finish the material with a Principled BSDF."""
        shader = self.add("BsdfPrincipled", inputs)
        return self.finish(shader.outputs[0])

    def finish(self, shader: bpy.types.NodeSocket) -> bpy.types.Material:
        """Finish the material with any shader."""
        self.tree.links.new(shader, self.output.inputs["Surface"])
        return self.material

    def ramp(self, fac: bpy.types.NodeSocket, low: Colour, high: Colour) -> bpy.types.NodeSocket:
        """Return a colour between two by a factor."""
        node = self.add("ValToRGB", {0: fac})
        node.color_ramp.elements[0].color = (*low, 1.0)
        node.color_ramp.elements[1].color = (*high, 1.0)
        return node.outputs[0]

    def bump(self, height: bpy.types.NodeSocket, depth: float) -> bpy.types.NodeSocket:
        """Return a bump of `depth` metres."""
        return self.add("Bump", {"Height": height, "Distance": depth, "Strength": 0.6}).outputs[0]


def _rgba(colour: Colour) -> tuple[float, float, float, float]:
    return (*colour, 1.0)


def plain(name: str, colour: Colour, roughness: float = 0.5, **inputs: float) -> bpy.types.Material:
    """Return one colour; further inputs of the Principled BSDF have `_` for blanks."""
    more = {key.replace("_", " "): value for key, value in inputs.items()}
    return Nodes(name, colour).principled(
        {"Base Color": _rgba(colour), "Roughness": roughness, **more}
    )


def paint(name: str, colour: Colour) -> bpy.types.Material:
    """Return wall paint with a faint roller texture."""
    n = Nodes(name, colour)
    noise = n.add("TexNoise", {"Vector": n.add("NewGeometry").outputs["Position"], "Scale": 140.0})
    return n.principled(
        {
            "Base Color": _rgba(colour),
            "Roughness": 0.85,
            "Normal": n.bump(noise.outputs[0], 0.0006),
        }
    )


def wood(name: str, low: Colour, high: Colour, axis: int) -> bpy.types.Material:
    """Return wood with its grain along a local axis."""
    n = Nodes(name, high)
    stretch = [22.0, 22.0, 22.0]
    stretch[axis] = 1.4
    mapping = n.add("Mapping", {0: n.add("TexCoord").outputs["Object"], "Scale": stretch})
    noise = n.add(
        "TexNoise",
        {"Vector": mapping.outputs[0], "Scale": 1.3, "Detail": 5.0, "Distortion": 0.6},
    )
    wide = n.add("MapRange", {0: noise.outputs[0], 1: 0.3, 2: 0.72})
    return n.principled(
        {
            "Base Color": n.ramp(wide.outputs[0], low, high),
            "Roughness": 0.42,
            "Normal": n.bump(noise.outputs[0], 0.0008),
        }
    )


def planks(name: str, low: Colour, high: Colour) -> bpy.types.Material:
    """Return a floor of boards along x, placed by world position so that rooms join."""
    n = Nodes(name, high)
    position = n.add("NewGeometry").outputs["Position"]
    boards = n.add(
        "TexBrick",
        {"Vector": position, "Color1": (0, 0, 0, 1), "Color2": (1, 1, 1, 1), "Scale": 1.0,
         "Mortar": (0, 0, 0, 1), "Mortar Size": 0.0016, "Brick Width": 1.35, "Row Height": 0.145},
        offset=0.37,
    )  # fmt: skip
    mapping = n.add("Mapping", {0: position, "Scale": (1.6, 24.0, 1.0)})
    grain = n.add("TexNoise", {"Vector": mapping.outputs[0], "Scale": 1.5, "Detail": 6.0})
    tone = n.math("ADD", n.math("MULTIPLY", boards.outputs[0], 0.45),
                  n.math("MULTIPLY", grain.outputs[0], 0.65))  # fmt: skip
    seam = n.math("SUBTRACT", 1.0, n.math("MULTIPLY", boards.outputs[1], 0.65))
    colour = n.add("Mix", {0: 1.0, 6: n.ramp(tone, low, high), 7: (1, 1, 1, 1)},
                   data_type="RGBA", blend_type="MULTIPLY")  # fmt: skip
    n.tree.links.new(seam, colour.inputs[7])
    return n.principled(
        {
            "Base Color": colour.outputs[2],
            "Roughness": 0.34,
            "Normal": n.bump(seam, 0.001),
        }
    )


def fabric(name: str, colour: Colour, scale: float = 260.0) -> bpy.types.Material:
    """Return woven cloth."""
    n = Nodes(name, colour)
    coordinate = n.add("TexCoord").outputs["Object"]
    noise = n.add("TexNoise", {"Vector": coordinate, "Scale": scale, "Detail": 2.0})
    cloud = n.add("TexNoise", {"Vector": coordinate, "Scale": 7.0})
    dark: Colour = (colour[0] * 0.72, colour[1] * 0.72, colour[2] * 0.72)
    tone = n.math("ADD", n.math("MULTIPLY", noise.outputs[0], 0.6),
                  n.math("MULTIPLY", cloud.outputs[0], 0.4))  # fmt: skip
    return n.principled(
        {
            "Base Color": n.ramp(tone, dark, colour),
            "Roughness": 0.95,
            "Sheen Weight": 0.25,
            "Normal": n.bump(noise.outputs[0], 0.002),
        }
    )


def stripes(name: str, one: Colour, two: Colour, width: float, axis: int) -> bpy.types.Material:
    """Return cloth with stripes across a local axis."""
    n = Nodes(name, one)
    split = n.add("SeparateXYZ", {0: n.add("TexCoord").outputs["Object"]})
    phase = n.math("FRACT", n.math("DIVIDE", split.outputs[axis], width))
    return n.principled(
        {
            "Base Color": n.ramp(n.math("GREATER_THAN", phase, 0.62), one, two),
            "Roughness": 0.95,
            "Sheen Weight": 0.2,
        }
    )


def tiles(
    name: str, colour: Colour, size: tuple[float, float], grout: Colour
) -> bpy.types.Material:
    """Return glazed tiles of width and height, m, on any wall or floor, by world position."""
    n = Nodes(name, colour)
    geometry = n.add("NewGeometry")
    position = n.add("SeparateXYZ", {0: geometry.outputs["Position"]})
    normal = n.add("SeparateXYZ", {0: geometry.outputs["Normal"]})
    line: bpy.types.NodeSocket | None = None
    for axis, length in enumerate((size[0], size[0], size[1])):
        at = n.math("FRACT", n.math("DIVIDE", n.math("ADD", position.outputs[axis], 9.013), length))
        near = n.math("LESS_THAN", at, 0.004 / length)
        # Joints run on faces whose normal does not point along the axis that the joints are counted
        # on.
        lies = n.math("LESS_THAN", n.math("ABSOLUTE", normal.outputs[axis]), 0.5)
        joint = n.math("MULTIPLY", near, lies)
        line = joint if line is None else n.math("MAXIMUM", line, joint)
    assert line is not None
    return n.principled(
        {
            "Base Color": n.ramp(line, colour, grout),
            "Roughness": n.math("ADD", n.math("MULTIPLY", line, 0.6), 0.16),
            "Normal": n.bump(n.math("SUBTRACT", 1.0, line), 0.0015),
        }
    )


def speckled(name: str, colour: Colour, dots: Colour, scale: float) -> bpy.types.Material:
    """Return stone, concrete, plaster or soil: one colour with grains of another."""
    n = Nodes(name, colour)
    position = n.add("NewGeometry").outputs["Position"]
    noise = n.add("TexNoise", {"Vector": position, "Scale": scale, "Detail": 6.0})
    wide = n.add("MapRange", {0: noise.outputs[0], 1: 0.35, 2: 0.7})
    return n.principled(
        {
            "Base Color": n.ramp(wide.outputs[0], colour, dots),
            "Roughness": 0.9,
            "Specular IOR Level": 0.15,
            "Normal": n.bump(noise.outputs[0], 0.002),
        }
    )


def glass(name: str, tint: Colour) -> bpy.types.Material:
    """Return clear panes that light passes straight: sun and sky reach rooms without noise.

    Only camera rays see sharp reflections. A path from a wall that meets a small lamp in a pane is
    rare, and each would add as much as ten thousand others.
    """
    n = Nodes(name, (0.75, 0.85, 0.9))
    n.material.diffuse_color = (0.75, 0.85, 0.9, 0.25)
    # Inside a pane, Fresnel would reflect slanting rays totally, because they did not bend on
    # entering.
    front = n.math("SUBTRACT", 1.0, n.add("NewGeometry").outputs["Backfacing"])
    fresnel = n.math("MULTIPLY", n.add("Fresnel", {0: 1.45}).outputs[0], front)
    clear = n.add("BsdfTransparent", {0: _rgba(tint)})
    seen = n.add("LightPath").outputs["Is Camera Ray"]
    rough = n.add("MapRange", {0: seen, 3: 0.4, 4: 0.02}).outputs[0]
    gloss = n.add("BsdfGlossy", {"Roughness": rough})
    return n.finish(
        n.add("MixShader", {0: fresnel, 1: clear.outputs[0], 2: gloss.outputs[0]})
        .outputs[0]
    )  # fmt: skip


def glowing(name: str, colour: Colour, strength: float) -> bpy.types.Material:
    """Return a lit screen or signal lamp."""
    return Nodes(name, colour).principled(
        {
            "Base Color": _rgba(colour),
            "Roughness": 0.4,
            "Emission Color": _rgba(colour),
            "Emission Strength": strength,
        }
    )


def translucent(name: str, colour: Colour) -> bpy.types.Material:
    """Return the shade of a lamp, visible to camera rays only; light passes through it.

    Light paths would find a lamp in a scattering shade by chance only: readings of light sensors
    would spread by tens of per cent instead of a few.
    """
    n = Nodes(name, colour)
    diffuse = n.add("BsdfDiffuse", {0: _rgba(colour)})
    back = n.add("BsdfTranslucent", {0: _rgba(colour)})
    body = n.add("MixShader", {0: 0.5, 1: diffuse.outputs[0], 2: back.outputs[0]})
    clear = n.add("BsdfTransparent")
    seen = n.add("LightPath").outputs["Is Camera Ray"]
    mix = n.add("MixShader", {0: seen, 1: clear.outputs[0], 2: body.outputs[0]})
    return n.finish(mix.outputs[0])


def mirroring(name: str, colour: Colour, roughness: float) -> bpy.types.Material:
    """Return a mirror for camera rays only; it scatters other rays, and reflects as much light.

    The light of a small lamp that a mirror or tap reflects into a room is about a tenth of all
    light there. Light paths would find it by chance, and then all of it at once.
    """
    n = Nodes(name, colour)
    scattered = n.add("BsdfDiffuse", {0: _rgba(colour)})
    mirrored = n.add("BsdfGlossy", {0: _rgba(colour), "Roughness": roughness})
    seen = n.add("LightPath").outputs["Is Camera Ray"]
    mix = n.add("MixShader", {0: seen, 1: scattered.outputs[0], 2: mirrored.outputs[0]})
    return n.finish(mix.outputs[0])


def ceiling(name: str) -> bpy.types.Material:
    """Return a white ceiling that cameras above do not see, so that they look into the home.

    Light meets the ceiling as always.
    """
    n = Nodes(name, (0.85, 0.85, 0.84))
    n.material.use_backface_culling = True
    above = n.math("MULTIPLY", n.add("NewGeometry").outputs["Backfacing"],
                   n.add("LightPath").outputs["Is Camera Ray"])  # fmt: skip
    white = n.add("BsdfDiffuse", {0: (0.86, 0.86, 0.85, 1)})
    clear = n.add("BsdfTransparent")
    return n.finish(
        n.add("MixShader", {0: above, 1: white.outputs[0], 2: clear.outputs[0]}).outputs[0]
    )


def art(name: str, low: Colour, high: Colour, scale: float) -> bpy.types.Material:
    """Return an abstract print."""
    n = Nodes(name, high)
    warp = n.add(
        "TexNoise",
        {"Vector": n.add("TexCoord").outputs["Object"], "Scale": scale, "Detail": 1.5,
         "Distortion": 1.6},
    )  # fmt: skip
    node = n.add("ValToRGB", {0: warp.outputs[0]})
    node.color_ramp.interpolation = "CONSTANT"
    stops = node.color_ramp.elements
    stops[0].color, stops[1].color = _rgba(low), _rgba(high)
    stops[1].position = 0.6
    for at, colour in ((0.42, (0.86, 0.82, 0.74)), (0.52, (0.8, 0.45, 0.25))):
        stops.new(at).color = _rgba(colour)
    return n.principled({"Base Color": node.outputs[0], "Roughness": 0.7})


_OAK: tuple[Colour, Colour] = ((0.36, 0.21, 0.1), (0.56, 0.37, 0.2))
_PINE: tuple[Colour, Colour] = ((0.6, 0.43, 0.25), (0.72, 0.56, 0.37))
_WALNUT: tuple[Colour, Colour] = ((0.1, 0.05, 0.027), (0.22, 0.12, 0.065))

_MAKERS: dict[str, Callable[[str], bpy.types.Material]] = {
    # surfaces of the building
    "paint white": lambda n: paint(n, (0.78, 0.77, 0.74)),
    "paint warm": lambda n: paint(n, (0.78, 0.75, 0.69)),
    "paint sage": lambda n: paint(n, (0.44, 0.5, 0.42)),
    "paint blue": lambda n: paint(n, (0.38, 0.48, 0.56)),
    "paint sand": lambda n: paint(n, (0.68, 0.58, 0.45)),
    "wall cut": lambda n: plain(n, (0.02, 0.019, 0.018), 1.0, Specular_IOR_Level=0.05),
    "facade": lambda n: speckled(n, (0.27, 0.22, 0.18), (0.22, 0.18, 0.15), 30.0),
    "ceiling": ceiling,
    "oak floor": lambda n: planks(n, (0.25, 0.14, 0.07), (0.56, 0.38, 0.21)),
    "deck": lambda n: planks(n, (0.2, 0.15, 0.11), (0.4, 0.32, 0.25)),
    "tiles white": lambda n: tiles(n, (0.8, 0.82, 0.82), (0.3, 0.2), (0.5, 0.52, 0.53)),
    "tiles grey": lambda n: tiles(n, (0.34, 0.38, 0.4), (0.3, 0.3), (0.2, 0.22, 0.23)),
    "tiles kitchen": lambda n: tiles(n, (0.62, 0.6, 0.55), (0.4, 0.4), (0.38, 0.36, 0.33)),
    "tiles splash": lambda n: tiles(n, (0.5, 0.62, 0.6), (0.15, 0.075), (0.8, 0.8, 0.78)),
    "concrete": lambda n: speckled(n, (0.42, 0.42, 0.41), (0.52, 0.51, 0.5), 9.0),
    "ground": lambda n: speckled(n, (0.035, 0.06, 0.016), (0.062, 0.085, 0.022), 1.2),
    "white paint": lambda n: plain(n, (0.8, 0.8, 0.78), 0.35),
    "glass": lambda n: glass(n, (0.94, 0.97, 0.97)),
    "frosted glass": lambda n: plain(n, (0.8, 0.9, 0.9), 0.35, Transmission_Weight=0.7, Alpha=0.75),
    # wood; the name ends with the axis of the grain where it is not x
    "oak": lambda n: wood(n, *_OAK, 0),
    "oak y": lambda n: wood(n, *_OAK, 1),
    "oak z": lambda n: wood(n, *_OAK, 2),
    "pine": lambda n: wood(n, *_PINE, 0),
    "pine y": lambda n: wood(n, *_PINE, 1),
    "pine z": lambda n: wood(n, *_PINE, 2),
    "walnut": lambda n: wood(n, *_WALNUT, 0),
    "walnut z": lambda n: wood(n, *_WALNUT, 2),
    # cloth
    "fabric grey blue": lambda n: fabric(n, (0.19, 0.27, 0.35)),
    "fabric grey": lambda n: fabric(n, (0.42, 0.42, 0.42)),
    "fabric dark": lambda n: fabric(n, (0.07, 0.075, 0.085)),
    "fabric mustard": lambda n: fabric(n, (0.68, 0.4, 0.07)),
    "fabric rust": lambda n: fabric(n, (0.5, 0.16, 0.07)),
    "fabric cream": lambda n: fabric(n, (0.74, 0.68, 0.57)),
    "fabric green": lambda n: fabric(n, (0.13, 0.26, 0.17)),
    "fabric coat": lambda n: fabric(n, (0.09, 0.13, 0.26)),
    "linen": lambda n: fabric(n, (0.78, 0.77, 0.73), 180.0),
    "duvet": lambda n: stripes(n, (0.5, 0.6, 0.68), (0.8, 0.8, 0.77), 0.11, 0),
    "towel": lambda n: fabric(n, (0.2, 0.42, 0.44), 120.0),
    "rug": lambda n: stripes(n, (0.6, 0.53, 0.42), (0.36, 0.18, 0.12), 0.24, 0),
    "runner": lambda n: stripes(n, (0.17, 0.21, 0.26), (0.5, 0.47, 0.4), 0.5, 1),
    "mat": lambda n: fabric(n, (0.16, 0.12, 0.08), 90.0),
    "wicker": lambda n: stripes(n, (0.55, 0.38, 0.2), (0.34, 0.21, 0.1), 0.02, 2),
    # things
    "chrome": lambda n: mirroring(n, (0.75, 0.76, 0.78), 0.14),
    "steel": lambda n: plain(n, (0.5, 0.51, 0.52), 0.32, Metallic=1.0),
    "brass": lambda n: plain(n, (0.66, 0.46, 0.19), 0.28, Metallic=1.0),
    "black metal": lambda n: plain(n, (0.03, 0.03, 0.032), 0.4, Metallic=0.6),
    "black plastic": lambda n: plain(n, (0.02, 0.02, 0.022), 0.4),
    "grey plastic": lambda n: plain(n, (0.25, 0.26, 0.27), 0.5),
    "white plastic": lambda n: plain(n, (0.82, 0.82, 0.8), 0.3),
    "ceramic": lambda n: plain(n, (0.84, 0.84, 0.82), 0.1, Coat_Weight=0.5),
    "blue ceramic": lambda n: plain(n, (0.08, 0.18, 0.32), 0.15, Coat_Weight=0.5),
    "terracotta": lambda n: plain(n, (0.5, 0.2, 0.1), 0.8),
    "soil": lambda n: speckled(n, (0.04, 0.025, 0.015), (0.09, 0.06, 0.04), 60.0),
    "leaf": lambda n: plain(n, (0.07, 0.2, 0.055), 0.45),
    "hedge": lambda n: speckled(n, (0.035, 0.09, 0.03), (0.09, 0.17, 0.05), 3.0),
    "leaf light": lambda n: plain(n, (0.19, 0.33, 0.08), 0.5),
    "flower": lambda n: plain(n, (0.7, 0.12, 0.16), 0.6),
    "mirror": lambda n: mirroring(n, (0.9, 0.92, 0.92), 0.02),
    "black glass": lambda n: plain(n, (0.008, 0.008, 0.01), 0.06, Coat_Weight=1.0),
    "screen": lambda n: glowing(n, (0.12, 0.3, 0.5), 1.2),
    "television": lambda n: plain(n, (0.008, 0.009, 0.012), 0.12),
    "worktop": lambda n: speckled(n, (0.13, 0.12, 0.115), (0.2, 0.19, 0.18), 70.0),
    "kitchen front": lambda n: plain(n, (0.36, 0.45, 0.42), 0.4),
    "lacquer": lambda n: plain(n, (0.76, 0.75, 0.72), 0.28),
    "shade": lambda n: translucent(n, (0.86, 0.78, 0.66)),
    "lamp glass": lambda n: translucent(n, (0.92, 0.9, 0.86)),
    "paper": lambda n: plain(n, (0.8, 0.78, 0.72), 0.8),
    "print a": lambda n: art(n, (0.05, 0.14, 0.2), (0.16, 0.35, 0.36), 3.2),
    "print b": lambda n: art(n, (0.3, 0.08, 0.05), (0.72, 0.55, 0.2), 4.5),
    "print c": lambda n: art(n, (0.1, 0.16, 0.08), (0.4, 0.5, 0.3), 2.6),
    "red": lambda n: plain(n, (0.55, 0.05, 0.04), 0.4),
    "orange": lambda n: plain(n, (0.8, 0.28, 0.03), 0.5),
    "yellow": lambda n: plain(n, (0.8, 0.58, 0.08), 0.5),
    "green": lambda n: plain(n, (0.1, 0.35, 0.15), 0.5),
    "blue": lambda n: plain(n, (0.06, 0.15, 0.42), 0.5),
    "milk": lambda n: plain(n, (0.8, 0.8, 0.78), 0.5),
    # sensors
    "sensor body": lambda n: plain(n, (0.85, 0.85, 0.83), 0.4),
    "sensor lens": lambda n: plain(n, (0.9, 0.9, 0.9), 0.25, Subsurface_Weight=0.3),
    "sensor dark": lambda n: plain(n, (0.03, 0.032, 0.035), 0.45),
    "sensor green": lambda n: glowing(n, (0.1, 0.9, 0.2), 1.5),
    "sensor flag": lambda n: plain(n, (0.85, 0.16, 0.04), 0.5),
}


def get(name: str) -> bpy.types.Material:
    """Return the material of a name in the table above."""
    return bpy.data.materials.get(name) or _MAKERS[name](name)
