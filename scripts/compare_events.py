# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare two event logs: exactly, except for forces (within 1 mN) and light (ignored).

Blender's versions round the vertices of deformed meshes differently, and each version of Cycles
traces other paths.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from sensor_logic.logs.log import differences, read_events

FORCE_TOLERANCE = 1e-3


def compare(one: Path, two: Path) -> list[str]:
    """Return the differences, one a line."""
    logs = [[e for e in read_events(path) if e.kind != "LIGHT"] for path in (one, two)]
    return differences(logs[0], logs[1], FORCE_TOLERANCE, 0.0)


if __name__ == "__main__":
    found = compare(Path(sys.argv[1]), Path(sys.argv[2]))
    print("\n".join(found[:20]), file=sys.stderr)
    sys.exit(bool(found))
