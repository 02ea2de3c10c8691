# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures of all tests: Blender's folders in an empty place, and the extension enabled.

tests/pure needs Python and numpy, tests/blender Blender's Python module (bpy), tests/e2e a Blender
program. Tests without their program are skipped and say so; nothing here imports bpy for the
others.
"""

import contextlib
import functools
import importlib.util
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import imitated_windows
import pytest

from angen_addon.process.standalone import load_extension
from dev import link_folder

ROOT = Path(__file__).resolve().parent.parent
ADDON = "bl_ext.user_default.angen_sensors"
# The tests import the parts of the extension from one package, as they import each other.
load_extension()
HAS_BPY = importlib.util.find_spec("bpy") is not None


def pytest_configure(config: pytest.Config) -> None:
    """Give Blender empty folders, and all processes a temporary folder that is removed at the end.

    Blender reads BLENDER_USER_RESOURCES when bpy is imported. Processes that are killed leave their
    folders in TMPDIR, as do the workers of pytest-xdist, whose own folders lie in the first one's.
    """
    base = os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())
    resources = tempfile.mkdtemp(prefix="angen_tests_")
    config.add_cleanup(lambda: _remove(resources, base))
    temporary = Path(resources, "temporary")
    temporary.mkdir()
    # Threads of numpy's algebra that wait for each other keep the other workers' cores busy.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ["TMPDIR"] = tempfile.tempdir = str(temporary)
    extensions = Path(resources, "extensions", "user_default")
    extensions.mkdir(parents=True)
    link_folder(extensions / "angen_sensors", ROOT)
    os.environ["BLENDER_USER_RESOURCES"] = resources
    if os.environ.get("ANGEN_WINDOWS"):
        imitated_windows.imitate()


def pytest_runtest_setup() -> None:
    """Imitate Windows if that is asked for."""
    if os.environ.get("ANGEN_WINDOWS"):
        imitated_windows.without_locks()


def _remove(resources: str, base: str) -> None:
    """Remove the folders of this process and its children, and pytest's folder if it is empty."""
    shutil.rmtree(resources, ignore_errors=True)
    for folder in Path(base).glob("pytest-of-*"):
        with contextlib.suppress(OSError):
            folder.rmdir()


@functools.cache
def enabled_addon() -> ModuleType:
    """Return the extension, enabled in this process's Blender."""
    import addon_utils

    module = addon_utils.enable(ADDON, default_set=True)
    if module is None:  # Blender has printed the error above
        raise RuntimeError(f"{ADDON} could not be enabled")
    return module


def pytest_sessionfinish() -> None:
    """Disable the extension: Blender 4.2's module crashes at its end if it is still enabled."""
    if enabled_addon.cache_info().currsize:
        import addon_utils

        addon_utils.disable(ADDON)


class NeedsBlender(pytest.Module):
    """Replaces a test file that cannot be imported here."""

    def collect(self) -> Iterator[pytest.Item]:
        pytest.skip("needs Blender's Python module (bpy)")


def pytest_pycollect_makemodule(
    module_path: Path, parent: pytest.Collector
) -> pytest.Module | None:
    """Enable the extension before a file of tests/blender, which imports parts of it."""
    if ROOT / "tests" / "blender" not in module_path.parents:
        return None
    if not HAS_BPY:
        return NeedsBlender.from_parent(parent, path=module_path)
    import bpy  # noqa: F401  (it makes addon_utils and bl_ext importable)

    enabled_addon()
    return None


# Tests of results by Python and numpy, which do not depend on Blender's version; and tests in
# separate processes, which each start Blender.
ONCE = ("pure", "sample", "test_packaging.py", "test_demo_table.py")
ONCE += tuple(
    f"blender/test_{name}.py"
    for name in (
        "assets",
        "command_outputs",
        "command_processes",
        "couple",
        "day_command",
        "package",
        "study_days",
        "study_run",
        "study_together",
        "tutorials",
    )
)


# Tests that show most of what differs between versions of Blender: what users see, registration,
# panels, depsgraph, meshes, actions and light. `.ci/run` asks them of each version at every change.
EACH = tuple(
    f"test_{name}.py"
    for name in (
        "bake",
        "day",
        "golden",
        "handles",
        "light_scene",
        "nothing_evaluated_kept",
        "odd_geometries",
        "overlay",
        "panels",
        "playhead",
        "ray_layer",
        "recording_stale",
        "registration",
        "residents",
        "room",
        "sample_homes",
        "side_effects",
        "systems",
        "timeline",
    )
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests by their folder or file."""
    once = [ROOT / "tests" / name for name in ONCE]
    each = [ROOT / "tests" / "blender" / name for name in EACH]
    for item in items:
        if item.path in each:
            item.add_marker("each")
        if any(path in (item.path, *item.path.parents) for path in once):
            item.add_marker("once")
        for folder in ("blender", "e2e"):
            if ROOT / "tests" / folder in item.path.parents:
                item.add_marker(folder)


@pytest.fixture(scope="session")
def addon() -> ModuleType:
    """Return the extension's root module, with the extension enabled."""
    return enabled_addon()


@pytest.fixture
def figure(record_property) -> Callable[..., None]:
    """Note a measured figure of a hard case, such as the worst error, for docs/hard_cases.md.

    Of all cases of a test the greatest number counts, or a text.
    """

    def note(found: float | str, unit: str = "") -> None:
        record_property("figure", found if isinstance(found, str) else f"{float(found)!r}\t{unit}")

    return note


@pytest.fixture
def empty_scene(addon: ModuleType) -> None:
    """Open a new file with one empty scene, with the extension still enabled."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert hasattr(bpy.types.Object, "angen_sensor"), "the extension was lost with the file"
