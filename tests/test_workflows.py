# SPDX-License-Identifier: GPL-3.0-or-later
"""The workflows run what the project's own scripts know, and leave out nothing."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORKFLOWS = ROOT / ".github" / "workflows"


def test_the_workflow_runs_every_part_of_the_checks() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (versions,) = re.findall(r'^versions="(.*)"$', script, re.MULTILINE)
    told = re.findall(r"^#   \.ci/run (\w+)", script, re.MULTILINE)
    parts = {part for part in told if part not in {"version", "whole"}}
    assert all(f"\n{part}() {{" in script for part in {*parts, "version", "whole"})
    (listed,) = re.findall(r"part: \[(.*)\]", (WORKFLOWS / "ci.yml").read_text(encoding="utf-8"))
    # Real Blenders have a job of their own.
    wanted = parts - {"programs"} | {f"version {version}" for version in versions.split()}
    assert set(listed.split(", ")) == wanted
