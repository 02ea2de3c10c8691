# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack what a release offers beside the extension: build_downloads.py FOLDER.

The sample homes with their routines and the examples of the docs, at the paths that the pages give;
the asset library that `make assets` builds; the site of the docs that `make docs` builds. The same
files give the same bytes. `make downloads` runs all of it.
"""

import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

from build_zip import MANIFEST, ROOT, pack

HOMES = ("sample_blends/*.blend", "sample_blends/*.toml", "docs/examples/**/*", "LICENSE")
# For each zip the folder that its names begin in, what makes it, and the patterns of its files.
ZIPS = {
    "homes": (ROOT, "", HOMES),
    "assets": (ROOT / "dist" / "assets", "make assets", ("**/*",)),
    "docs": (ROOT / "build" / "site", "make docs", ("**/*",)),
}


def files_of(root: Path, patterns: tuple[str, ...]) -> list[str]:
    """Return the names of the files in a folder that match a pattern, sorted."""
    found = (path for pattern in patterns for path in root.glob(pattern))
    names = (path.relative_to(root) for path in found if path.is_file())
    return sorted({name.as_posix() for name in names if "__pycache__" not in name.parts})


def build(folder: Path) -> Iterator[Path]:
    """Write the zips into a folder, and yield their paths. Exit if one has no files yet."""
    version = tomllib.loads((ROOT / MANIFEST).read_text(encoding="utf-8"))["version"]
    folder.mkdir(parents=True, exist_ok=True)
    for name, (root, made_by, patterns) in ZIPS.items():
        names = files_of(root, patterns)
        if not names:
            sys.exit(f"build_downloads: there is nothing in {root}: run `{made_by}` first")
        target = folder / f"angen_sensors_{name}-{version}.zip"
        pack(target, names, root, compress=True)
        yield target


if __name__ == "__main__":
    for path in build(Path(sys.argv[1])):
        print(path)
