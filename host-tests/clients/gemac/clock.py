"""The clock of a check: the clock of the computer, or the clock of the sensor, which the check advances.

With the clock of the sensor, the load of the computer does not change a measured time, and a time-out of 10 s takes milliseconds.
virtual-sensor/src/server/clock.rs describes the lines.
"""

import socket
import time
from math import ceil
from types import SimpleNamespace

import can
from can.interfaces.slcan import slcanBus
from serial.urlhandler import protocol_socket

# pyserial waits 0.3 s when it closes a connection, for servers with one connection. The virtual sensor accepts several.
protocol_socket.time = SimpleNamespace(sleep=lambda seconds: None)

ANSWER_TIMEOUT = 60.0  # the simulation of the longest span takes less time, also on a busy machine


class ComputerClock:
    """The clock of the computer."""

    arguments = ()

    def connect(self, port: int) -> None:
        """Begins to use a sensor."""

    def close(self) -> None:
        """Ends the use of the sensor."""

    def now(self) -> float:
        """The time in s."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Waits."""
        time.sleep(seconds)

    def bus(self, **options: object) -> can.BusABC:
        """An adapter."""
        return StampedBus(sleep_after_open=0, **options)


class SensorClock:
    """The clock of a sensor. Its connection does not take part in the bus."""

    arguments = ("--clock", "client")
    _socket: socket.socket | None = None

    def connect(self, port: int) -> None:
        """Begins to advance the time of a sensor."""
        self._socket = socket.create_connection(("127.0.0.1", port), ANSWER_TIMEOUT)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def close(self) -> None:
        """Ends the use of the sensor."""
        # A sensor that has not started has no connection.
        if self._socket is not None:
            self._socket.close()

    def now(self) -> float:
        """The time in s."""
        return self._advance(0)

    def sleep(self, seconds: float) -> None:
        """Advances the time."""
        self._advance(seconds)

    def bus(self, **options: object) -> can.BusABC:
        """An adapter."""
        return AdvancingBus(sleep_after_open=0, **options)

    def _advance(self, seconds: float) -> float:
        self._socket.sendall(line(seconds).encode() + b"\r")
        answer = b""
        while not answer.endswith(b"\r"):
            piece = self._socket.recv(64)
            if not piece:
                raise can.CanOperationError("the sensor has ended")
            answer += piece
        return time_of(answer.decode())


class StampedBus(slcanBus):
    """python-can's slcan driver. A frame has the time at which the computer read it."""

    def now(self) -> float:
        """The time in s."""
        return time.monotonic()

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The next frame, or None after the timeout."""
        message = super().recv(timeout)
        if message is not None:
            message.timestamp = time.monotonic()
        return message


class AdvancingBus(slcanBus):
    """python-can's slcan driver. A wait for a frame advances the time. A frame has the time of the bus."""

    def __init__(self, **options: object) -> None:
        self._received: list[tuple[float, str]] = []
        super().__init__(**options)
        # The answer shows that the sensor has read all earlier lines.
        self._advance(0)

    def now(self) -> float:
        """The time in s."""
        return self._advance(0)

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        """Queues a frame. The adapter sends it when a client advances the time."""
        super().send(message, timeout)
        self._advance(0)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The next frame, or None when the time has advanced by the timeout."""
        if not self._received:
            self._advance(timeout or 0)
        if not self._received:
            return None
        at, text = self._received.pop(0)
        self._queue.put(text)
        message, _ = super()._recv_internal(0)
        message.timestamp = at
        return message

    def close(self) -> None:
        """Leaves the bus."""
        super().close()
        self._advance(0)

    def _advance(self, seconds: float) -> float:
        self._write(line(seconds))
        at = 0.0
        while True:
            text = self._read(ANSWER_TIMEOUT)
            if text is None:
                raise can.CanOperationError("the sensor does not answer")
            if text.startswith("@"):
                return time_of(text)
            if text.startswith("#"):
                at = time_of(text)
            elif text[0] in "tTrR":
                self._received.append((at, text))


def line(seconds: float) -> str:
    """The line that advances the time, at least by this span."""
    return f"@{max(0, ceil(seconds * 1_000_000)):X}"


def time_of(text: str) -> float:
    """The time in a line, in s."""
    return int(text[1:], 16) / 1_000_000
