# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that a tag can be released, and write its notes.

check_release.py vX.Y.Z NOTES.md

The version of the tag must be that of blender_manifest.toml, pyproject.toml and CITATION.cff, and
CHANGELOG.md must have a section `## X.Y.Z, YYYY-MM-DD`, which becomes the notes. The date must be
that of CITATION.cff. The zip, which this script builds, must follow the rules in RULES, which are
those of Blender's extension platform.
"""

import ast
import functools
import re
import sys
import tempfile
import tomllib
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import build_zip

ROOT = Path(__file__).resolve().parent.parent
# The files that must agree with each other.
READ = ("blender_manifest.toml", "pyproject.toml", "CITATION.cff", "CHANGELOG.md", "mkdocs.yml")


def problems(tag: str, root: Path = ROOT) -> list[str]:
    """Return the reasons against a release, one a line."""
    version = tag.removeprefix("v")
    if not re.fullmatch(r"v\d+\.\d+\.\d+", tag):
        return [f"the tag {tag} is not of the form v1.2.3"]
    missing = [f"{name} is missing" for name in READ if not (root / name).is_file()]
    if missing:
        return missing
    manifest = tomllib.loads((root / "blender_manifest.toml").read_text(encoding="utf-8"))
    package = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (root / "CITATION.cff").read_text(encoding="utf-8")
    cited = re.search(r"^version: (\S+)", citation, re.MULTILINE)
    released = re.search(r"^date-released: (\S+)", citation, re.MULTILINE)
    found = {
        "blender_manifest.toml": manifest["version"],
        "pyproject.toml": package["version"],
        "CITATION.cff": cited[1] if cited else "no version",
    }
    wrong = [
        f"{file} has {has}, the tag {version}" for file, has in found.items() if has != version
    ]
    site = re.search(r"^site_url: (\S+)", (root / "mkdocs.yml").read_text("utf-8"), re.MULTILINE)
    if not site or site[1] != manifest.get("website"):
        wrong.append("the manifest's website is not mkdocs.yml's site_url: F1 opens its pages")
    section = _section(version, root)
    if not section or not section[2].strip():
        wrong.append(f"CHANGELOG.md has no section '## {version}, YYYY-MM-DD' with a text")
    elif not released or released[1] != section[1]:
        date = released[1] if released else "no date"
        wrong.append(f"CITATION.cff has {date}, CHANGELOG.md {section[1]}")
    return wrong


def notes(version: str, root: Path = ROOT) -> str:
    """Return the text of the changelog's section on a version; "" without a dated section."""
    found = _section(version, root)
    return found[2].strip() if found else ""


def _section(version: str, root: Path) -> re.Match[str] | None:
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    heading = rf"^## {re.escape(version)}, (\d{{4}}-\d\d-\d\d)\n(.*?)(?=^## |\Z)"
    return re.search(heading, text, re.MULTILINE | re.DOTALL)


# The rules for the zip. A check yields what breaks its rule.


class Zip:
    """A built zip: its manifest, its files, and the syntax nodes of its modules."""

    def __init__(self, path: Path) -> None:
        with zipfile.ZipFile(path) as packed:
            self.files = {n: packed.read(n) for n in packed.namelist() if not n.endswith("/")}
        self.manifest: dict[str, Any] = tomllib.loads(self.text("blender_manifest.toml"))
        names = [name for name in self.files if name.endswith(".py")]
        self.nodes = {name: list(ast.walk(ast.parse(self.text(name)))) for name in names}

    def text(self, name: str) -> str:
        """Return the text of a file; empty if it is missing."""
        return self.files.get(name, b"").decode("utf-8")

    @functools.cached_property
    def imports(self) -> list[tuple[str, str]]:
        """Each module's file with the full name of each module that it imports absolutely."""
        return list(self._imports())

    def _imports(self) -> Iterator[tuple[str, str]]:
        for name, nodes in self.nodes.items():
            for node in nodes:
                if isinstance(node, ast.Import):
                    yield from ((name, alias.name) for alias in node.names)
                elif isinstance(node, ast.ImportFrom) and not node.level:
                    yield name, node.module or ""

    @functools.cached_property
    def reached(self) -> set[str]:
        """The files of the modules that the extension can import, beginning with its own."""
        named = {
            f"{node.value.replace('.', '/')}.py"
            for node in self.nodes.get("parts.py", ())
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        found: set[str] = set()
        new = {"__init__.py", *named, *(name for name in self.nodes if name.startswith(FOUND))}
        while new := (new & self.nodes.keys()) - found:
            found |= new
            new = {other for name in new for other in self._relative(name)}
        return found

    def _relative(self, name: str) -> Iterator[str]:
        """Yield the files that a module may import, some of which may not exist."""
        for node in self.nodes[name]:
            if isinstance(node, ast.ImportFrom) and node.level:
                base = [*name.split("/")[: -node.level], *(node.module or "").split(".")]
                base = [part for part in base if part]
                for module in (base, *([*base, alias.name] for alias in node.names)):
                    yield "/".join(module) + ".py"
                    # Folders are imported with what they are in.
                    for end in range(len(module) + 1):
                        yield "/".join([*module[:end], "__init__.py"])


Found = Iterator[str]
README = "README_USERS.md"
# Tags for add-ons on the platform that fit.
TAGS = {"Animation", "Physics", "Import-Export", "Pipeline", "Scene", "3D View"}
NETWORK = {"socket", "ssl", "urllib", "http", "requests", "smtplib", "ftplib", "paho"}
# Folders of which each module is imported, whatever its name.
FOUND = ("sensor_logic/kinds/", "angen_addon/kinds/", "angen_addon/scene/surfaces/")
# Base classes of what Blender registers, and how its identifiers begin.
REGISTERED = {"PropertyGroup", "Operator", "Panel", "Menu", "UIList", "Gizmo", "GizmoGroup"}
OURS = ("angen.", "ANGEN_", "Angen", "_Angen", "angen_")
# Functions that run a text as code or as a command.
RUN_TEXT = {"eval", "exec", "compile", "__import__", "os.system", "os.popen"}
# Files of the Python package and of the repository alone.
OTHER_WAYS = (
    *("__main__.py", "standalone.py", "setup.py", "pyproject.toml", "Makefile"),
    *("commands/convert.py", "commands/compare.py", "commands/replay.py", "learn.py"),
    *("api.py", "api/", "studies/"),
)


def _manifest(packed: Zip) -> Found:
    manifest = packed.manifest
    if not str(manifest.get("website", "")).startswith("https://"):
        yield "the manifest has no website"
    tags = set(manifest.get("tags", ()))
    if "Import-Export" not in tags or tags - TAGS:
        yield f"the tags are {sorted(tags)}"
    if "blender" in str(manifest.get("name", "")).lower():
        yield "the name contains 'Blender'"
    if manifest.get("license") != ["SPDX:GPL-3.0-or-later"] or "LICENSE" not in packed.files:
        yield "the licence is not GPL-3.0-or-later, with its text"


def _permissions(packed: Zip) -> Found:
    reasons = packed.manifest.get("permissions", {})
    uses = {"files": True, "network": any(n.split(".")[0] in NETWORK for _, n in packed.imports)}
    for name in {*reasons, *(name for name, used in uses.items() if used)}:
        if not reasons.get(name) or not uses.get(name):
            yield f"permission '{name}': {'no reason' if uses.get(name) else 'not needed'}"


def _online(packed: Zip) -> Found:
    for name, module in packed.imports:
        text = packed.text(name)
        # A pair of sockets in one process is no network.
        connects = module not in ("ssl", "socket") or ".connect(" in text
        if module.split(".")[0] in NETWORK and connects and "check_online()" not in text:
            yield f"{name} imports {module}, and does not ask for online access"


def _wheels(packed: Zip) -> Found:
    listed = {wheel.removeprefix("./") for wheel in packed.manifest.get("wheels", ())}
    for wheel in listed ^ {name for name in packed.files if name.endswith(".whl")}:
        yield f"{wheel} is not both in the zip and in the manifest"
    for wheel in listed:
        package = Path(wheel).name.partition("-")[0].replace("_", "-")
        if not packed.text(f"wheels/LICENSE-{package}.txt"):
            yield f"{wheel} has no licence beside it"
        if not any(f"({package})" in holder for holder in packed.manifest.get("copyright", ())):
            yield f"the manifest's copyright does not name the authors of {package}"
        if not wheel.endswith("-py3-none-any.whl"):
            yield f"{wheel} is not pure Python"


def _other_ways(packed: Zip) -> Found:
    for name in packed.files:
        if any(f"/{name}".endswith(f"/{way}") or f"/{way}" in f"/{name}" for way in OTHER_WAYS):
            yield f"{name} is for another way to run"
    for name, nodes in packed.nodes.items():
        # Also in the text of a program for another process.
        if "sys.path." in packed.text(name) or "sys.path[" in packed.text(name):
            yield f"{name} changes sys.path"
        for node in nodes if "sys.modules" in packed.text(name) else ():
            targets = node.targets if isinstance(node, ast.Assign) else []
            texts = [ast.unparse(target) for target in targets]
            if isinstance(node, ast.Call):
                texts = [t for t in [ast.unparse(node.func)] if not t.startswith("sys.modules.get")]
            if any(text.startswith("sys.modules") for text in texts):
                yield f"{name} changes sys.modules"


def _leftovers(packed: Zip) -> Found:
    for name in packed.files:
        hidden = any(part.startswith((".", "__pycache__")) for part in name.split("/"))
        text = name in ("LICENSE", README) or name.startswith("wheels/LICENSE-")
        if hidden or not (text or name.endswith((".py", ".po", ".json", ".toml", ".whl"))):
            yield f"{name} does not belong into a zip"
        if name.startswith(("docs/", "tests/", "scripts/", "benchmarks/", "sample_blends/")):
            yield f"{name} is for developers"


def _readme(packed: Zip) -> Found:
    text = packed.text(README)
    if not text:
        yield f"{README} is missing"
    for word in ("make ", "pip install", "pytest", ".venv", "git clone"):
        if word in text:
            yield f"{README} tells users '{word.strip()}'"


def _processes(packed: Zip) -> Found:
    starts = [name for name, module in packed.imports if module == "subprocess"]
    words = {
        "angen_addon/scene/light/engine.py": "EEVEE",
        "residents/blender/shared_days.py": "--jobs",
    }
    for name in starts:
        if words.get(name, name) not in packed.text(README):
            yield f"{name} starts a process that {README} does not tell"


def _imports(packed: Zip) -> Found:
    absolute = {"angen_sensors", "angen_addon", "operators", "panels", "residents", "sensor_logic"}
    for name, module in packed.imports:
        if module.split(".")[0] in absolute:
            yield f"{name} imports {module}: imports within an extension are relative"


def _reachable(packed: Zip) -> Found:
    for name in sorted(packed.nodes.keys() - packed.reached):
        yield f"nothing imports {name}"


def _calls(packed: Zip) -> Iterator[tuple[str, str, ast.Call]]:
    """Yield each module's file with each call in it, after the name of the function."""
    for name, nodes in packed.nodes.items():
        for node in nodes:
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
                yield name, ast.unparse(node.func), node


def _running_text(packed: Zip) -> Found:
    for name, function, call in _calls(packed):
        if function in RUN_TEXT or "shell" in {word.arg for word in call.keywords}:
            yield f"{name} calls {function}"


def _printing(packed: Zip) -> Found:
    for name, function, call in _calls(packed):
        if function == "print" and "file" not in {word.arg for word in call.keywords}:
            yield f"{name} prints"


def _keymaps(packed: Zip) -> Found:
    for name in packed.nodes:
        if re.search(r"keyconfigs\.(?:user|default)\b", packed.text(name)):
            yield f"{name} takes keymaps of the user or of Blender"


def _names(packed: Zip) -> Found:
    for name, nodes in packed.nodes.items():
        for node in nodes:
            found: list[str] = []
            if isinstance(node, ast.ClassDef):
                bases = {ast.unparse(base).rpartition(".")[2] for base in node.bases}
                found = [node.name] if bases & REGISTERED else []
            elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
                of = [getattr(target, "id", "") for target in node.targets]
                found = [str(node.value.value)] if "bl_idname" in of else []
            elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Call):
                attributes = [t.attr for t in node.targets if isinstance(t, ast.Attribute)]
                made = attributes and ast.unparse(node.value.func).endswith("Property")
                found = attributes if made else []
            yield from (f"{name}: {one}" for one in found if not one.startswith(OURS))


RULES: tuple[tuple[str, Callable[[Zip], Found]], ...] = (
    ("the manifest has a website, tags of the platform and a GPL licence", _manifest),
    ("each permission is needed, and has its reason", _permissions),
    ("what opens a connection first asks whether Blender allows online access", _online),
    ("wheels are in the zip, pure Python, and with their licence", _wheels),
    ("no code for other ways to run it than as an extension", _other_ways),
    ("modules import each other relatively", _imports),
    ("no compiled, hidden, binary or stray files, and none for developers", _leftovers),
    ("the README is for users", _readme),
    ("each process that it starts is told", _processes),
    ("each module can be imported, beginning with __init__.py", _reachable),
    ("no text is run as code, or by a shell", _running_text),
    ("nothing is printed into Blender's console but warnings, to the error output", _printing),
    ("keys are added to those of add-ons alone", _keymaps),
    ("what Blender registers has a name that begins with the extension's", _names),
)


def zip_problems(path: Path) -> list[str]:
    """Return what in a built zip breaks a rule, one a line with the rule."""
    packed = Zip(path)
    return [f"{text} (rule: {rule})" for rule, check in RULES for text in check(packed)]


def built_problems() -> list[str]:
    """Build the zip, and return what in it breaks a rule, or why it cannot be built."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return zip_problems(build_zip.build(Path(folder), None))
        except ValueError as error:
            return [str(error)]


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    found = problems(sys.argv[1]) + built_problems()
    if found:
        sys.exit("\n".join(f"check_release: {line}" for line in found))
    Path(sys.argv[2]).write_text(notes(sys.argv[1][1:]) + "\n", encoding="utf-8")
