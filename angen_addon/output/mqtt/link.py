# SPDX-License-Identifier: GPL-3.0-or-later
"""The connection to a broker, by paho-mqtt."""

from __future__ import annotations

import socket
import ssl
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from ....parts import install_command
from ....sensor_logic.logs.error import AngenError, replaced
from ....sensor_logic.logs.formats.home_assistant import Message
from .address import Address
from .online import check_online

# s: longest wait for an answer; pause between two tries to reconnect; a broker that is silent this
# long has sent everything.
ANSWER_S, RETRY_S, QUIET_S = 5.0, 1.0, 0.5
# s: longest wait for the last messages at the end of a command.
PARTING_S = 0.5
# s: broker and client count the connection as lost after one and a half times this silence.
KEEPALIVE_S = 10
# Number of messages that may be unacknowledged at a time.
WINDOW = 100
POLL_S = 0.002


class Link:
    """A connection to the broker at `address`.

    The broker publishes the message `will` if the connection is lost. All messages are retained and
    acknowledged (QoS 1). A lost connection is made again only by `revive`.
    """

    def __init__(self, address: Address, will: Message) -> None:
        missing = (
            "MQTT needs paho-mqtt, which is not installed: install the extension from its zip, "
            f"which has it, or {install_command('mqtt')} in the project's folder"
        )
        with replaced(missing, ImportError, raised=AngenError):
            import paho.mqtt.client as paho
        self._paho = paho
        self._address, self._will = address, will
        self.words = address.words
        self._client: Any = None
        self._lost = threading.Event()
        self._refused = ""
        self._unacknowledged: deque[Any] = deque()
        self._retry_at = 0.0

    @property
    def is_lost(self) -> bool:
        """Whether the connection is lost."""
        return self._lost.is_set()

    def connect(self) -> None:
        """Make the connection.

        Raise AngenError if Blender does not allow it, or if the broker refuses it or does not
        answer.
        """
        check_online()
        paho = self._paho
        # After a reconnection by paho-mqtt, it would send all messages due meanwhile late, at once.
        client = paho.Client(
            paho.CallbackAPIVersion.VERSION2, protocol=paho.MQTTv5, reconnect_on_failure=False
        )
        address, lost, answered = self._address, threading.Event(), threading.Event()
        if address.user is not None:
            client.username_pw_set(address.user, address.password)
        if address.tls:
            client.tls_set_context(address.tls)
        client.will_set(*self._will, qos=1, retain=True)
        client.connect_timeout = ANSWER_S
        client.max_inflight_messages_set(WINDOW)
        answer: list[Any] = []
        unreadable = threading.Event()

        def loop(read_and_write: Callable[..., Any] = client.loop_forever, **options: Any) -> None:
            try:
                read_and_write(**options)
            except Exception:
                # paho-mqtt fails in many ways where the other side is no broker. Where a broker has
                # answered, the error is none of its: the program goes on, and Python shows it.
                unreadable.set()
                on_disconnect()
                if answer:
                    raise

        client.loop_forever = loop
        client.on_socket_open = _send_small_packets_at_once
        client.on_publish = self._on_publish

        def on_connect(_client: Any, _data: Any, _flags: Any, reason: Any, _more: Any) -> None:
            answer.append(reason)
            answered.set()

        def on_disconnect(*_: Any) -> None:
            lost.set()
            answered.set()

        client.on_connect, client.on_disconnect = on_connect, on_disconnect
        try:
            client.connect(address.host, address.port, KEEPALIVE_S)
        except (OSError, ValueError) as error:
            raise AngenError(_why(address, error)) from None
        client.loop_start()
        answered.wait(ANSWER_S)
        if not answer or answer[0].is_failure:
            is_closed = lost.is_set() and not unreadable.is_set()
            client.disconnect()
            raise AngenError(_refusal(address, answer[0] if answer else None, is_closed))
        self._client, self._lost, self._unacknowledged = client, lost, deque()

    def revive(self) -> bool:
        """Try to reconnect, at most once in RETRY_S; return whether this call has reconnected."""
        if not self.is_lost or time.monotonic() < self._retry_at:
            return False
        try:
            self.connect()
        except AngenError:
            self._retry_at = time.monotonic() + RETRY_S
            return False
        return True

    def send(self, message: Message, idle: Callable[[], None] = lambda: None) -> bool:
        """Publish a message; return False if the connection is lost.

        If too many earlier messages are unacknowledged, first wait, and call `idle` repeatedly
        meanwhile. Raise AngenError if the broker refuses the topic.
        """
        while len(self._unacknowledged) >= WINDOW and not self.is_lost:
            self._forget_acknowledged()
            if len(self._unacknowledged) >= WINDOW:
                time.sleep(POLL_S)
                idle()
        self._check_refusal()
        if self.is_lost:
            return False
        sent = self._client.publish(*message, qos=1, retain=True)
        if sent.rc != self._paho.MQTT_ERR_SUCCESS:
            return False
        self._unacknowledged.append(sent)
        return True

    def flush(self, seconds: float = ANSWER_S) -> bool:
        """Wait at most `seconds` until the broker has acknowledged all messages.

        Return whether the broker has acknowledged all. Raise AngenError if it refuses one.
        """
        end = time.monotonic() + seconds
        while self._forget_acknowledged() and not self.is_lost and time.monotonic() < end:
            time.sleep(POLL_S)
        self._check_refusal()
        return not self._forget_acknowledged()

    def take_unacknowledged(self) -> int:
        """Return the number of unacknowledged messages, and discard them.

        The broker may or may not have received these messages.
        """
        count = self._forget_acknowledged()
        self._unacknowledged.clear()
        return count

    def retained(self, topics: Sequence[str]) -> list[Message]:
        """Return the messages that the broker retains on these topics, which can have wildcards."""
        found: list[Message] = []
        last_heard = [time.monotonic()]

        def on_message(_client: Any, _data: Any, message: Any) -> None:
            last_heard[0] = time.monotonic()
            if message.retain and message.payload:
                text = message.payload.decode("utf-8", "replace")
                found.append(Message(message.topic, text))

        self._client.on_message = on_message
        self._client.on_subscribe = lambda *_: last_heard.append(time.monotonic())
        self._client.subscribe([(topic, 1) for topic in topics])
        # A broker does not report that it has sent all of them: it falls silent.
        end = time.monotonic() + ANSWER_S
        while time.monotonic() < end and not self.is_lost:
            if len(last_heard) > 1 and time.monotonic() - max(last_heard) > QUIET_S:
                break
            time.sleep(POLL_S)
        self._client.unsubscribe(list(topics))
        return found

    def close(self) -> None:
        """Disconnect, and wait until the broker has noticed.

        Without the wait, the broker would treat the connection as lost and publish the will.
        """
        if self._client is not None:
            self._client.disconnect()
            self._lost.wait(PARTING_S)

    def _forget_acknowledged(self) -> int:
        """Discard all acknowledged messages, and return the number of unacknowledged ones."""
        waiting = self._unacknowledged
        while waiting and waiting[0].is_published():
            waiting.popleft()
        return len(waiting)

    def _on_publish(self, _client: Any, _data: Any, _id: int, reason: Any, _more: Any) -> None:
        if reason.is_failure:
            self._refused = str(reason)

    def _check_refusal(self) -> None:
        if self._refused:
            user = f"user '{self._address.user}'" if self._address.user else "a nameless user"
            raise AngenError(
                f"{self._address} refuses messages from {user} ({self._refused}): allow it to "
                f"publish below homeassistant/device/ and {self._will.topic.rpartition('/')[0]}/"
            )


def _send_small_packets_at_once(_client: Any, _data: Any, opened: Any) -> None:
    opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _why(address: Address, error: Exception) -> str:
    if isinstance(error, ssl.SSLCertVerificationError):
        return (
            f"the certificate of {address} is not trusted ({error.verify_message}): "
            f"give {address.words.authority}, the certificate of the authority that signed it"
        )
    if address.tls and isinstance(error, (ssl.SSLError, ConnectionResetError)):
        return f"{address} does not use TLS: give its TLS port, or {address.words.without_tls}"
    if isinstance(error, socket.gaierror):
        return f"host '{address.host}' is not found ({error.strerror}): check its name"
    if isinstance(error, ConnectionRefusedError):
        return f"no broker listens at {address}: is it running, and is this its port?"
    if isinstance(error, TimeoutError):
        return f"{address} does not answer: is the broker's host on, and reachable from here?"
    return f"cannot connect to {address}: {getattr(error, 'strerror', None) or error}"


def _refusal(address: Address, reason: Any, is_closed: bool) -> str:
    if reason is None:
        did = "closed the connection" if is_closed else "does not answer as a broker does"
        way = "" if address.tls else f", and does it need {address.words.tls}"
        return f"{address} {did}: is this its port{way}?"
    if str(reason) in {"Not authorized", "Bad user name or password"}:
        return f"{address} refuses the connection ({reason}): {address.words.credentials}"
    return f"{address} refuses the connection: {reason}; the broker must support MQTT 5"
