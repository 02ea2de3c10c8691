# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's manifest, its zip, and texts that the repository must not contain."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
import zlib
from pathlib import Path
from typing import Any

import pytest

import build_downloads
import build_zip
import check_release

ROOT = build_zip.ROOT
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
SHIPPED_FILES = {"__init__.py", "parts.py", "blender_manifest.toml", "LICENSE", "README_USERS.md"}
SHIPPED_FOLDERS = ("angen_addon", "operators", "panels", "residents", "sensor_logic", "wheels")
# For the Python package alone.
PACKAGE_ALONE = (
    *("angen_addon/__main__.py", "angen_addon/api/", "angen_addon/process/standalone.py"),
    *(f"angen_addon/commands/{name}.py" for name in ("compare", "convert", "replay")),
    *("residents/blender/api.py", "residents/blender/learn.py"),
    *("residents/routine/learn.py", "residents/routine/text.py"),
    *("sensor_logic/logs/comparison/", "sensor_logic/report/comparison.py"),
    *(
        f"sensor_logic/logs/formats/{name}.py"
        for name in ("activities", "intervals", "label_map", "reading")
    ),
)


def tracked_files() -> list[str]:
    """Return the files of the checkout by git; skip the test without git."""
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("needs a git checkout")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    return [name for name in listed.stdout.decode().split("\0") if name and (ROOT / name).is_file()]


@pytest.fixture(scope="module", params=["by Blender's tool", "without Blender"])
def built(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build and validate the zip, with Blender's own tool and without it."""
    tool = build_zip.extension_tool() if "tool" in request.param else None
    if tool is None and "tool" in request.param:
        pytest.skip("there is no Blender here")
    return build_zip.build(tmp_path_factory.mktemp("zip"), tool)


def test_the_manifest_says_what_users_rely_on() -> None:
    told = {
        "id": "angen_sensors", "name": "Ängen Sensors", "blender_version_min": "4.2.0",
        "license": ["SPDX:GPL-3.0-or-later"],
    }  # fmt: skip
    assert {key: MANIFEST[key] for key in told} == told
    assert set(MANIFEST["permissions"]) == {"files", "network"}
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert "Version 3, 29 June 2007" in text and len(text.splitlines()) > 600
    version = MANIFEST["version"]
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\n## {version}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_zip_holds_what_runs_and_nothing_else(built: Path) -> None:
    runs = SHIPPED_FILES | {
        path.relative_to(ROOT).as_posix()
        for folder in SHIPPED_FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and not {"__pycache__", ".DS_Store"} & set(path.parts)
    }
    names = zipfile.ZipFile(built).namelist()
    assert all(any(name.startswith(one) for name in runs) for one in PACKAGE_ALONE)
    assert set(names) == {name for name in runs if not name.startswith(PACKAGE_ALONE)}


@pytest.mark.parametrize("built", ["without Blender"], indirect=True)
def test_the_zip_follows_the_rules_of_the_platform(built: Path) -> None:
    assert check_release.zip_problems(built) == []


def pack_with(few: Path, target: Path, name: str, text: str, reached: bool) -> None:
    """Write a zip with one more file, and modules that import all files that are reached."""
    with zipfile.ZipFile(few) as one, zipfile.ZipFile(target, "w") as other:
        kept = set(one.namelist()) - {name}
        for file in kept:
            other.writestr(file, one.read(file))
        other.writestr(name, text)
        imported = sorted(kept | {name} if reached else kept)
        modules = [file.removesuffix(".py").replace("/", ".") for file in imported]
        other.writestr("__init__.py", "from . import parts\n")
        other.writestr("parts.py", f"MODULES = {modules}\n")


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a zip of the manifest, its texts and one folder of modules."""
    kept = ("blender_manifest.toml", "LICENSE", "README_USERS.md", "wheels/", "angen_addon/output/")
    names = [name for name in build_zip.shipped(MANIFEST) if name.startswith(kept)]
    path = tmp_path_factory.mktemp("few") / "few.zip"
    build_zip.pack(path, names)
    return path


def manifest_with(pattern: str, text: str = "") -> str:
    manifest = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    changed = re.sub(f"(?m)^{pattern}", text, manifest)
    assert changed != manifest
    return changed


OFFLINE = "def f(context):\n    "
# What breaks each rule, in their order: a file with its text, and what is told.
BROKEN = (
    (
        ("blender_manifest.toml", lambda: manifest_with("website.*\n"), "has no website"),
        (
            "blender_manifest.toml",
            lambda: manifest_with('"Physics"|tags = .*', 'tags = ["Import-Export", "Sensors"]'),
            "the tags are ['Import-Export', 'Sensors']",
        ),
        (
            "blender_manifest.toml",
            lambda: manifest_with("license.*", 'license = ["SPDX:MIT"]'),
            "the licence is not GPL",
        ),
        (
            "blender_manifest.toml",
            lambda: manifest_with("name = .*", 'name = "Sensors for Blender"'),
            "the name contains 'Blender'",
        ),
    ),
    (
        ("blender_manifest.toml", lambda: manifest_with("network.*\n"), "'network': no reason"),
        (
            "blender_manifest.toml",
            lambda: manifest_with("network.*", 'network = "Send readings"\ncamera = "See"'),
            "'camera': not needed",
        ),
    ),
    (
        ("sensor_logic/fetch.py", "import urllib.request\n", "fetch.py imports urllib.request"),
        ("sensor_logic/fetch.py", f"{OFFLINE}from http import client\n", "fetch.py imports http"),
    ),
    (
        ("wheels/LICENSE-paho-mqtt.txt", "", "has no licence beside it"),
        ("wheels/other-1-py3-none-any.whl", "", "is not both in the zip and in the manifest"),
        (
            "blender_manifest.toml",
            lambda: manifest_with(r".*\(paho-mqtt\).*\n"),
            "does not name the authors of paho-mqtt",
        ),
    ),
    (
        ("angen_addon/__main__.py", "", "__main__.py is for another way to run"),
        ("operators/more.py", "import sys\nsys.modules['a'] = sys\n", "changes sys.modules"),
        ("operators/more.py", "START = 'import sys; sys.path.insert(0, 1)'\n", "changes sys.path"),
    ),
    (("angen_addon/more.py", "from angen_sensors import parts\n", "more.py imports angen_"),),
    (
        ("sensor_logic/fast.so", "", "fast.so does not belong into a zip"),
        ("sensor_logic/.hidden", "", ".hidden does not belong into a zip"),
        ("notes.txt", "", "notes.txt does not belong into a zip"),
        ("docs/index.py", "", "docs/index.py is for developers"),
    ),
    (("README_USERS.md", "make zip; EEVEE --jobs\n", "tells users 'make'"),),
    (("operators/more.py", "import subprocess\n", "starts a process that README_USERS.md"),),
    (("operators/more.py", "A = 1\n", "nothing imports operators/more.py"),),
    (
        ("operators/more.py", f"{OFFLINE}return eval('1')\n", "operators/more.py calls eval"),
        ("operators/more.py", f"{OFFLINE}os.system('ls')\n", "more.py calls os.system"),
        ("operators/more.py", f"{OFFLINE}run('ls', shell=True)\n", "more.py calls run"),
    ),
    (("operators/more.py", f"{OFFLINE}print(context)\n", "operators/more.py prints"),),
    (
        (
            "operators/more.py",
            f"{OFFLINE}context.window_manager.keyconfigs.user.keymaps.clear()\n",
            "more.py takes keymaps",
        ),
    ),
    (
        ("operators/more.py", "class Door(bpy.types.Operator):\n    pass\n", "more.py: Door"),
        ("operators/more.py", "class A:\n    bl_idname = 'door.open'\n", "more.py: door.open"),
        ("operators/more.py", "bpy.types.Object.heat = FloatProperty()\n", "more.py: heat"),
    ),
)


def test_a_zip_of_few_files_breaks_no_rule(few: Path, tmp_path: Path) -> None:
    pack_with(few, tmp_path / "few.zip", "operators/more.py", "A = 1\n", reached=True)
    assert check_release.zip_problems(tmp_path / "few.zip") == []


@pytest.mark.parametrize("number", range(len(BROKEN)))
def test_each_rule_refuses_a_zip_that_breaks_it(number: int, few: Path, tmp_path: Path) -> None:
    assert len(BROKEN) == len(check_release.RULES)
    rule, _ = check_release.RULES[number]
    for name, text, told in BROKEN[number]:
        made = text() if callable(text) else text
        pack_with(few, tmp_path / "bad.zip", name, made, reached="can be imported" not in rule)
        (line,) = check_release.zip_problems(tmp_path / "bad.zip")
        assert told in line and line.endswith(f"(rule: {rule})")


def test_hidden_files_stay_out_of_the_zip_wherever_they_are() -> None:
    patterns = MANIFEST["build"]["paths_exclude_pattern"]
    for name in (".DS_Store", "panels/.DS_Store", ".idea/", "residents/body/.idea/"):
        assert build_zip._is_excluded(name, patterns), name
    assert not build_zip._is_excluded("panels/table.py", patterns)


def test_both_ways_give_the_same_files_and_blender_takes_what_is_packed_without_it(
    tmp_path: Path,
) -> None:
    tool = build_zip.extension_tool()
    if tool is None:
        pytest.skip("there is no Blender here")
    packed = build_zip.build(tmp_path / "packed", None)
    checked = build_zip.build(tmp_path / "checked", tool)
    assert packed.read_bytes() == checked.read_bytes()
    made = tmp_path / "made.zip"
    paths = ["--source-dir", str(ROOT), "--output-filepath", str(made)]
    subprocess.run([*tool, "build", *paths], capture_output=True, check=True)
    assert build_zip.contents(made) == build_zip.contents(packed)


def lines(path: Path) -> bytes:
    return path.read_bytes().replace(b"\r\n", b"\n")


def test_each_system_gives_the_same_zip_to_the_byte(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A checkout as git makes it on Windows, other times, and what Python notes of the system."""
    tracked_files()
    copy = tmp_path / "checkout"
    windows = ["-c", "core.autocrlf=true", "-c", "core.eol=crlf"]
    command = ["git", *windows, "checkout-index", "--all", f"--prefix={copy.as_posix()}/"]
    subprocess.run(command, cwd=ROOT, check=True)
    names = [name for name in build_zip.shipped(MANIFEST) if (copy / name).is_file()]
    assert len(names) > 300
    build_zip.pack(tmp_path / "here.zip", names)
    for name in names:
        # What is changed here and not staged.
        if lines(ROOT / name) != lines(copy / name):
            shutil.copy(ROOT / name, copy / name)
    made = zipfile.ZipInfo.__init__

    def made_on_windows(self: zipfile.ZipInfo, *arguments: Any, **options: Any) -> None:
        made(self, *arguments, **options)
        self.create_system = 0

    monkeypatch.setattr(zipfile.ZipInfo, "__init__", made_on_windows)
    # Windows's Python 3.14 has another zlib, which packs otherwise.
    packer = zlib.compressobj
    monkeypatch.setattr(zlib, "compressobj", lambda _level, *more: packer(1, *more))
    build_zip.pack(tmp_path / "there.zip", names, copy)
    assert (tmp_path / "here.zip").read_bytes() == (tmp_path / "there.zip").read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="has no make")
def test_make_zip_needs_no_blender_and_fetches_nothing(tmp_path: Path) -> None:
    if not shutil.which("make"):
        pytest.skip("needs make")
    copy = tmp_path / "checkout"
    for name in tracked_files():
        if not name.endswith(".blend"):
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, copy / name)
    tools = tmp_path / "tools"
    tools.mkdir()
    for program in ("make", "sh", "env", "cat"):
        (tools / program).symlink_to(shutil.which(program) or "")
    # Without Blender beside it, which a virtual environment's Python would find.
    (tools / "python3").symlink_to(Path(sys.executable).resolve())
    done = subprocess.run(
        ["make", "zip"],
        cwd=copy,
        env={"PATH": str(tools), "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "packed without Blender's extension tool" in done.stderr
    assert not list(copy.glob(".venv*"))
    (made,) = (copy / "dist").glob("*.zip")
    packed = build_zip.build(tmp_path / "packed", None)
    assert sorted(zipfile.ZipFile(made).namelist()) == sorted(zipfile.ZipFile(packed).namelist())


def test_what_blender_would_refuse_is_refused() -> None:
    for key, value in (
        ("id", "Ängen"), ("version", "1"), ("tagline", "Ends in a dot."), ("license", ["GPL"]),
        ("permissions", {"files": "x" * 65}),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=key[:-1]):
            build_zip.check({**MANIFEST, key: value})


INSTALLED = """
import os, sys
import bpy, addon_utils
addon = addon_utils.enable("bl_ext.user_default.angen_sensors", default_set=True)
assert addon and os.path.realpath(addon.__file__).startswith(os.path.realpath(sys.argv[1]))
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command
bpy.ops.wm.open_mainfile(filepath=sys.argv[2])
options = ["--frames", "1:24", "--sensor", "PIR kitchen", "--sensor", "Switch entrance"]
status = run_command(["simulate", *options, "--events", sys.argv[1] + "/events.csv"])
addon_utils.disable("bl_ext.user_default.angen_sensors")
assert not hasattr(bpy.types.Object, "angen_sensor")
sys.exit(status)
"""


@pytest.mark.parametrize(
    "built",
    ["without Blender", pytest.param("by Blender's tool", marks=pytest.mark.slow)],
    indirect=True,
)
def test_the_zip_runs_in_an_empty_blender(built: Path, tmp_path: Path) -> None:
    simulates_the_home(zipfile.ZipFile(built), tmp_path)


def test_the_sensors_run_without_the_residents(tmp_path: Path) -> None:
    """An extension of the sensors alone."""
    names = [n for n in build_zip.shipped(MANIFEST) if not n.startswith("residents/")]
    build_zip.pack(tmp_path / "sensors.zip", names)
    build_zip.check_zip(tmp_path / "sensors.zip")
    simulates_the_home(zipfile.ZipFile(tmp_path / "sensors.zip"), tmp_path)


def simulates_the_home(packed: zipfile.ZipFile, tmp_path: Path) -> None:
    pytest.importorskip("bpy", reason="needs Blender's Python module (bpy)")
    packed.extractall(tmp_path / "extensions/user_default/angen_sensors")
    done = subprocess.run(
        [sys.executable, "-c", INSTALLED, str(tmp_path), str(ROOT / "sample_blends/angen.blend")],
        env={
            **{name: os.environ[name] for name in ("SYSTEMROOT",) if name in os.environ},
            "PATH": "",
            "HOME": str(tmp_path),
            "BLENDER_USER_RESOURCES": str(tmp_path),
        },
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "events.csv").read_text(encoding="utf-8").splitlines()) > 1


def test_what_the_pages_name_is_among_the_downloads(tmp_path: Path) -> None:
    """So that nobody needs the repository for the first steps."""
    root, _, patterns = build_downloads.ZIPS["homes"]
    names = set(build_downloads.files_of(root, patterns))
    assert {"sample_blends/angen.blend", "sample_blends/week.toml", "LICENSE"} <= names
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    named = set(
        re.findall(r"\b(?:sample_blends|docs/examples)/[\w/]+\.(?:blend|toml|json)\b", text)
    )
    assert len(named) > 5 and named <= names
    for name in ("one", "other"):
        build_zip.pack(tmp_path / name, sorted(names), root)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()


def test_a_download_that_was_not_built_is_told(tmp_path: Path, monkeypatch: Any) -> None:
    parts = {"assets": (tmp_path / "none", "make assets", ("**/*",))}
    monkeypatch.setattr(build_downloads, "ZIPS", parts)
    with pytest.raises(SystemExit, match="run `make assets` first"):
        list(build_downloads.build(tmp_path))


# Joined here, so that this file does not contain the texts that it searches for.
MACHINE = re.compile(
    rb"(?<![\w.~-])/(?:work|farm|root|home/\w+|opt/v\d+|tmp/\w+)/"
    rb"|\b(?:pypi|pythonhosted|npmjs|debian|ubuntu)\." + rb"(?:org|com)\b"
)


def test_no_tracked_file_names_a_machine_or_a_registry() -> None:
    found = [
        f"{name}: {match.group().decode()}"
        for name in tracked_files()
        if name != "LICENSE"
        for match in MACHINE.finditer((ROOT / name).read_bytes())
    ]
    assert not found


# Releases


WEBSITE = 'website = "https://x.org/"\n'


@pytest.fixture
def release(tmp_path: Path) -> Path:
    """Return the files that the check of a release reads, of version 1.2.3."""
    (tmp_path / "blender_manifest.toml").write_text('version = "1.2.3"\n' + WEBSITE)
    (tmp_path / "pyproject.toml").write_text('[project]\nversion = "1.2.3"\n')
    (tmp_path / "mkdocs.yml").write_text("site_name: X\nsite_url: https://x.org/\n")
    (tmp_path / "CITATION.cff").write_text(
        "cff-version: 1.2.0\nversion: 1.2.3\ndate-released: 2026-12-01\n"
    )
    (tmp_path / "CHANGELOG.md").write_text(
        "# Changelog\n\n## 1.2.3, 2026-12-01\n\n- New.\n\n## 1.2.2, 2026-11-01\n\n- Old.\n"
    )
    return tmp_path


def test_a_release_that_fits_together_has_its_notes(release: Path) -> None:
    assert check_release.problems("v1.2.3", release) == []
    assert check_release.notes("1.2.3", release) == "- New."


@pytest.mark.parametrize(
    ("file", "text", "told"),
    [
        (
            "blender_manifest.toml",
            'version = "1.2.2"\n' + WEBSITE,
            "blender_manifest.toml has 1.2.2",
        ),
        ("blender_manifest.toml", 'version = "1.2.3"\n', "the manifest's website is not"),
        ("pyproject.toml", '[project]\nversion = "1.3.0"\n', "pyproject.toml has 1.3.0"),
        ("CITATION.cff", "date-released: 2026-12-01\n", "CITATION.cff has no version"),
        ("CITATION.cff", "version: 1.2.3\n", "CITATION.cff has no date, CHANGELOG.md 2026-12-01"),
        ("CHANGELOG.md", "## 1.2.3, not released yet\n\n- New.\n", "CHANGELOG.md has no section"),
        ("CHANGELOG.md", "## 1.2.3, 2026-12-01\n", "CHANGELOG.md has no section"),
    ],
)
def test_a_release_that_does_not_fit_together_is_refused(
    release: Path, file: str, text: str, told: str
) -> None:
    (release / file).write_text(text)
    (line,) = check_release.problems("v1.2.3", release)
    assert line.startswith(told)


def test_a_missing_file_or_a_zip_that_cannot_be_built_is_one_line(
    release: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (release / "CITATION.cff").unlink()
    assert check_release.problems("v1.2.3", release) == ["CITATION.cff is missing"]
    monkeypatch.setattr(build_zip, "shipped", lambda manifest: ["__init__.py", build_zip.MANIFEST])
    (line,) = check_release.built_problems()
    assert line.endswith("LICENSE is missing or broken")


def test_a_tag_of_another_form_is_refused(release: Path) -> None:
    assert check_release.problems("1.2", release) == ["the tag 1.2 is not of the form v1.2.3"]
