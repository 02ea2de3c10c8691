# SPDX-License-Identifier: GPL-3.0-or-later
"""An argument parser that prints its errors in one line, as all other errors are."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NoReturn


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"angen: {message} (see --help)\n")


def path(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError("the name of a file or folder is empty")
    return Path(text)
