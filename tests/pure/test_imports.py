# SPDX-License-Identifier: GPL-3.0-or-later
"""sensor_logic works where there is no Blender, and knows nothing of what is built on it."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import importlib, pkgutil, sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"bpy", "bmesh", "mathutils", "bpy_extras", "gpu", "bl_ext",
                                      "angen_addon", "operators", "panels", "studies"}:
            raise ImportError(f"{name} is blocked")
sys.meta_path.insert(0, Blocked())
import sensor_logic
for module in pkgutil.walk_packages(sensor_logic.__path__, "sensor_logic."):
    importlib.import_module(module.name)
    print(module.name)
"""


def test_sensor_logic_imports_without_blender():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in (ROOT / "sensor_logic").rglob("*.py")
    }
    assert set(done.stdout.split()) == {
        name.removesuffix(".__init__") for name in found - {"sensor_logic.__init__"}
    }
