# SPDX-License-Identifier: GPL-3.0-or-later
"""What Windows and macOS do otherwise than Linux, imitated one behaviour at a time.

Each test has the name of the behaviour, and holds on all systems. tests/blender/test_systems.py has
those that need Blender.
"""

import ast
import builtins
import importlib
import io
import os
import re
import subprocess
import sys
import types
import unicodedata
import zoneinfo
from pathlib import Path

import pytest
from angen_sensors.angen_addon.__main__ import main
from angen_sensors.angen_addon.commands import convert
from angen_sensors.angen_addon.process.standalone import unreadable
from angen_sensors.sensor_logic.logs import files
from angen_sensors.sensor_logic.logs.error import AngenError, InputError
from angen_sensors.sensor_logic.logs.files import (
    check_folder,
    check_target,
    file_names,
    write_files,
)
from angen_sensors.sensor_logic.logs.log import HEADER, for_spreadsheets, to_csv

ROWS = [("0", "1", "0"), ("5", "121", "1"), ("9", "217", "0")]
ROOT = Path(__file__).resolve().parents[2]
LOG = to_csv(HEADER, [(time, frame, "Küche", "PIR", "moved", value) for time, frame, value in ROWS])


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def terminal(monkeypatch):
    """Give standard output a code page and the line ends of Windows; return what is written."""

    def open_as(code_page):
        written = io.BytesIO()
        stream = io.TextIOWrapper(written, encoding=code_page, newline="\r\n")
        monkeypatch.setattr(sys, "stdout", stream)
        return written

    return open_as


@pytest.mark.parametrize("code_page", ["cp437", "cp1252"])
def test_standard_output_with_line_ends_and_code_page_of_windows(terminal, code_page, tmp_path):
    path = tmp_path / "Küche → 1.csv"
    path.write_bytes(LOG.encode())
    written = terminal(code_page)
    assert main(["compare", str(path), str(path)]) == 0
    text = written.getvalue().decode()
    assert "Küche → 1" in text and "\r" not in text


@pytest.fixture
def opened(monkeypatch):
    """Let the files in the returned set be open in another program, as Windows has it."""
    found = set()

    def guarded(move):
        def run(old, new, *rest, **options):
            if found & {Path(old), Path(new)}:
                raise PermissionError(13, "Permission denied", str(old), 32, str(new))
            return move(old, new, *rest, **options)

        return run

    monkeypatch.setattr(os, "replace", guarded(os.replace))
    monkeypatch.setattr(os, "rename", guarded(os.rename))
    return found


def test_of_several_files_none_is_new_where_one_is_open_in_another_program(tmp_path, opened):
    names = ("a.csv", "b.csv", "c.csv")
    for name in names:
        (tmp_path / name).write_text("old")
    opened.add(tmp_path / "b.csv")
    with pytest.raises(AngenError, match=r"another program has .*b\.csv open: close it there"):
        write_files({tmp_path / name: "new" for name in names})
    assert set(contents(tmp_path)) == set(names)
    assert set(contents(tmp_path).values()) == {b"old"}
    opened.clear()
    write_files({tmp_path / name: "new" for name in names})
    assert set(contents(tmp_path).values()) == {b"new"}


@pytest.mark.parametrize("verb", ["convert", "learn"])
def test_an_output_that_names_the_input_in_other_case(tmp_path, angen, verb):
    """On macOS both are one file, as they are here by a link."""
    path, out = tmp_path / "log.csv", tmp_path / "LOG.csv"
    path.write_bytes(LOG.encode())
    if not out.exists():
        os.link(path, out)
    options = ["--format", "events"] if verb == "convert" else []
    status, _, err = angen(verb, path, *options, "--out", out)
    assert status == 2 and re.search(r"LOG\.csv is also read.*; give another name", err)
    assert path.read_bytes() == LOG.encode()


def test_a_new_file_that_a_virus_scanner_opens_for_a_moment(tmp_path, monkeypatch):
    scans, replace = [1, 2], os.replace

    def scanned(old, new):
        if scans:
            scans.pop()
            raise PermissionError(13, "Permission denied", str(old), 32, str(new))
        replace(old, new)

    monkeypatch.setattr(files, "SYSTEM", "nt")
    monkeypatch.setattr(files, "PATIENCE_S", 0.0)
    monkeypatch.setattr(os, "replace", scanned)
    write_files({tmp_path / "a.csv": "new"})
    assert contents(tmp_path) == {"a.csv": b"new"}
    scans.extend(range(99))
    with pytest.raises(AngenError, match=r"cannot write .*a\.csv: Permission denied"):
        write_files({tmp_path / "a.csv": "newer"})
    assert contents(tmp_path) == {"a.csv": b"new"}


def test_a_file_open_in_another_program_is_told_before_the_work(tmp_path, opened, angen):
    path, out = tmp_path / "log.csv", tmp_path / "out.xes"
    path.write_bytes(LOG.encode())
    out.write_text("old")
    opened.add(out)
    status, _, err = angen("convert", path, "--format", "xes", "--out", out)
    assert (status, err.count("\n")) == (1, 1)
    assert f"--out: another program has {out} open" in err
    check_target(path, "--out")


def test_a_folder_that_cannot_be_opened_as_a_file(tmp_path, monkeypatch):
    """Windows calls it a lack of permission."""

    def refuse(path, *_, **__):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(builtins, "open", refuse)
    monkeypatch.setattr(io, "open", refuse)
    with pytest.raises(InputError, match=f"cannot read {re.escape(str(tmp_path))}: Is a directory"):
        files.read_text(tmp_path)
    with pytest.raises(InputError, match="Permission denied"):
        files.read_text(tmp_path / "log.csv")
    assert unreadable(tmp_path) == f"{tmp_path} is a folder; give a blend file"


@pytest.fixture
def results(monkeypatch):
    """Return the module of a study's results, without the locks that Windows lacks."""
    for package in ("pandas", "distributed"):
        pytest.importorskip(package)
    module = importlib.import_module("angen_sensors.studies.results")
    monkeypatch.setattr(module, "fcntl", None)
    return module


def test_two_studies_that_write_into_one_folder(tmp_path, opened, results):
    with results.Store(tmp_path / "out"):
        opened.add(tmp_path / "out" / "runs.jsonl")
        with pytest.raises(InputError, match=r"another process writes a study into .*out"):
            results.Store(tmp_path / "out")


def test_a_table_of_a_study_that_is_open_in_another_program_meanwhile(
    tmp_path, opened, results, monkeypatch, capsys
):
    """As somebody looks at it in Excel, the runs go on."""
    engine = importlib.import_module("angen_sensors.studies.engine")
    study = importlib.import_module("angen_sensors.studies.study")
    (tmp_path / "home.blend").write_bytes(b"BLENDER")
    (tmp_path / "s.toml").write_text('home = "home.blend"\n[vary]\n"PIR.rays" = [5, 10, 20]\n')
    home = engine.StudiedHome("home.blend", {"PIR": "PIR"}, "sha256:0")

    class Done:
        status = "finished"

        def __init__(self, value):
            self.result = lambda: value

    def submit(_client, name, argument):
        if name == "runs.examine":
            return Done(home)
        return Done([engine.RunResult(task.digest, {"events": 1}, 0.1) for task in argument])

    client = types.SimpleNamespace(nthreads=lambda: {"one": 1}, status="running")
    monkeypatch.setattr(engine, "check_workers", lambda _: {"numpy": "2"})
    monkeypatch.setattr(engine, "send_files", lambda *_: None)
    monkeypatch.setattr(engine, "submit", submit)
    monkeypatch.setattr(engine.distributed, "wait", lambda *_, **__: None)
    monkeypatch.setattr(engine, "TABLES_S", -1.0)
    table = tmp_path / "out" / "results.csv"
    table.parent.mkdir()
    table.write_text("looked at")
    opened.add(table)
    with results.Store(tmp_path / "out") as store:
        driver = engine.Driver(study.read(tmp_path / "s.toml"), store, client)
        driver.run(lambda *_: None)
        assert driver.kept() == 3
        with pytest.raises(InputError, match=r"another program has .*results\.csv open"):
            driver.write_tables()
        opened.clear()
        driver.write_tables()
    assert table.read_text().count("\n") == 4
    assert capsys.readouterr().err.count("results.csv open") == 1


def test_workers_of_a_study_start_in_the_home_of_a_user_with_an_umlaut(tmp_path, results):
    """Dask writes their first code in the code page of Windows, and Python reads it as UTF-8."""
    preload = importlib.import_module("angen_sensors.studies.engine").PRELOAD
    module = tmp_path / "Jörg" / "standalone.py"
    module.parent.mkdir()
    module.write_text("def load_extension():\n    print('loaded')\n", encoding="utf-8")
    script = tmp_path / "script.py"
    script.write_text(preload.format(str(module)), encoding="cp1252")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True)
    assert done.stdout == "loaded\n", done.stderr


def test_a_path_too_long_for_the_system_is_told_before_the_work(tmp_path):
    """Windows takes 259 characters, Linux 4095 bytes: a temporary file needs more than a target."""
    folder = tmp_path
    try:
        limit = os.pathconf(tmp_path, "PC_PATH_MAX")
    except (AttributeError, OSError, ValueError):
        pytest.skip("the system tells no limit")
    while len(str(folder)) < limit - 220:
        folder /= "f" * 200
    folder /= "f" * (limit - len(str(folder)) - 20)
    folder.mkdir(parents=True)
    (folder / "a.csv").write_text("fits")
    with pytest.raises(InputError, match=r"--events: cannot write in .*: File name too long"):
        check_folder(folder, "--events")


def test_a_path_of_250_characters(tmp_path):
    folder = tmp_path / "Jörg Ängström" / ("f" * (250 - len(str(tmp_path / "Jörg Ängström")) - 12))
    folder.mkdir(parents=True)
    path = folder / "events.csv"
    assert len(str(path)) == 250
    check_folder(folder, "--events")
    write_files({path: "new"})
    assert contents(folder) == {"events.csv": b"new"}


def test_names_equal_but_for_how_accents_are_encoded_or_for_case():
    composed = unicodedata.normalize("NFC", "Küche")
    names = [composed, unicodedata.normalize("NFD", "Küche"), composed.upper()]
    found = file_names(names)
    assert list(found) == names
    same = {unicodedata.normalize("NFD", name).casefold() for name in found.values()}
    assert len(same) == 3


def test_names_of_255_bytes_are_shortened(tmp_path):
    names = ["ä" * 127 + "a", "ä" * 127 + "b", "c" * 255]
    found = file_names(names)
    assert len(set(found.values())) == 3
    write_files({tmp_path / name: "" for name in found.values()})
    assert all(name[:50] == sensor[:50] for sensor, name in found.items())
    assert max(len(name.encode()) for name in found.values()) <= 255


def test_a_zone_where_the_system_has_no_list_of_time_zones(monkeypatch):
    before = zoneinfo.TZPATH
    zoneinfo.reset_tzpath([])
    zoneinfo.ZoneInfo.clear_cache()
    # The package tzdata, which the project installs on Windows, and what of it is loaded.
    for name in ["tzdata", *(name for name in sys.modules if name.startswith("tzdata."))]:
        monkeypatch.setitem(sys.modules, name, None)
    try:
        with pytest.raises(InputError, match="no list of time zones: pip install tzdata"):
            convert._zone("Europe/Stockholm")
    finally:
        zoneinfo.reset_tzpath(before)
    with pytest.raises(InputError, match="'Europe/Atlantis' is unknown: give one such as"):
        convert._zone("Europe/Atlantis")


@pytest.mark.parametrize(
    ("comma", "expected"),
    [
        (False, '\ufefftime_s,sensor\r\n0.500000,Küche\r\n-1.5,"a,b"\r\n'),
        (True, "\ufefftime_s;sensor\r\n0,500000;Küche\r\n-1,5;a,b\r\n"),
    ],
)
def test_a_spreadsheet_in_german(comma, expected):
    """It takes a text without a mark for Windows-1252, and 0.5 for a date."""
    pieces = ["time_s,sensor\r\n", '0.500000,Küche\r\n-1.5,"a,b"\r\n']
    assert "".join(for_spreadsheets(pieces, comma)) == expected


@pytest.mark.parametrize("verb", ["compare", "convert"])
def test_a_log_that_windows_powershell_has_redirected(tmp_path, angen, verb):
    """Its > writes UTF-16, with a mark."""
    path = tmp_path / "log.csv"
    path.write_bytes(LOG.encode("utf-16"))
    out = [path] if verb == "compare" else ["--format", "xes", "--out", tmp_path / "out"]
    status, _, err = angen(verb, path, *out)
    assert (status, err) == (
        2,
        f"angen: {path} is in UTF-16, as > in Windows PowerShell writes: "
        "save it as UTF-8, or write it by an option such as --events or --out\n",
    )


def test_a_file_that_is_read_only_is_told(tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    path.write_text("old")
    monkeypatch.setattr(files, "SYSTEM", "nt")
    check_target(path, "--events")
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(AngenError, match=r"--events: .*a\.csv is read-only"):
        check_target(path, "--events")


def unnamed_encodings(tree):
    """Yield the lines of calls that read or write text in the encoding of the system."""
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call):
            continue
        name = getattr(call.func, "attr", getattr(call.func, "id", ""))
        given = {keyword.arg: keyword.value for keyword in call.keywords}
        # Path.read_text takes it as its first argument, Path.write_text as its second.
        at = {"read_text": 0, "write_text": 1}.get(name)
        if at is not None and len(call.args) <= at and "encoding" not in given:
            yield call.lineno
        has_text = {"text", "universal_newlines"} & given.keys()
        if name in {"run", "Popen", "check_output"} and has_text and "encoding" not in given:
            yield call.lineno


@pytest.mark.parametrize(
    "folder",
    [
        *("angen_addon", "operators", "panels", "residents", "sensor_logic", "studies"),
        *("docs", "sample_blends", "scripts"),
    ],
)
def test_no_text_is_read_or_written_in_the_code_page_of_windows(folder):
    """Lint asks for the encoding of `open`; here are files of paths and output of processes."""
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line in unnamed_encodings(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not found
