# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert an IFC building to an OBJ file in metres, Z up, with an object for each part.

python -m venv ifc && ifc/bin/pip install ifcopenshell
ifc/bin/python scripts/foreign_homes/ifc_to_obj.py HOME.ifc HOME.obj

An object is called after its class, its name and its number, such as `Door Front door 4711`. The
volumes of rooms (IfcSpace) and openings are left out, because sensors would take them for solid.

A home at map coordinates is moved to the origin, by whole metres that are printed: so far out,
Blender's single precision has steps of centimetres.
"""

import sys
from collections.abc import Sequence
from multiprocessing import cpu_count
from pathlib import Path
from statistics import median
from typing import NamedTuple

try:
    import ifcopenshell
    import ifcopenshell.geom
except ModuleNotFoundError as error:
    sys.exit(f"ifc_to_obj: {error}: run `pip install ifcopenshell`")

LEFT_OUT = ("IfcSpace", "IfcOpeningElement", "IfcVirtualElement", "IfcAnnotation", "IfcGrid")
# m. A home that is farther from the origin along an axis is moved to the origin.
FAR = 1000.0


class Part(NamedTuple):
    """A part of the building.

    Attributes
    ----------
    number
        The number of the part in the IFC file.
    name
        The name of the object.
    points
        The coordinates x, y, z of each point in turn, in m.
    faces
        The three point indices of each triangle in turn.
    """

    number: int
    name: str
    points: Sequence[float]
    faces: Sequence[int]


class NotIfc(Exception):
    """The file is no IFC file."""


def convert(source: Path, target: Path) -> tuple[int, list[float]]:
    """Write the OBJ file; return the number of objects, and the offset (3) in m taken out.

    Raise `OSError` if a file cannot be read or written, and `NotIfc` if the source is not IFC.
    """
    with source.open("rb"):
        pass  # raises OSError; IfcOpenShell's errors do not say why
    try:
        model = ifcopenshell.open(str(source))
    except Exception as error:
        # IfcOpenShell has an error class of its own, and raises others too.
        why = " ".join(str(error).split())
        raise NotIfc(f"{source} cannot be read as IFC ({why})") from None
    settings = ifcopenshell.geom.settings()
    settings.set("use-world-coords", True)
    left_out = [part for name in LEFT_OUT for part in _of_class(model, name)]
    # An empty list would leave out everything.
    shapes = ifcopenshell.geom.iterator(settings, model, cpu_count(), exclude=left_out or None)
    parts = []
    going = shapes.initialize()
    while going:
        shape = shapes.get()
        name = f"{shape.type.removeprefix('Ifc')} {shape.name} {shape.id}"
        parts.append(Part(shape.id, name, shape.geometry.verts, shape.geometry.faces))
        going = shapes.next()
    # Several threads end in any order.
    parts.sort(key=lambda part: part.number)
    offset = offset_of([part.points for part in parts if part.points])
    vertices = 1
    with target.open("w", encoding="utf-8") as out:
        for part in parts:
            out.write(f"o {part.name.replace(chr(10), ' ')}\n")
            for i in range(0, len(part.points), 3):
                moved = (p - o for p, o in zip(part.points[i : i + 3], offset, strict=True))
                out.write("v {:.5f} {:.5f} {:.5f}\n".format(*moved))
            for i in range(0, len(part.faces), 3):
                corners = (vertices + face for face in part.faces[i : i + 3])
                out.write("f {} {} {}\n".format(*corners))
            vertices += len(part.points) // 3
    return len(parts), offset


def offset_of(parts: list[Sequence[float]]) -> list[float]:
    """Return the offset (3) in whole metres of a building from the origin; 0 along an axis if near.

    `parts` has the coordinates x, y, z of each part's points in turn. Half of the parts decide, so
    that one at another place does not count.
    """
    offset = []
    for axis in range(3):
        middles = [(min(points[axis::3]) + max(points[axis::3])) / 2.0 for points in parts]
        middle = median(middles) if middles else 0.0
        offset.append(float(round(middle)) if abs(middle) > FAR else 0.0)
    return offset


def _of_class(model: ifcopenshell.file, name: str) -> list[ifcopenshell.entity_instance]:
    """Return the parts of an IFC class."""
    try:
        return list(model.by_type(name))
    except RuntimeError:
        return []  # this version of the schema has no such class


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        written, offset = convert(Path(sys.argv[1]), Path(sys.argv[2]))
    except OSError as error:
        sys.exit(f"ifc_to_obj: {error.filename or sys.argv[1]}: {error.strerror or error}")
    except NotIfc as error:
        sys.exit(f"ifc_to_obj: {error}")
    if not written:
        sys.exit(f"ifc_to_obj: {sys.argv[1]} has no part with a shape")
    print(f"{written} objects in {sys.argv[2]}")
    if any(offset):
        print(
            "moved to the origin: x {:+.0f}, y {:+.0f}, z {:+.0f} m".format(
                *(0.0 - o for o in offset)
            )
        )
