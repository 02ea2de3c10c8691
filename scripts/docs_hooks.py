# SPDX-License-Identifier: GPL-3.0-or-later
"""Hooks of the site of the docs (mkdocs.yml).

Links to files of the repository that are not in the site become text, and mkdocstrings finds the
package. A page that fetches scripts or styles from elsewhere ends the build.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
# The package as scripts import it, without the rest of the checkout: mkdocstrings reads it all.
PACKAGE = ROOT / "build" / "package" / "angen_sensors"
PARTS = ("__init__.py", "angen_addon", "residents", "sensor_logic")

REMOTE = re.compile(r'<(script|link rel="stylesheet")[^>]* (src|href)="https?:[^>]*>')
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


def on_post_page(output: str, page: Any, **_: Any) -> None:
    """End the build if a page fetches a script or a style from another site."""
    if found := REMOTE.search(output):
        sys.exit(f"{page.file.src_uri} needs the network: {found[0]}")
