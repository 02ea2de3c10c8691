# SPDX-License-Identifier: GPL-3.0-or-later
"""The workflows run what the project's own scripts know, and leave out nothing."""

import os
import re
import subprocess
import textwrap
import tomllib
from pathlib import Path

import pytest

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


@pytest.mark.skipif(os.name == "nt", reason="the release is made on Linux")
@pytest.mark.parametrize("is_there", [True, False])
def test_a_release_waits_for_the_site_that_the_manifest_names(
    tmp_path: Path, is_there: bool
) -> None:
    text = (WORKFLOWS / "release.yml").read_text(encoding="utf-8")
    steps = text.split("      - name: The site of the docs is there\n        run: |\n")
    script, _, after = steps[1].partition("\n      - ")
    assert "gh release create" in after and "gh release create" not in steps[0]
    curl = tmp_path / "curl"
    curl.write_text(f'#!/bin/sh\necho "$@" >>{tmp_path}/asked\nexit {0 if is_there else 22}\n')
    curl.chmod(0o755)
    done = subprocess.run(
        ["bash", "-e", "-c", textwrap.dedent(script)],
        cwd=ROOT,
        env={**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
    )
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    page = manifest["website"] + "window.html"
    assert (tmp_path / "asked").read_text().split()[-1] == page
    assert done.returncode == (0 if is_there else 1)
    assert done.stdout.startswith(f"::error::{page} is not there") != is_there
