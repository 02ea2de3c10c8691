# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the JSON schema of layouts from the parameter dataclasses."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from sensor_logic.layout.schema import FILE, schema_text

if __name__ == "__main__":
    FILE.write_text(schema_text(), encoding="utf-8")
