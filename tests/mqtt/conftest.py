# SPDX-License-Identifier: GPL-3.0-or-later
"""A real broker and listener (mosquitto), and the commands that send to that broker.

`make mqtt` fetches mosquitto and runs these tests; where mosquitto is missing they are skipped.
paho-mqtt is that of the extension's zip.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MOSQUITTO = ROOT / "build" / "mosquitto" / "bin"
# Python imports a wheel of pure Python from where it lies.
(PAHO,) = (str(wheel) for wheel in ROOT.glob("wheels/paho_mqtt-*.whl"))
PATIENCE_S = 60.0
LAST = "angen/end-of-test"


@pytest.fixture(scope="session")
def mosquitto() -> Path:
    """Return the folder with mosquitto's programs."""
    return MOSQUITTO


@pytest.fixture(scope="session", autouse=True)
def _needs_a_broker() -> Iterator[None]:
    if "ANGEN_MQTT" not in os.environ and not (MOSQUITTO / "mosquitto_sub").exists():
        pytest.skip("mosquitto is not here: make mqtt")
    sys.path.append(PAHO)
    yield
    sys.path.remove(PAHO)


def until(what, *arguments):
    """Wait until a condition is true."""
    end = time.monotonic() + PATIENCE_S
    while not (found := what(*arguments)):
        assert time.monotonic() < end, f"{what} {arguments} did not come about"
        time.sleep(0.02)
    return found


class Broker:
    """A mosquitto process; `lines` belong to its configuration."""

    def __init__(self, folder: Path, *lines: str) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.folder = folder
        self.access: list[str] = []
        self._config = folder / f"mosquitto_{self.port}.conf"
        # Started by root, it would change to a user who cannot read these files.
        text = [f"listener {self.port} 127.0.0.1", "user root", *lines]
        self._config.write_text("\n".join(text) + "\n")
        self.start()

    @property
    def address(self) -> str:
        return f"localhost:{self.port}"

    def start(self) -> None:
        self.process = subprocess.Popen(
            [MOSQUITTO / "mosquitto", "-c", self._config], stderr=subprocess.DEVNULL
        )
        until(self._answers)

    def stop(self) -> None:
        self.process.kill()
        self.process.wait()

    def _answers(self) -> bool:
        assert self.process.poll() is None, f"mosquitto does not start with {self._config}"
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def publish(self, topic: str, payload: str, *more: str) -> None:
        options = [*self._client("pub"), "-q", "1", "-t", topic, "-m", payload, *more]
        subprocess.run(options, check=True)

    def listen(self) -> Listener:
        return Listener(self, [*self._client("sub"), "-q", "1", "-t", "#", "-F", "%j"])

    def _client(self, name: str) -> list:
        return [MOSQUITTO / f"mosquitto_{name}", "-V", "5", "-p", str(self.port), *self.access]

    def retained(self) -> dict[str, str]:
        """Return the retained messages, by topic."""
        with self.listen() as listener:
            # A message without a payload removes the one before.
            return {topic: payload for topic, payload in dict(listener.all()).items() if payload}


class Listener:
    """A mosquitto_sub that gets all messages from now on, first the retained ones."""

    def __init__(self, broker: Broker, command: list) -> None:
        self._broker = broker
        self._out = broker.folder / f"heard_{time.monotonic_ns()}"
        self._process = subprocess.Popen(command, stdout=self._out.open("w"))
        until(self._is_listening)

    def __enter__(self) -> Listener:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()

    def _is_listening(self) -> bool:
        if any(topic == LAST and text == "begin" for topic, text in self._so_far()):
            return True
        self._broker.publish(LAST, "begin")
        return False

    def _so_far(self) -> list[tuple[str, str]]:
        lines = [json.loads(line) for line in self._out.read_text().split("\n")[:-1]]
        return [(line["topic"], line["payload"]) for line in lines]

    def received(self) -> list[tuple[str, str]]:
        """Return (topic, payload) of each message so far."""
        return [message for message in self._so_far() if message[0] != LAST]

    def until(self, topic: str, payload: str) -> None:
        until(lambda: (topic, payload) in self.received())

    def until_last(self, topic: str, payload: str) -> None:
        until(lambda: self.received()[-1] == (topic, payload))

    def all(self) -> list[tuple[str, str]]:
        """Return the same, with all messages published before this call."""
        self._broker.publish(LAST, "end")
        until(lambda: (LAST, "end") in self._so_far())
        return self.received()


@pytest.fixture
def make_broker(tmp_path):
    """Start brokers, which end with the test."""
    made: list[Broker] = []

    def make(*lines: str) -> Broker:
        made.append(Broker(tmp_path, *lines))
        return made[-1]

    yield make
    for broker in made:
        broker.stop()


@pytest.fixture
def broker(make_broker):
    return make_broker("allow_anonymous true")


@pytest.fixture(scope="session")
def secrets(tmp_path_factory, mosquitto):
    """Return a folder with certificates and a password.

    ca.pem, and other.pem, which signed nothing; server.pem of localhost with its key; the password
    of the user angen, who may not write to `forbidden`.
    """
    folder = tmp_path_factory.mktemp("secrets")
    (folder / "names").write_text("subjectAltName=DNS:localhost")
    new_key = "-newkey rsa:2048 -nodes -keyout"
    for command in (
        f"openssl req -x509 {new_key} ca.key -out ca.pem -subj /CN=ca",
        f"openssl req -x509 {new_key} other.key -out other.pem -subj /CN=other",
        f"openssl req {new_key} server.key -out server.csr -subj /CN=localhost",
        "openssl x509 -req -in server.csr -CA ca.pem -CAkey ca.key -CAcreateserial -extfile names "
        "-out server.pem",
        f"{mosquitto / 'mosquitto_passwd'} -b -c passwords angen geheim-ü",
    ):
        subprocess.run(command.split(), cwd=folder, check=True, capture_output=True)
    (folder / "acl").write_text(
        "user angen\ntopic readwrite angen/#\ntopic readwrite homeassistant/#\n"
    )
    (folder / "password").write_text("geheim-ü\n", encoding="utf-8")
    (folder / "wrong").write_text("geheim-u\n")
    (folder / "empty").write_text("\n")
    return folder


@pytest.fixture
def guarded(make_broker, secrets):
    """Return a broker with TLS that lets in only the user angen."""
    files = {"password_file": "passwords", "acl_file": "acl", "cafile": "ca.pem"}
    files |= {"certfile": "server.pem", "keyfile": "server.key"}
    lines = [f"{option} {secrets / name}" for option, name in files.items()]
    made = make_broker("allow_anonymous false", *lines)
    made.access = ["--cafile", secrets / "ca.pem", "-h", "localhost"]
    made.access += ["-u", "angen", "-P", "geheim-ü"]
    return made


@pytest.fixture
def start(tmp_path):
    """Start a command of `angen`; the process ends with the test."""
    running: list[subprocess.Popen[str]] = []

    def run(*arguments: object, **environment: str) -> subprocess.Popen[str]:
        running.append(
            subprocess.Popen(
                [sys.executable, "-m", "angen_addon", *map(str, arguments)],
                cwd=ROOT,
                env={
                    **os.environ,
                    "PYTHONDONTWRITEBYTECODE": "1",
                    "PYTHONPATH": PAHO,
                    **environment,
                },
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        )
        return running[-1]

    yield run
    for process in running:
        process.send_signal(signal.SIGKILL)
        process.communicate()


@pytest.fixture
def angen(start):
    """Run a command of `angen` to its end; return (status, standard output, standard error)."""

    def run(*arguments: object, **environment: str) -> tuple[int, str, str]:
        process = start(*arguments, **environment)
        out, err = process.communicate(timeout=10 * PATIENCE_S)
        return process.returncode, out, err

    return run
