# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the tables of options in docs/command_line.md from the parsers of the verbs.

python scripts/command_tables.py      (needs Blender's module)
"""

import argparse
import sys
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from angen_addon.process.standalone import PACKAGE, load_extension  # noqa: E402

PAGE = ROOT / "docs" / "command_line.md"
MARK = "<!-- Below: written by scripts/command_tables.py -->\n"


def page() -> str:
    """Return docs/command_line.md with its tables renewed."""
    written = PAGE.read_text(encoding="utf-8")
    return written[: written.index(MARK) + len(MARK)] + "".join(map(_section, _parsers()))


def _parsers() -> list[argparse.ArgumentParser]:
    """Return the parsers of all verbs, first those that take a blend file."""
    load_extension()
    commands = import_module(f"{PACKAGE}.angen_addon.process.parser")
    parts = import_module(f"{PACKAGE}.parts")
    on_files = commands.make_parser("angen")
    found = _verbs(on_files)
    for module in parts.WITHOUT_BLENDER.values():
        parser = parts.part(module).make_parser("angen")
        found += _verbs(parser) or [parser]
    return found


def _verbs(parser: argparse.ArgumentParser) -> list[argparse.ArgumentParser]:
    """Return the parsers of a parser's verbs, if it has any."""
    choices = [a.choices for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    return [parser for verbs in choices for parser in verbs.values()]


def _section(parser: argparse.ArgumentParser) -> str:
    """Return the heading of a verb and the table of its options."""
    hidden = {"help", "enable_autoexec"}
    shown = [a for a in parser._actions if a.dest not in hidden and a.help != argparse.SUPPRESS]
    rows = list(map(_row, shown))
    table = "| option | meaning |\n|---|---|\n" + "".join(rows) if rows else ""
    return f"\n## {parser.prog}\n\n{table}"


def _row(action: argparse.Action) -> str:
    """Return the row of an option. Raise `ValueError` if the option has no help."""
    if not action.help:
        raise ValueError(f"the option {action.metavar or action.dest} has no help")
    value = action.metavar or ("" if action.nargs == 0 else action.dest.upper())
    names = ", ".join(action.option_strings)
    value = f"[{value}]" if action.nargs == "?" and names else value
    shown = f"{names} {value}".strip()
    text = action.help.replace("%%", "%").replace("|", "\\|")
    return f"| `{shown}` | {text} |\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
