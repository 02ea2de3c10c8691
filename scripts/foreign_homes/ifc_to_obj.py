# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert an IFC building to an OBJ file in metres, Z up, with an object for each part.

python -m venv ifc && ifc/bin/pip install ifcopenshell
ifc/bin/python scripts/foreign_homes/ifc_to_obj.py HOME.ifc HOME.obj

An object is called after its class, its name and its number, such as `Door Front door 4711`. The
volumes of rooms (IfcSpace) and openings are left out, because sensors would take them for solid.
"""

import sys
from multiprocessing import cpu_count
from pathlib import Path

try:
    import ifcopenshell
    import ifcopenshell.geom
except ModuleNotFoundError as error:
    sys.exit(f"ifc_to_obj: {error}: run `pip install ifcopenshell`")

LEFT_OUT = ("IfcSpace", "IfcOpeningElement", "IfcVirtualElement", "IfcAnnotation", "IfcGrid")


class NotIfc(Exception):
    """The file is no IFC file."""


def convert(source: Path, target: Path) -> int:
    """Write the OBJ file; return the number of objects.

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
    parts = ifcopenshell.geom.iterator(settings, model, cpu_count(), exclude=left_out or None)
    count, vertices = 0, 1
    with target.open("w", encoding="utf-8") as out:
        going = parts.initialize()
        while going:
            shape = parts.get()
            points, faces = shape.geometry.verts, shape.geometry.faces
            name = f"{shape.type.removeprefix('Ifc')} {shape.name} {shape.id}"
            out.write(f"o {name.replace(chr(10), ' ')}\n")
            for i in range(0, len(points), 3):
                out.write("v {:.5f} {:.5f} {:.5f}\n".format(*points[i : i + 3]))
            for i in range(0, len(faces), 3):
                out.write("f {} {} {}\n".format(*(vertices + face for face in faces[i : i + 3])))
            vertices += len(points) // 3
            count += 1
            going = parts.next()
    return count


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
        written = convert(Path(sys.argv[1]), Path(sys.argv[2]))
    except OSError as error:
        sys.exit(f"ifc_to_obj: {error.filename or sys.argv[1]}: {error.strerror or error}")
    except NotIfc as error:
        sys.exit(f"ifc_to_obj: {error}")
    if not written:
        sys.exit(f"ifc_to_obj: {sys.argv[1]} has no part with a shape")
    print(f"{written} objects in {sys.argv[2]}")
