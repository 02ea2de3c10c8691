# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that a tag can be released, and write its notes.

check_release.py vX.Y.Z NOTES.md

The version of the tag must be that of blender_manifest.toml, pyproject.toml and CITATION.cff, and
CHANGELOG.md must have a section `## X.Y.Z, YYYY-MM-DD`, which becomes the notes.
"""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def problems(tag: str, root: Path = ROOT) -> list[str]:
    """Return the reasons against a release, one a line."""
    version = tag.removeprefix("v")
    if not re.fullmatch(r"v\d+\.\d+\.\d+", tag):
        return [f"the tag {tag} is not of the form v1.2.3"]
    manifest = tomllib.loads((root / "blender_manifest.toml").read_text(encoding="utf-8"))
    package = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    cited = re.search(r"^version: (\S+)", (root / "CITATION.cff").read_text(), re.MULTILINE)
    found = {
        "blender_manifest.toml": manifest["version"],
        "pyproject.toml": package["version"],
        "CITATION.cff": cited[1] if cited else "no version",
    }
    wrong = [
        f"{file} has {has}, the tag {version}" for file, has in found.items() if has != version
    ]
    if not notes(version, root):
        wrong.append(f"CHANGELOG.md has no section '## {version}, YYYY-MM-DD' with a text")
    return wrong


def notes(version: str, root: Path = ROOT) -> str:
    """Return the text of the changelog's section on a version; "" without a dated section."""
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    heading = rf"^## {re.escape(version)}, \d{{4}}-\d\d-\d\d\n(.*?)(?=^## |\Z)"
    found = re.search(heading, text, re.MULTILINE | re.DOTALL)
    return found[1].strip() if found else ""


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    found = problems(sys.argv[1])
    if found:
        sys.exit("\n".join(f"check_release: {line}" for line in found))
    Path(sys.argv[2]).write_text(notes(sys.argv[1][1:]) + "\n", encoding="utf-8")
