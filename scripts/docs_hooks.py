# SPDX-License-Identifier: GPL-3.0-or-later
"""What the site of the docs does with its pages (mkdocs.yml): links to files that are in the
repository and not in the site become their names, and the package's docstrings are found."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
# The package as scripts import it, and no more of the checkout: mkdocstrings reads all of it.
PACKAGE = ROOT / "build" / "package" / "angen_sensors"
PARTS = ("__init__.py", "angen_addon", "residents", "sensor_logic")

OUTSIDE = re.compile(r"(?<!!)\[([^\]]+)\]\((?:\.\./[^)]+|examples/[^)]+\.py|studies/[^)]+\.toml)\)")


def on_startup(**_: Any) -> None:
    """Lays out the package."""
    PACKAGE.mkdir(parents=True, exist_ok=True)
    for part in PARTS:
        link = PACKAGE / part
        link.unlink(missing_ok=True)
        link.symlink_to(ROOT / part)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """The page with its links to files of the repository as text."""
    return OUTSIDE.sub(r"\1", markdown)
