"""The connection to the control port of a virtual sensor: one line of JSON for each request, answer and event."""

import json
import socket
from collections import deque
from dataclasses import dataclass


class BenchError(Exception):
    """The virtual sensor does not run, or has refused a request."""


@dataclass(frozen=True)
class Frame:
    """A frame on the bus."""

    time: float  # s on the clock of the bus
    sensor: str | None  # the sensor that has sent it; None: a client
    identifier: int
    data: bytes
    extended: bool = False
    remote: bool = False

    @classmethod
    def of_event(cls, event: dict) -> "Frame":
        """The frame of an event."""
        digits, _, data = event["frame"].partition("#")
        remote = data.startswith("R")
        return cls(
            event["time"],
            event["sensor"],
            int(digits, 16),
            b"" if remote else bytes.fromhex(data),
            len(digits) == 8,
            remote,
        )


class Connection:
    """A client of the control port."""

    def __init__(self, host: str, port: int, timeout: float = 120.0):
        self.socket = socket.create_connection((host, port), timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.timeout = timeout
        self.rest = b""
        self.events: deque[dict] = deque()

    def close(self) -> None:
        """Ends the connection."""
        self.socket.close()

    def line(self) -> dict:
        """The next line; TimeoutError if there is none in time."""
        while b"\n" not in self.rest:
            received = self.socket.recv(65536)
            if not received:
                raise BenchError("the virtual sensor has ended")
            self.rest += received
        line, _, self.rest = self.rest.partition(b"\n")
        return json.loads(line)

    def ask(self, do: str, **members: object) -> dict:
        """Sends a request and returns the members of its answer. The events before the answer wait in `events`."""
        request = {"do": do} | members
        try:
            self.socket.sendall(json.dumps(request).encode() + b"\n")
            while "event" in (line := self.line()):
                self.events.append(line)
        except OSError as error:
            raise BenchError(f"the virtual sensor does not answer: {error}") from error
        if "error" in line:
            raise BenchError(line["error"])
        return line["ok"]

    def next_event(self, seconds: float) -> dict | None:
        """The next event within this time of the computer; None without one."""
        if self.events:
            return self.events.popleft()
        self.socket.settimeout(seconds)
        try:
            return self.line()
        except TimeoutError:
            return None
        finally:
            self.socket.settimeout(self.timeout)
