# SPDX-License-Identifier: GPL-3.0-or-later
"""Command lines that tell what is wrong in one line, as every other error."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NoReturn


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"angen: {message} (--help tells more)\n")


def path(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("an empty name is no file or folder")
    return Path(text)
