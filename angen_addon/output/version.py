# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's version, read from its manifest."""

from __future__ import annotations

import tomllib
from pathlib import Path

MANIFEST = Path(__file__).resolve().parents[2] / "blender_manifest.toml"


def extension_version() -> str:
    """Return the extension's version, such as 1.2.3."""
    return str(tomllib.loads(MANIFEST.read_text(encoding="utf-8"))["version"])
