# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress of a long part on standard error."""

from __future__ import annotations

import sys


def progress(part: str, done: int, total: int, now: str) -> None:
    print(f"  {part}: {done} of {total} done, now {now}", file=sys.stderr, flush=True)
