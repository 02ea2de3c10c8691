# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks of the site of the docs (mkdocs.yml).

Links to files of the repository that are not in the site become text, and mkdocstrings finds the
package.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
# The package as scripts import it, without the rest of the checkout: mkdocstrings reads it all.
PACKAGE = ROOT / "build" / "package" / "angen_sensors"
PARTS = ("__init__.py", "angen_addon", "residents", "sensor_logic")

OUTSIDE = re.compile(r"(?<!!)\[([^\]]+)\]\((?:\.\./[^)]+|examples/[^)]+\.py|studies/[^)]+\.toml)\)")


def on_startup(**_: Any) -> None:
    """Link the package's parts into one folder."""
    PACKAGE.mkdir(parents=True, exist_ok=True)
    for part in PARTS:
        link = PACKAGE / part
        link.unlink(missing_ok=True)
        link.symlink_to(ROOT / part)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the page with its links to files of the repository as text."""
    return OUTSIDE.sub(r"\1", markdown)
