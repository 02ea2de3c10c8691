# SPDX-License-Identifier: GPL-3.0-or-later
"""An IFC building at map coordinates becomes an OBJ file near the origin, without loss."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
FLAT = ROOT / "docs" / "tutorials" / "flat.ifc"
SCRIPT = ROOT / "scripts" / "foreign_homes" / "ifc_to_obj.py"


def moved(offset):
    """Return the text of the flat's IFC file with all parts moved by an offset (3) in m."""
    text = FLAT.read_text(encoding="utf-8")
    places = re.findall(r"IFCLOCALPLACEMENT\(\$,(#\d+)\)", text)
    axes = dict(re.findall(r"(#\d+)=IFCAXIS2PLACEMENT3D\((#\d+)", text))
    points = {axes[place] for place in places}

    def move(found):
        if found[1] not in points:
            return found[0]
        at = (float(part) + o for part, o in zip(found[2].split(","), offset, strict=True))
        return f"{found[1]}=IFCCARTESIANPOINT(({','.join(map(str, at))}))"

    return re.sub(r"(#\d+)=IFCCARTESIANPOINT\(\(([^)]*)\)\)", move, text)


def converted(source, target):
    """Convert an IFC file; return what was printed, and the points (n, 3) of each object."""
    command = [sys.executable, SCRIPT, source, target]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    objects = re.split(r"^o ", target.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return said, [
        np.array([line.split()[1:] for line in o.splitlines() if line[:2] == "v "], float)
        for o in objects
    ]


@pytest.mark.parametrize(
    ("offset", "out"),
    [
        ((450000.25, 5428000.125, 0.0), (True, True, False)),
        ((-3000.5, 12.0, 1500.0), (True, False, True)),
        ((300.0, 20.0, 400.0), (False, False, False)),
    ],
)
def test_the_offset_is_taken_out_and_told(reader, tmp_path, offset, out):
    reader("ifcopenshell")
    far = tmp_path / "far.ifc"
    far.write_text(moved(offset), encoding="utf-8")
    _, near = converted(FLAT, tmp_path / "near.obj")
    said, found = converted(far, tmp_path / "far.obj")
    told = re.search(r"moved to the origin: x (\S+), y (\S+), z (\S+) m", said)
    taken = np.array([float(part) for part in told.groups()]) if told else np.zeros(3)
    assert tuple(taken != 0.0) == out
    assert len(found) == len(near) == 15
    for one, other in zip(found, near, strict=True):
        assert one == pytest.approx(other + offset + taken, abs=1e-4)
        assert np.abs(one[:, np.array(out)]).max(initial=0.0) < 10.0
