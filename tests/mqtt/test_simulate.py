# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen simulate --mqtt`: what it sends is what it logs."""

from __future__ import annotations

import csv
import json
import signal

import pytest

pytest.importorskip("bpy", reason="needs Blender's Python module (bpy)")
BLENDS = "sample_blends"


def told(events: str) -> dict[str, list[str]]:
    """What the log says of each field, as `sensor/field`, one value after the other."""
    found: dict[str, list[str]] = {}
    for row in csv.DictReader(events.splitlines()):
        words = {"moved", "lit", "pressed", "valid"}
        value = ("OFF", "ON")[int(row["value"])] if row["field"] in words else row["value"] or "–"
        found.setdefault(f"{row['sensor']}/{row['field']}", []).append(value)
    return found


@pytest.mark.parametrize(
    ("blend", "options"), [("light_control", ["--speed", 20]), ("pressure", ["--speed", "max"])]
)
def test_what_is_sent_is_what_is_logged(broker, angen, blend, options) -> None:
    with broker.listen() as listener:
        home = f"{BLENDS}/{blend}.blend"
        options = ["--quiet", "--mqtt", broker.address, *options]
        status, out, err = angen("simulate", home, *options)
        heard = listener.all()
    assert (status, err) == (0, "")
    names = {}
    for topic, payload in heard:
        if topic.endswith("/config"):
            config = json.loads(payload)
            for field, entity in config["cmps"].items():
                names[entity["state_topic"]] = f"{config['dev']['name']}/{field}"
    online = heard.index(("angen/status", "online"))
    assert heard[-1] == ("angen/status", "offline")
    found: dict[str, list[str]] = {}
    for topic, payload in heard[online + 1 : -1]:
        found.setdefault(names[topic], []).append(payload)
    assert found == told(out)
    assert {payload for topic, payload in heard[:online] if topic in names} == {"None"}


def test_ctrl_c_ends_run_and_sending(broker, start, tmp_path) -> None:
    events = tmp_path / "events.csv"
    with broker.listen() as listener:
        home = f"{BLENDS}/light_control.blend"
        run = start("simulate", home, "--quiet", "--mqtt", broker.address, "--events", events)
        listener.until("angen/pir_room/moved", "ON")
        run.send_signal(signal.SIGINT)
        _, err = run.communicate()
        assert listener.all()[-1] == ("angen/status", "offline")
    assert (run.returncode, err) == (1, "angen: interrupted; nothing was written\n")
    assert not events.exists()
