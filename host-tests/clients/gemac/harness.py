"""The virtual sensor as a process, and a CAN adapter."""

import contextlib
import re
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import can

from .clock import ComputerClock, SensorClock
from .protocol import EXTENDED

REPLY_TIMEOUT = 0.4  # a reply takes less than a millisecond; this is long enough for a busy machine


class SensorGone(Exception):
    """The sensor no longer answers, or did not start."""


@dataclass(frozen=True)
class Frame:
    """A received CAN frame. Bit 31 of `id` marks the 29-bit format, as in table 23."""

    id: int
    data: bytes
    remote: bool = False
    at: float = field(default=0.0, compare=False)

    def __str__(self) -> str:
        number = f"{self.id & 0x1FFF_FFFF:08X}" if self.id & EXTENDED else f"{self.id:03X}"
        return f"{number}#{'R' if self.remote else self.data.hex().upper()}"


@dataclass(frozen=True)
class Program:
    """The program under test, further arguments for it, and the folder with firmware images if it must run them."""

    binary: Path
    images: Path | None = None
    arguments: Sequence[str] = ()

    def command(self, product: str) -> list[str]:
        """The command line that starts a sensor of this product."""
        command = [str(self.binary), *self.arguments, "--model", product]
        return command if self.images is None else [*command, "--elf", str(self.images / product)]


class Sensor:
    """A running virtual-sensor process. With `real_time`, it uses the clock of the computer, for clients that know no other clock."""

    def __init__(self, program: Program, product: str, *, real_time: bool = False, **options: object) -> None:
        self.clock = ComputerClock() if real_time else SensorClock()
        command = [*program.command(product), "--listen", "127.0.0.1:0", *self.clock.arguments]
        for name, value in options.items():
            if value is not None:
                command += [f"--{name.replace('_', '-')}", str(value)]
        self._errors = tempfile.TemporaryFile()
        self.started = self.clock.now() if real_time else 0.0
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self._errors, text=True
        )
        self.port = self._read_port(command)
        self.clock.connect(self.port)

    def _read_port(self, command: list[str]) -> int:
        # readline also returns when the process ends.
        line = self._process.stdout.readline()
        match = re.fullmatch(r"slcan socket://127\.0\.0\.1:(\d+)\s*", line)
        if not match:
            self.kill()
            raise SensorGone(f"{' '.join(command)} printed first {line!r}; {self.errors()}")
        return int(match[1])

    @property
    def running(self) -> bool:
        """True while the process runs."""
        return self._process.poll() is None

    def errors(self) -> str:
        """The text on its standard error."""
        self._errors.seek(0)
        return self._errors.read().decode(errors="replace").strip()

    def kill(self) -> None:
        """Kills the process, which is a power cut."""
        self._process.kill()
        self._process.wait()
        self._process.stdout.close()
        self.clock.close()


class Timed:
    """Base class: the clock of the sensor."""

    sensor: Sensor

    def now(self) -> float:
        """The time in s."""
        return self.sensor.clock.now()

    def sleep(self, seconds: float) -> None:
        """Waits."""
        self.sensor.clock.sleep(seconds)


class Tester:
    """A CAN adapter on the bus of the sensor: python-can's slcan driver over TCP."""

    def __init__(self, sensor: Sensor, bitrate: int | None = None, timing: can.BitTiming | None = None) -> None:
        options = {}
        if bitrate is not None:
            # S7 is 800 kbit/s in the LAWICEL protocol; the driver uses 750 kbit/s for it.
            options["bitrate"] = 750_000 if bitrate == 800_000 else bitrate
        if timing is not None:
            options["timing"] = timing
        self._bus = sensor.clock.bus(channel=f"socket://127.0.0.1:{sensor.port}", **options)
        self._missed = 0

    def close(self) -> None:
        """Closes the adapter (C) and its connection."""
        with contextlib.suppress(can.CanError, OSError):  # the process of the sensor may have ended already
            self._bus.close()
        # pyserial sleeps 0.3 s when it closes a socket, so this runs in another thread.
        threading.Thread(target=self._shutdown, daemon=True).start()

    def _shutdown(self) -> None:
        with contextlib.suppress(can.CanError, OSError):  # the process of the sensor may have ended already
            self._bus.shutdown()

    def send(self, identifier: int, data: bytes = b"", *, remote: bool = False, dlc: int | None = None) -> None:
        """Sends one frame; `dlc` is for remote frames."""
        self._bus.send(
            can.Message(
                arbitration_id=identifier & 0x1FFF_FFFF,
                is_extended_id=bool(identifier & EXTENDED),
                is_remote_frame=remote,
                data=None if remote else data,
                dlc=dlc,
            )
        )

    def receive(self, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame from the bus, or None after the timeout."""
        message = self._bus.recv(timeout)
        if message is None:
            return None
        identifier = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
        return Frame(identifier, bytes(message.data), message.is_remote_frame, message.timestamp)

    def request(self, identifier: int, data: bytes) -> Frame | None:
        """Sends a request and returns the next frame on the bus."""
        self.send(identifier, data)
        frame = self.receive()
        self._missed = 0 if frame else self._missed + 1
        if self._missed > 20:
            raise SensorGone("20 requests in a row were not answered")
        return frame

    def collect(self, seconds: float) -> list[Frame]:
        """All frames received within this time."""
        end = self._bus.now() + seconds
        frames = []
        while (left := end - self._bus.now()) > 0:
            if frame := self.receive(left):
                frames.append(frame)
        return frames

    def collect_until_quiet(self, pause: float = 0.15, limit: float = 15.0) -> list[Frame]:
        """All frames received until there was none for `pause` s, or until the limit."""
        end = self._bus.now() + limit
        frames = []
        while self._bus.now() < end and (frame := self.receive(pause)):
            frames.append(frame)
        return frames

    def take(self, count: int, timeout: float) -> list[Frame]:
        """The next `count` frames, or fewer after the timeout."""
        end = self._bus.now() + timeout
        frames: list[Frame] = []
        while len(frames) < count and (left := end - self._bus.now()) > 0:
            if frame := self.receive(left):
                frames.append(frame)
        return frames
