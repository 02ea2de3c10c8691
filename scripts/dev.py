# SPDX-License-Identifier: GPL-3.0-or-later
"""Make environments and run the checks, on any system: what `make` calls, and Windows has no make.

python scripts/dev.py VERB

test [OPTIONS]      the quick tests, with pytest's options; makes the environment first
test-all [OPTIONS]  all tests in one version of Blender
lint                style and types
demo                simulate the sample home and show what its sensors saw
zip                 build the extension's zip in dist/
smoke               run the commands that write to a redirected output and to files, in a folder
                    with spaces and umlauts in its name
venv DIR PURPOSE    make an environment, unless it is complete. PURPOSE is test (Blender as a
                    Python module, and what the tests need), lint, docs or readers (no Blender)
python VERSION ...  print the path of a Python of one of the versions

Variables: PYTHON=COMMAND is the Python to make environments with, BPY=4.2 the version of Blender,
VENV and LINT_VENV the environments' folders. Where no Python fits any Blender module but a Blender
program is on PATH, "test" makes an environment without the module. This file needs Python 3.8.
"""

from __future__ import annotations

import ast
import glob
import hashlib
import importlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parent.parent
WINDOWS = os.name == "nt"
# Blender's module with a numpy that it can use: exact versions for those that CI tests.
BLENDERS = {
    "4.2": ["bpy==4.2.23", "numpy==1.24.4"],
    "4.5": ["bpy==4.5.15", "numpy==1.26.4"],
    "5.2": ["bpy==5.2.3", "numpy==2.5.5"],
}
# The version of Blender that each Python gets by default.
NEWEST = {"3.11": "4.5", "3.13": "5.2"}
ANY = ["3.13", "3.12", "3.11", "3.14"]
# pyadlml reads CASAS only with pandas before 2.2.
PYTHONS = {"lint": ANY, "docs": ANY, "readers": ["3.11", "3.12"]}
QUICK = "not slow and not measured"
LIBRARIES = """\
libgl1 libgomp1 libice6 libsm6 libx11-6 libxfixes3 libxi6 libxkbcommon0 libxrender1 libxxf86vm1"""
TYPED = ("sensor_logic", "angen_addon", "operators", "panels", "residents", "studies", "parts")
HELP = """\
Blender's Python module exists for Python 3.13 (Blender 5.1, 5.2) and 3.11 (Blender 4.2 to 5.0).
Any one of these helps:
  - Debian 13, Ubuntu 25.04:   apt install python3.13-venv
  - Debian 12, Ubuntu 22.04:   apt install python3.11-venv
  - Windows:                   winget install Python.Python.3.13
  - macOS:                     brew install python@3.13
  - elsewhere:                 pyenv install 3.13, or: uv python install 3.13
  - one that is not on PATH:   set the variable PYTHON to /path/to/python3.13
  - Blender 4.2 or newer as the command 'blender', beside Python 3.12 or 3.14 and its venv module"""


class NoPython(Exception):
    """There is no suitable Python; `is_incomplete` if one lacks what makes environments."""

    def __init__(self, text: str = "", is_incomplete: bool = False) -> None:
        super().__init__(text)
        self.is_incomplete = is_incomplete


def fail(text: str) -> NoReturn:
    sys.exit("dev: " + text)


def python_of(venv: Path) -> Path:
    """Return the path of an environment's Python."""
    return venv / "Scripts" / "python.exe" if WINDOWS else venv / "bin" / "python"


def answer(command: list[str], code: str) -> str:
    """Return what a Python prints for a line of code; "" if it fails or does not exist."""
    try:
        # A pyenv shim of a version that is not active exists and fails, so run the command.
        done = subprocess.run(
            [*command, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
    except OSError:
        return ""
    return "" if done.returncode else done.stdout.decode().strip()


def version_of(*command: str) -> str:
    """Return the version of a Python, as 3.13; "" if it does not run."""
    return answer([*command], 'import sys; print("%d.%d" % sys.version_info[:2])')


def find_python(versions: list[str]) -> str:
    """Return the path of a Python of one of the versions; raise `NoPython` if there is none.

    If the variable PYTHON names a command, only that is tried. Otherwise those on PATH, of the
    launcher of Windows, and of pyenv.
    """
    chosen = os.environ.get("PYTHON")
    candidates = [[chosen]] if chosen else [["python" + version] for version in versions]
    if not chosen:
        candidates += [["py", "-" + version] for version in versions if WINDOWS]
        candidates += [["python3"], ["python"], [sys.executable]]
        pyenv = os.environ.get("PYENV_ROOT") or str(Path.home() / ".pyenv")
        for version in versions:
            candidates += [[path] for path in glob.glob(f"{pyenv}/versions/{version}.*/bin/python")]
    incomplete = ""
    for command in candidates:
        version = version_of(*command)
        if version not in versions:
            continue
        # In ASCII: a user's name in the path may have letters of another encoding than that here.
        found = answer(command, "import ensurepip, venv, sys; print(ascii(sys.executable))")
        if found:
            return str(ast.literal_eval(found))
        incomplete = incomplete or version
    if incomplete:
        raise NoPython(
            f"Python {incomplete} is here, but not what it makes virtual environments with; on "
            f"Debian and Ubuntu:\n    apt install python{incomplete}-venv",
            is_incomplete=True,
        )
    raise NoPython


def wanted_python(purpose: str, bpy: str) -> tuple[str, str, bool]:
    """Return a Python for an environment, its version of Blender, and whether it goes without.

    `purpose` is that of the environment, `bpy` the wanted version of Blender or "". Exit if there
    is no such Python.
    """
    if bpy:
        versions = ["3.11"] if bpy[:2] == "4." or bpy == "5.0" else ["3.13"]
    else:
        versions = PYTHONS.get(purpose, ["3.13", "3.11"])
    try:
        python = find_python(versions)
        if purpose != "test":
            return python, "", False
        return python, bpy or NEWEST[version_of(python)], False
    except NoPython as error:
        if error.is_incomplete:
            fail(str(error))
    chosen = os.environ.get("PYTHON")
    program = shutil.which("blender")
    if purpose == "test" and not bpy and not chosen and program:
        try:
            python = find_python(["3.12", "3.14"])
        except NoPython as error:
            if error.is_incomplete:
                fail(str(error))
        else:
            print(
                f"No Python 3.13 or 3.11 here: {program} will be used instead of Blender's module.",
                file=sys.stderr,
            )
            return python, "", True
    here = f" (PYTHON={chosen})" if chosen else ""
    text = f"No suitable Python here{here}: it must be {' or '.join(versions)}."
    fail(f"{text}\n{HELP}" if purpose == "test" else text)


def content(path: Path) -> str:
    return path.read_text(encoding="utf-8").strip() if path.is_file() else ""


def requirements_of(purpose: str) -> Path:
    return ROOT / "scripts" / f"requirements-{purpose}.txt"


def stamp_of(purpose: str, bpy: str) -> str:
    """Return the text in an environment's stamp; if it changes, the environment is made again."""
    recipe = requirements_of(purpose).read_bytes() + repr(sorted(BLENDERS.items())).encode()
    return f"{purpose} {bpy} {hashlib.sha256(recipe).hexdigest()[:12]}"


def make_venv(venv: Path, purpose: str, bpy: str = "") -> Path:
    """Make an environment, unless it exists and is complete, and return its Python.

    Parameters
    ----------
    venv
        The folder of the environment.
    purpose
        What it is for: the name of a file of requirements.
    bpy
        The version of Blender as a Python module, for tests; by default the newest that fits.
    """
    requirements = requirements_of(purpose)
    own, stamp = python_of(venv), stamp_of(purpose, bpy)

    def is_ready(stamp: str) -> bool:
        return content(venv / "ready") == stamp and bool(version_of(str(own)))

    chosen = os.environ.get("PYTHON")
    fits = not chosen or version_of(chosen) == version_of(str(own))
    if fits and is_ready(stamp):
        return own
    python, blender, without = wanted_python(purpose, bpy)
    stamp += " without bpy" if without else ""
    if is_ready(stamp):
        return own
    # Two stamps, each written last, so that half an environment never counts as complete:
    # "installed", and "ready" once Blender's module starts, which may need system libraries.
    installed = f"{stamp}, Python {version_of(python)}"
    if content(venv / "installed") != installed or not version_of(str(own)):
        packages = BLENDERS.get(blender, [f"bpy=={blender}.*"]) if blender else []
        packages += ["numpy"] if without else []
        what = f" with Blender {blender} as a module (350 MB to fetch, once)" if blender else ""
        print(f"Making {venv} for {python}{what} ...", file=sys.stderr)
        shutil.rmtree(venv, ignore_errors=True)
        subprocess.run([python, "-m", "venv", str(venv)], check=True)
        pip = [str(own), "-m", "pip", "install", "-qq", "--disable-pip-version-check"]
        if subprocess.run([*pip, "-r", str(requirements), *packages]).returncode:
            names = " and ".join(map(str, [requirements, *packages]))
            fail(f"could not install {names}; pip's message is above")
        (venv / "installed").write_text(installed, encoding="utf-8")
    if blender and subprocess.run([str(own), "-c", "import bpy"]).returncode:
        fail(
            "Blender's module does not start here. On Debian and Ubuntu it needs:\n"
            f"    apt install {LIBRARIES}"
        )
    (venv / "ready").write_text(stamp, encoding="utf-8")
    return own


def link_folder(at: Path, to: Path) -> None:
    """Make a link to a folder; on Windows without the right to make links, a junction."""
    try:
        at.symlink_to(to, target_is_directory=True)
    except OSError:
        if not WINDOWS:
            raise
        importlib.import_module("_winapi").CreateJunction(str(to), str(at))


def run(*command: object, **variables: str) -> None:
    """Run a command in the project's folder; exit with its status if it fails."""
    done = subprocess.run(list(map(str, command)), cwd=str(ROOT), env={**os.environ, **variables})
    if done.returncode:
        sys.exit(done.returncode)


def environment() -> tuple[Path, str, str]:
    """Return the environment of the tests: its folder, its purpose, its version of Blender."""
    bpy = os.environ.get("BPY", "")
    return ROOT / os.environ.get("VENV", ".venv" + ("-" + bpy if bpy else "")), "test", bpy


def test(options: list[str], chosen: str = QUICK) -> None:
    """Run the tests that fit pytest's expression `chosen`."""
    python = make_venv(*environment())
    shared = ["-n", "auto", "--maxprocesses", "4", "--dist", "worksteal"]
    # The tests' own files are in UTF-8, also on Windows; a test holds the code to naming encodings.
    run(python, "-m", "pytest", *shared, "-m", chosen, *options, PYTHONUTF8="1")


def lint() -> None:
    """Check style and types.

    The modules import each other as parts of one package, as in Blender. mypy sees that package
    under the name angen_sensors, whatever the checkout's folder is called.
    """
    python = make_venv(ROOT / os.environ.get("LINT_VENV", ".venv-lint"), "lint")
    ruff = [python, "-m", "ruff", "check", "--output-format", "concise"]
    run(*ruff, ".")
    # Whether each file's encoding is given, since Windows has another one: a rule in preview.
    run(*ruff, "--preview", "--select", "PLW1514", ".")
    run(python, "-m", "ruff", "format", "--check", ".")
    types = ROOT / ".types"
    types.mkdir(exist_ok=True)
    if not (types / "angen_sensors").exists():
        link_folder(types / "angen_sensors", ROOT)
    checked = ["-m", "angen_sensors"]
    for package in TYPED:
        checked += ["-p", "angen_sensors." + package]
    for script in sorted(ROOT.glob("scripts/*.py")):
        checked += ["-m", script.stem]
    run(python, "-m", "mypy", *checked, MYPYPATH=os.pathsep.join([str(types), "scripts"]))


def build_zip() -> None:
    """Build the extension's zip, with any Python that can."""
    try:
        python = find_python(ANY)
    except NoPython:
        python = sys.executable
    run(python, "scripts/build_zip.py", "dist")


def demo() -> None:
    """Simulate the sample home."""
    run(make_venv(*environment()), "scripts/demo.py", PYTHONUTF8="1")


def smoke() -> None:
    """Simulate a home into a redirected output, into a file and into a saved home; compare."""
    python = make_venv(*environment())
    with tempfile.TemporaryDirectory(prefix="angen Jörg Ängström ") as made:
        folder = Path(made)
        home = folder / "Küche 1.blend"
        shutil.copy(ROOT / "sample_blends" / "light_control.blend", home)
        angen = [python, "-m", "angen_addon", "simulate"]
        with open(folder / "redirected.csv", "wb") as output:
            command = list(map(str, [*angen, home, "--quiet"]))
            if subprocess.run(command, cwd=str(ROOT), stdout=output).returncode:
                fail("simulate failed")
        saved = folder / "saved home.blend"
        run(*angen, home, "--quiet", "--events", folder / "events.csv", "--save", saved)
        run(*angen, saved, "--quiet", "--events", folder / "again.csv")
        logs = {name: (folder / f"{name}.csv").read_bytes() for name in ("redirected", "events")}
        if logs["redirected"] != logs["events"]:
            fail("a redirected output is not the file of --events")
        if b"\r\r" in logs["events"] or (folder / "again.csv").read_bytes() != logs["events"]:
            fail("the saved home has other events")
        run(
            python,
            "-m",
            "angen_addon",
            "convert",
            folder / "events.csv",
            "--format",
            "xes",
            "--out",
            folder / "events.xes",
            "--start",
            "2026-03-02",
            "--timezone",
            "Europe/Stockholm",
        )
    print("Redirected, written and saved: the same events.")


def main(arguments: list[str]) -> str | None:
    """Run a verb; return a text if there is none of this name."""
    verb, options = (arguments or [""])[0], arguments[1:]
    plain: dict[str, Callable[[], None]] = {
        "lint": lint,
        "demo": demo,
        "zip": build_zip,
        "smoke": smoke,
    }
    if verb in plain and not options:
        plain[verb]()
    elif verb == "test":
        test(options)
    elif verb == "test-all":
        test(options, "not measured")
    elif verb == "venv" and len(options) == 2:
        make_venv(Path(options[0]), options[1], os.environ.get("BPY", ""))
    elif verb == "python" and options:
        try:
            print(find_python(options))
        except NoPython as error:
            print(error, file=sys.stderr)
            sys.exit(2 if error.is_incomplete else 1)
    else:
        return __doc__
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
