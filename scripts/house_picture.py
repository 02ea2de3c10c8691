# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the folders of the code in CONTRIBUTING.md from their imports, as a Mermaid flowchart.

python scripts/house_picture.py

A box has folders that import each other. An arrow goes to an imported box, unless a longer path of
arrows leads there.
"""

import ast
import re
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "CONTRIBUTING.md"
FOLDERS = ("sensor_logic", "angen_addon", "operators", "panels", "residents", "studies")
IN_BLENDER = ("blender", "operators", "panels")
Arrows = dict[str, set[str]]


def folder_of(module: str) -> str:
    """Return the folder that stands for a module in the picture."""
    house, _, rest = module.partition(".")
    part = rest.partition(".")[0]
    if house == "residents":
        return f"residents ({'in Blender' if part in IN_BLENDER else 'pure'})"
    if (house, part) == ("sensor_logic", "logs"):
        return "sensor_logic/logs"
    return f"angen_addon/{part}" if house == "angen_addon" else house


def arrows() -> Arrows:
    """Return, for each folder, the folders that its modules import when they are loaded."""
    found: Arrows = defaultdict(set)
    for path in (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        here = folder_of(".".join(parts))
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ImportFrom) and node.level:
                above = parts[: len(parts) - node.level]
                for name in [node.module] if node.module else [a.name for a in node.names]:
                    found[here].add(folder_of(".".join([*above, name])))
    return {name: others & set(found) - {name} for name, others in found.items()}


def reached(graph: Arrows, name: str) -> set[str]:
    """Return the folders that a folder imports, directly or not."""
    found: set[str] = set()
    ways = [name]
    while ways:
        new = graph[ways.pop()] - found
        found |= new
        ways += new
    return found


def boxes(graph: Arrows) -> dict[str, frozenset[str]]:
    """Return, for each folder, the folders that import it and that it imports, and itself."""
    reach = {name: reached(graph, name) for name in graph}
    return {
        name: frozenset({name, *(o for o in reach[name] if name in reach[o])}) for name in graph
    }


def chart() -> str:
    """Return the flowchart in Mermaid's language."""
    graph = arrows()
    box = boxes(graph)
    ids = {names: f"n{i}" for i, names in enumerate(sorted(set(box.values()), key=sorted))}
    between: dict[frozenset[str], set[frozenset[str]]] = {names: set() for names in ids}
    for name, others in graph.items():
        between[box[name]] |= {box[other] for other in others} - {box[name]}
    small: Arrows = {ids[names]: {ids[o] for o in others} for names, others in between.items()}
    lines = ["```mermaid", "flowchart BT"]
    for names, number in ids.items():
        lines.append(f'  {number}["{"<br>".join(sorted(names))}"]')
    for number, others in small.items():
        for other in sorted(others):
            if not any(other in reached(small, third) for third in others - {other}):
                lines.append(f"  {number} --> {other}")
    return "\n".join([*lines, "```"])


def page() -> str:
    """Return CONTRIBUTING.md with the picture renewed."""
    written = PAGE.read_text(encoding="utf-8")
    return re.sub(r"```mermaid\n.*?```", lambda _: chart(), written, flags=re.DOTALL)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
