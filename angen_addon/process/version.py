# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's version, read from its manifest."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

MANIFEST = Path(__file__).resolve().parents[2] / "blender_manifest.toml"


def manifest() -> dict[str, Any]:
    """Return the content of the extension's manifest."""
    return tomllib.loads(MANIFEST.read_text(encoding="utf-8"))


def extension_version() -> str:
    """Return the extension's version, such as 1.2.3."""
    return str(manifest()["version"])
