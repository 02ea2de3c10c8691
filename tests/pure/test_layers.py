# SPDX-License-Identifier: GPL-3.0-or-later
"""Which module may import which: sensing imports nothing that shows it, and there are no cycles."""

import ast
import graphlib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Each house imports itself and those before it. A module is in the first house that has its folder.
HOUSES = (
    ("sensor_logic.logs",),
    ("angen_addon", "operators", "panels", "sensor_logic"),
    ("residents",),
    ("studies",),
)
PRODUCT = tuple(folder for house in HOUSES for folder in house if "." not in folder)
SENSING = tuple(f"angen_addon.{name}" for name in ("runtime", "scene", "recording"))
INTERFACE = (
    "operators",
    "panels",
    *(f"angen_addon.{name}" for name in ("view", "kinds", "commands", "output", "api")),
)
# The modules that draw, and those that define what is drawn.
WINDOW = (
    *("operators", "panels", "angen_addon.view", "angen_addon.kinds"),
    *("residents.operators", "residents.panels", "residents.blender.places_drawn"),
    "studies.window",
)


def modules() -> dict[str, Path]:
    found = {}
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = path
    return found


MODULES = modules()


def imported(name: str, everywhere: bool = False) -> Iterator[str]:
    """Yield the product's modules that a module imports as it is loaded, or `everywhere` in it."""
    path = MODULES[name]
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree) if everywhere else tree.body:
        if isinstance(node, ast.ImportFrom) and node.level:
            above = package.split(".")
            base = above[: len(above) - node.level + 1] + [node.module] * bool(node.module)
            for alias in node.names:
                inner = ".".join([*base, alias.name])
                yield inner if inner in MODULES else ".".join(base)


GRAPH = {name: set(imported(name)) & set(MODULES) - {name} for name in MODULES}


def reached(name: str, found: set[str], graph: dict[str, set[str]] = GRAPH) -> set[str]:
    for other in graph[name] - found:
        found.add(other)
        reached(other, found, graph)
    return found


def test_the_product_was_found() -> None:
    assert len(MODULES) > 300
    assert "angen_addon.runtime.stage" in GRAPH["angen_addon.runtime.simulation"]


def test_sensing_imports_nothing_that_shows_or_writes_it() -> None:
    wrong = {
        (name, other)
        for name in MODULES
        if name.startswith(SENSING)
        for other in reached(name, set())
        if other.startswith(INTERFACE)
    }
    assert not wrong


def test_the_core_imports_no_panel_and_no_operator() -> None:
    core = [name for name in MODULES if name.startswith(("angen_addon", "sensor_logic"))]
    assert not {
        (name, other)
        for name in core
        for other in set(imported(name, everywhere=True))
        if other.startswith(("panels", "operators"))
    }


def test_what_a_kind_looks_like_knows_no_view() -> None:
    lower = [n for n in MODULES if n.startswith(("angen_addon.kinds", "angen_addon.appearance"))]
    wrong = {(n, o) for n in lower for o in imported(n, True) if o.startswith("angen_addon.view")}
    assert len(lower) > 15 and not wrong


def test_only_what_is_in_the_window_imports_what_draws_it() -> None:
    """Plans, explanations, coverage, days and the command line work without it."""
    outside = [name for name in MODULES if not name.startswith(WINDOW)]
    wrong = {
        (name, other)
        for name in outside
        for other in reached(name, set())
        if other.startswith(WINDOW) and other != "angen_addon.kinds"
    }
    assert len(outside) > 200 and not wrong


def imported_absolutely(path: Path) -> Iterator[str]:
    """Yield the product's modules that a file imports by their full names."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            inner = name.removeprefix("bl_ext.user_default.").removeprefix("angen_sensors.")
            if inner.partition(".")[0] in PRODUCT:
                yield inner


def house_of(name: str) -> int:
    """Return the index of a module's house."""
    return next(
        number
        for number, folders in enumerate(HOUSES)
        if any(f"{name}.".startswith(f"{folder}.") for folder in folders)
    )


def test_no_house_imports_one_after_it() -> None:
    """Imports of all sorts count: at load time, inside functions, and for types alone.

    The root names the houses' verbs as texts.
    """
    found = [
        (name, other)
        for name, path in MODULES.items()
        for other in (*imported(name, everywhere=True), *imported_absolutely(path))
        if other.partition(".")[0] in PRODUCT
    ]
    assert not {(name, other) for name, other in found if house_of(other) > house_of(name)}
    assert ("studies.runs", "studies.truth") in found, "inside a function"
    assert ("studies.results", "studies.tasks") in found, "for types alone"


def circles() -> set[frozenset[str]]:
    """Return the sets of modules that import each other in a circle.

    Imports of all sorts count: at load time, inside functions, and for types alone. Importing a
    module loads the packages around it.
    """
    needs: dict[str, set[str]] = {}
    for name in MODULES:
        found = {other for one in imported(name, everywhere=True) for other in packages(one)}
        needs[name] = found & set(MODULES) - packages(name)
    reach = {name: reached(name, set(), needs) for name in MODULES}
    return {
        frozenset(other for other in found if name in reach[other])
        for name, found in reach.items()
        if name in found
    }


def packages(name: str) -> set[str]:
    """Return the module, and the packages that contain it."""
    parts = name.split(".")
    return {".".join(parts[:depth]) for depth in range(1, len(parts) + 1)}


def test_nothing_imports_in_a_circle() -> None:
    # It raises CycleError, which names them.
    list(graphlib.TopologicalSorter(GRAPH).static_order())
    assert not circles()
