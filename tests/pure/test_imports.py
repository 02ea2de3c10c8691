# SPDX-License-Identifier: GPL-3.0-or-later
"""Pure packages work without Blender; sensor_logic imports nothing that builds on it.

Logs work without models.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import importlib, pkgutil, sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"bpy", "bmesh", "mathutils", "bpy_extras", "gpu", "bl_ext",
                                      "angen_addon", "operators", "panels", "residents", "studies"}:
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


# `sensor_logic` itself loads the kinds, so a bare package stands for it.
LOGS = """
import importlib, sys, types
from pathlib import Path
bare = sys.modules["sensor_logic"] = types.ModuleType("sensor_logic")
bare.__path__ = ["sensor_logic"]
class Blocked:
    def find_spec(self, name, path=None, target=None):
        house, _, part = name.partition(".")
        is_model = house == "sensor_logic" and part.partition(".")[0] != "logs"
        if is_model or house in sys.argv[1:]:
            raise ImportError(f"{name} is blocked")
sys.meta_path.insert(0, Blocked())
for path in sorted(Path("sensor_logic/logs").rglob("*.py")):
    name = ".".join(path.with_suffix("").parts).removesuffix(".__init__")
    try:
        importlib.import_module(name)
        print("loaded", name)
    except ImportError as error:
        print(name, error)
"""


def logs_without(*packages: str) -> list[str]:
    """Return the modules of the logs that do not load without models and these packages."""
    command = [sys.executable, "-c", LOGS, "bpy", "mathutils", "angen_addon", *packages]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == len(list((ROOT / "sensor_logic/logs").rglob("*.py")))
    return [line for line in lines if not line.startswith("loaded ")]


def test_logs_import_without_models():
    assert logs_without() == []


def test_only_comparison_and_faults_need_numpy_in_the_logs():
    names = {line.partition(" ")[0].split(".")[2] for line in logs_without("numpy")}
    assert names == {"comparison", "faults"}


RESIDENTS = """
import importlib, pkgutil, sys
from angen_addon.process.standalone import load_extension
load_extension()
for name in ("bpy", "bmesh", "mathutils", "gpu"):
    sys.modules[name] = None
for folder in sys.argv[1:]:
    package = importlib.import_module(f"angen_sensors.residents.{folder}")
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        importlib.import_module(module.name)
        print(module.name)
"""


def test_bodies_acting_routines_and_days_import_without_blender():
    folders = ("body", "acting", "routine", "days")
    command = [sys.executable, "-c", RESIDENTS, *folders]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    files = [path for name in folders for path in (ROOT / "residents" / name).glob("*.py")]
    assert len(done.stdout.split()) == len(files) - len(folders)
