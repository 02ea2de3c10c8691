# SPDX-License-Identifier: GPL-3.0-or-later
"""What a new sensor looks like: the part in its real size, and lines that show where it looks.

Everything is in metres in the sensor's own axes: it looks along −Z with +Y up from the origin, its
housing behind that; a switch's beam leaves the origin along −Z, its fork is open towards −Y and
stands on its +Y side; a pad lies on z = 0 and is pressed on from +Z. The lines are edges without
faces: no ray meets them and no render shows them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import bpy
from mathutils import Matrix, Vector

Point = tuple[float, float, float]
# Corners at −x and +x, −y and +y, −z and +z; faces that look outwards.
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SEGMENTS = 16

# In units of its length: a pyramid that opens along −Z with a triangle on its +Y side, as cameras
# and lights have.
VIEW_LENGTH = 0.2
VIEW_POINTS: tuple[Point, ...] = (
    (0, 0, 0),
    (-0.5, -0.5, -1),
    (0.5, -0.5, -1),
    (0.5, 0.5, -1),
    (-0.5, 0.5, -1),
    (-0.3, 0.6, -1),
    (0.3, 0.6, -1),
    (0, 0.9, -1),
)
VIEW_EDGES = [
    (0, 1),
    (0, 2),
    (0, 3),
    (0, 4),
    (1, 2),
    (2, 3),
    (3, 4),
    (4, 1),
    (5, 6),
    (6, 7),
    (7, 5),
]


@dataclass
class Housing:
    """Points in metres, closed bodies of outward faces, and edges without faces."""

    points: list[Point] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)
    edges: list[tuple[int, int]] = field(default_factory=list)

    def box(self, low: Point, high: Point) -> Housing:
        corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1])
                   for z in (low[2], high[2])]  # fmt: skip
        return self._add(corners, BOX_FACES)

    def lathe(self, profile: Sequence[tuple[float, float]]) -> Housing:
        """A body turned about Z; `profile`: (radius, z) of its rings, from −z to +z. A radius of
        0 at an end is a point."""
        points: list[Point] = []
        rings: list[list[int]] = []
        for radius, z in profile:
            n = SEGMENTS if radius else 1
            rings.append(list(range(len(points), len(points) + n)))
            turns = (2 * math.pi * i / n for i in range(n))
            points += [(radius * math.cos(a), radius * math.sin(a), z) for a in turns]
        faces: list[tuple[int, ...]] = []
        for low, high in itertools.pairwise(rings):
            for i in range(SEGMENTS):
                j = (i + 1) % SEGMENTS
                ring = (
                    low[i % len(low)],
                    low[j % len(low)],
                    high[j % len(high)],
                    high[i % len(high)],
                )
                faces.append(tuple(dict.fromkeys(ring)))
        if len(rings[0]) > 1:
            faces.append(tuple(reversed(rings[0])))
        if len(rings[-1]) > 1:
            faces.append(tuple(rings[-1]))
        return self._add(points, faces)

    def lines(self, points: Iterable[Point], edges: Iterable[tuple[int, int]]) -> Housing:
        first = len(self.points)
        self.points += points
        self.edges += [(first + a, first + b) for a, b in edges]
        return self

    def _add(self, points: Sequence[Point], faces: Iterable[tuple[int, ...]]) -> Housing:
        first = len(self.points)
        self.points += points
        self.faces += [tuple(first + i for i in face) for face in faces]
        return self

    def outline(self) -> list[tuple[int, int]]:
        """All edges, those of the faces too, each once."""
        found = {tuple(sorted(e)) for e in self.edges}
        for face in self.faces:
            found |= {tuple(sorted(e)) for e in zip(face, face[1:] + face[:1], strict=True)}
        return sorted(found)  # type: ignore[arg-type]

    def reach(self, axes: Matrix, normal: Vector) -> float:
        """How far the body, turned by `axes` (3 × 3), reaches below its origin along `normal`
        (m)."""
        solid = {i for face in self.faces for i in face}
        return max((-normal.dot(axes @ Vector(self.points[i])) for i in solid), default=0.0)


def _looking(housing: Housing) -> Housing:
    return housing.lines([tuple(c * VIEW_LENGTH for c in p) for p in VIEW_POINTS], VIEW_EDGES)  # type: ignore[misc]


def _hc_sr501() -> Housing:
    """32 × 24 × 25 mm with a lens of 23 mm, as sold: innovatorsguru.com, purplebearsshopnearn.com.
    How the depth is shared between lens and board is not told."""
    lens = [(0.0115 * math.sin(a), 0.0115 * (1 - math.cos(a)))
            for a in (math.pi / 2 * i / 4 for i in range(5))]  # fmt: skip
    housing = Housing().lathe([*lens, (0.0115, 0.0165)])
    return _looking(housing.box((-0.016, -0.012, 0.0165), (0.016, 0.012, 0.025)))


def _pmod_pir() -> Housing:
    """Board of 1.2 × 0.8 inches, 0.55 inches high: Digilent Pmod PIR reference manual."""
    housing = Housing().lathe([(0.0, 0.0), (0.0035, 0.001), (0.0047, 0.004), (0.0047, 0.0124)])
    return _looking(housing.box((-0.01524, -0.01016, 0.0124), (0.01524, 0.01016, 0.01397)))


def _wall_detector() -> Housing:
    """For what hangs on a wall, as in the sample home: a flat body of 68 × 110 mm with a bulging
    lens, 40 mm deep."""
    lens = [(0.026 * math.sin(a), 0.014 * (1 - math.cos(a)))
            for a in (math.pi / 2 * i / 4 for i in range(5))]  # fmt: skip
    return _looking(Housing().lathe(lens).box((-0.034, -0.055, 0.014), (0.034, 0.055, 0.04)))


def _photoresistor() -> Housing:
    """GL55: a disk of 5 mm (ednieuw.home.xs4all.nl, GL55xx LDRs); its 2 mm are chosen."""
    return _looking(Housing().lathe([(0.0025, 0.0), (0.0025, 0.002)]))


def fork(gap: float, across: float, along: float, height: float) -> Housing:
    """Two arms beside a gap on a base: outer sizes along the beam, across it, and off the surface
    (m). The beam is a quarter of the height below the open end."""
    arm, x = (across - gap) / 2, along / 2
    tip, base = -height / 4, height * 3 / 4
    inner = base - height / 4
    housing = Housing()
    housing.box((-x, tip, 0.0), (x, inner, arm)).box((-x, tip, -gap - arm), (x, inner, -gap))
    housing.box((-x, inner, -gap - arm), (x, base, arm))
    return housing.lines([(0, 0, 0), (0, 0, -gap)], [(0, 1)])


def _pad(side: float, thickness: float) -> Housing:
    """A flat box whose origin is the middle of its underside."""
    return Housing().box((-side / 2, -side / 2, 0.0), (side / 2, side / 2, thickness))


def _force_resistor(diameter: float, length: float, side: float = 0.0) -> Housing:
    """A disk (or square) with its tail along −Y, 0.45 mm thin. The tail feels nothing, so it is
    lines without a surface; its width is chosen."""
    thin, half = 0.00045, (diameter or side) / 2
    housing = _pad(side, thin) if side else Housing().lathe([(half, 0.0), (half, thin)])
    end, w = half - length, min(half, 0.0032)
    tail: list[Point] = [(-w, -half, 0.0), (-w, end, 0.0), (w, end, 0.0), (w, -half, 0.0)]
    return housing.lines(tail, [(0, 1), (1, 2), (2, 3)])


def _fsr_402() -> Housing:
    return _force_resistor(0.01828, 0.056)


def _tcst() -> Housing:
    return fork(0.0031, 0.0119, 0.0063, 0.0108)


# By kind and preset; the empty preset is what a kind looks like otherwise. A pad is one as they
# are laid under furniture and on seats; a switch one about the flag of a door. Sizes: FSR 400
# series and FSR 402, 406 data sheets; Vishay 83764. Of other forks the gap is known, the rest is
# as Vishay's.
HOUSINGS: dict[tuple[str, str], Callable[[], Housing]] = {
    ("PIR", ""): _hc_sr501,
    ("PIR", "EKMC1601111"): _pmod_pir,
    ("PIR", "EKMC1601111_PYRO"): _pmod_pir,
    ("PIR", "HAA53"): _wall_detector,
    ("PIR", "EKMC1604111"): _wall_detector,
    ("PIR", "EKMC1604111_PYRO"): _wall_detector,
    ("PIR", "PET_IMMUNE_PYRO"): _wall_detector,
    ("PIR", "CURTAIN_PYRO"): _wall_detector,
    ("PIR", "SPACETI_WALL_PYRO"): _wall_detector,
    ("LIGHT", ""): _photoresistor,
    ("OPTICAL_SWITCH", ""): lambda: fork(0.05, 0.09, 0.024, 0.06),
    ("OPTICAL_SWITCH", "TCST1103"): _tcst,
    ("OPTICAL_SWITCH", "TCST1202"): _tcst,
    ("OPTICAL_SWITCH", "TCST1300"): _tcst,
    ("OPTICAL_SWITCH", "GP1A51HR"): lambda: fork(0.003, 0.0122, 0.0063, 0.01),
    ("OPTICAL_SWITCH", "GP1A53HR"): lambda: fork(0.005, 0.0137, 0.0063, 0.01),
    ("OPTICAL_SWITCH", "EE_SX670"): lambda: fork(0.005, 0.0138, 0.0063, 0.0108),
    ("PRESSURE", ""): lambda: _pad(0.3, 0.01),
    ("PRESSURE", "FSR_402_IDEAL"): _fsr_402,
    ("PRESSURE", "FSR_402"): _fsr_402,
    ("PRESSURE", "FSR_402_3K3"): _fsr_402,
    ("PRESSURE", "FSR_402_47K"): _fsr_402,
    ("PRESSURE", "FSR_402_100K"): _fsr_402,
    ("PRESSURE", "FSR_400"): lambda: _force_resistor(0.0051, 0.038),
    ("PRESSURE", "FSR_406"): lambda: _force_resistor(0.0, 0.083, side=0.04369),
}


def housing_of(kind: str, preset: str = "") -> Housing:
    """What a sensor of a kind set to a preset looks like."""
    return HOUSINGS.get((kind, preset), HOUSINGS[kind, ""])()


def mesh_of(housing: Housing, name: str, unit_scale: float) -> bpy.types.Mesh:
    """A new mesh of the real size, whatever the scene's units."""
    mesh = bpy.data.meshes.new(name)
    points = [tuple(c / unit_scale for c in point) for point in housing.points]
    mesh.from_pydata(points, housing.edges, housing.faces)
    return mesh
