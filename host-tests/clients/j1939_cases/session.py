"""The IMS360 on a J1939 network, and the other nodes: frames as text, claims, requests, and parameters by proprietary A.

A `Node` is a `Session` of the CANopen check: with `mode` J1939, the bytes of its SDO travel in proprietary A (S38).
"""

import shutil
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from canopen_cases import protocol as c
from canopen_cases.runner import Context
from canopen_cases.session import REPLY_TIMEOUT, Session
from gemac.harness import Frame, Program, Sensor, SensorGone, Tester
from gemac.protocol import EXTENDED

from . import protocol as p
from .values import Wanted

# Limits in s. A frame takes up to 1.3 ms at 125 kbit/s, and its time is that of its end.
AT_ONCE = 0.02  # some frames, and a cycle of the sensor
START_TIME = 0.2  # from a start to the claim; the answer to 2010h:01 leaves first
ONLINE_TIME = 8.0  # also long enough for a busy machine with the time of the computer
SILENCE = (0.250, 0.254)  # from a claim to the next frame
DM1_PERIOD = (0.997, 1.003)
BAM_STEP = (0.060, 0.064)  # 60 ms from the transmission of a packet on, and the next frame; S29 allows 50..200
EARLY, LATE = 0.0026, 0.005  # a time-out may begin when a frame is queued, two frames before its end
# Read to mark the end of what came before: no such object.
MARK = bytes([0x40, 0xFE, 0x5F, 0x00])

Settings = Mapping[tuple[int, int], int]
QUIET = {(0x2104, 1): 0}  # SSI2 off


class Node(Session):
    """One sensor and one adapter; the sensor starts in J1939 mode with these settings. SSI2 is off, unless they switch it on."""

    def __init__(
        self,
        context: Context,
        settings: Settings | None = None,
        *,
        scene: str | Path = "tilt=0,0",
        mode: int = p.J1939,
        online: bool = True,
        bus_rate: str | None = None,
        log: Path | None = None,
        name: str | None = None,
        real_time: bool = False,
    ) -> None:
        self.context, self.mode, self.address, self.me = context, mode, p.PREFERRED, p.ME
        self.log = log
        self.online = online
        self.quantized = quantized(context)
        settings = QUIET | dict(settings or {})
        self.address = settings.get((0x2102, 0), p.PREFERRED)
        store = prepare(context, settings, name) if mode == p.J1939 else context.store(name or "canopen")
        super().__init__(
            context.report, context.binary, context.subject.product, context.arguments,
            scene=scene, store=store, bus_rate=bus_rate, log=log, real_time=real_time, node=context.subject.node, table=p.TABLE,
        )  # fmt: skip

    # Power.

    def power_up(self, *, boot: bool = True, alone: float = 0.0) -> None:
        """Starts the process and opens an adapter; waits for the boot-up message or for an address."""
        self.sensor = Sensor(Program(self.binary, arguments=self.arguments), self.product, **self.options)
        self.sleep(alone)
        self.tester = Tester(self.sensor)
        self.others: list[Frame] = []
        if self.mode == p.CANOPEN:
            if boot and not self.wait_boot_up(ONLINE_TIME):
                raise SensorGone(f"no boot-up message; {self.sensor.errors()}")
            self.clear_error_passive()
        elif boot and self.online:
            self.wait_online()

    def wait_online(self) -> None:
        """Waits until the sensor answers at its address."""
        end = self.now() + ONLINE_TIME
        while self.now() < end:
            self.send_to(self.address, MARK, p.PROBE)
            if self.wait(self.is_mark, 0.1):
                if self.options["real_time"]:
                    # On a busy machine, several may be answered.
                    self.tester.collect_until_quiet(0.06, 0.5)
                self.others.clear()
                return
        raise SensorGone(f"no node at {self.address:02X}h; {self.sensor.errors()}")

    def restart(self) -> None:
        """2010h:01 (S38). The reply may be lost; the first frame is the claim."""
        with suppress(SensorGone):
            self.put(0x2010, 1, 1)

    def restarted(self) -> Frame | None:
        """Restarts, and waits for the first claim."""
        self.restart()
        return self.wait_pgn(p.CLAIMED, START_TIME)

    # Frames.

    def tx(self, *lines: str) -> None:
        """Sends frames: `18EA8021#EBFE00`."""
        for line in lines:
            number, _, data = line.partition("#")
            wide = EXTENDED if len(number) == 8 else 0
            self.tester.send(int(number, 16) | wide, bytes.fromhex(data))

    def send_to(self, address: int, data: bytes, source: int | None = None) -> None:
        """Sends proprietary A."""
        source = self.me if source is None else source
        self.tx(p.shown(p.PROPRIETARY_A, source, data.ljust(8, b"\x00"), address))

    def is_mark(self, frame: Frame) -> bool:
        """Whether this is the answer to a mark, from any address of ours."""
        parts = p.split(frame)
        return bool(parts and (parts.pgn, parts.destination) == (p.PROPRIETARY_A, p.PROBE))

    def after(self, *lines: str, pause: float = 0.04) -> list[str]:
        """Sends frames; returns what the sensor sends after them, as text, without cyclic messages. Two answered marks and a pause
        tell the end."""
        self.others.clear()
        self.tx(*lines)
        for _ in range(2):
            self.send_to(self.address, MARK, p.PROBE)
            if not self.wait(self.is_mark, REPLY_TIMEOUT):
                return [*self.shown_others(), "and no answer to a mark"]
        self.wait(lambda frame: False, pause)
        return self.shown_others()

    def shown_others(self) -> list[str]:
        """The frames since `others` was cleared, without cyclic messages."""
        found, self.others = self.others, []
        return [str(frame) for frame in found if not self.cyclic(frame)]

    def cyclic(self, frame: Frame) -> bool:
        """DM1 and process data."""
        parts = p.split(frame)
        return bool(parts and parts.pgn in (p.DM1, *p.PROCESS))

    def expect(self, name: str, lines: str | list[str], *expected: str) -> bool:
        """Sends frames and checks all frames that follow."""
        lines = [lines] if isinstance(lines, str) else lines
        got = self.after(*lines)
        return self.report.equal(f"{name}: {', '.join(lines[:3])}", list(expected), got)

    def wait_pgn(self, pgn: int, timeout: float = REPLY_TIMEOUT, source: int | None = None) -> Frame | None:
        """The next frame of a parameter group."""

        def wanted(frame: Frame) -> bool:
            parts = p.split(frame)
            return bool(parts and parts.pgn == pgn and source in (None, parts.source))

        return self.wait(wanted, timeout)

    def wait_text(self, text: str, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame with this text."""
        return self.wait(lambda frame: str(frame) == text, timeout)

    def comes(self, name: str, text: str, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """Checks that the next frame but cyclic ones is this."""
        frame = self.next(timeout)
        self.report.equal(name, text, str(frame) if frame else "nothing")
        return frame

    def next(self, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame that is not cyclic."""
        return self.wait(lambda frame: not self.cyclic(frame), timeout)

    def silent(self, name: str, seconds: float = 0.15) -> None:
        """Checks that nothing but cyclic messages is sent for this time."""
        self.others.clear()
        self.wait(lambda frame: False, seconds)
        self.report.equal(name, [], self.shown_others())

    def all_of(self, pgn: int, seconds: float) -> list[Frame]:
        """All frames of a parameter group within this time."""
        found = self.tester.collect(seconds)
        return [frame for frame in found if (parts := p.split(frame)) and parts.pgn == pgn]

    def took(self, name: str, seconds: float, got: float) -> None:
        """Checks the time from the end of a frame to the end of the frame that a time-out causes."""
        self.report.within(name, seconds - EARLY, seconds + LATE, got)

    # Requests.

    def request(self, pgn: int, to: int | None = None, source: int | None = None, rest: bytes = b"") -> str:
        """The text of a request (S26)."""
        to, source = self.address if to is None else to, self.me if source is None else source
        return p.shown(p.REQUEST, source, p.pgn_bytes(pgn) + rest, to)

    def ask(self, pgn: int) -> bytes | None:
        """Requests a message of one frame; returns its data."""
        self.others.clear()
        self.tx(self.request(pgn))
        frame = self.wait_pgn(pgn, source=self.address)
        return frame.data if frame else None

    # What groups of the CANopen check use, in J1939 mode.

    def quiet(self, name: str, seconds: float = 0.12) -> None:
        """Checks that no frame but cyclic messages is sent for this time."""
        if self.mode == p.CANOPEN:
            super().quiet(name, seconds)
        else:
            self.silent(name, seconds)

    def dead(self, name: str, seconds: float) -> None:
        """Checks that no frame at all is sent for this time."""
        super().quiet(name, seconds)

    def reset(self, command: int = c.RESET_NODE) -> bool:
        """Resets the sensor; returns whether it has started."""
        if self.mode == p.CANOPEN:
            return super().reset(command)
        claimed = self.restarted() is not None
        self.wait_online()
        return claimed

    def send(self, identifier: int, data: bytes = b"", **kind: object) -> None:
        """Sends one frame; an SDO request in proprietary A."""
        if self.mode == p.J1939 and identifier == c.SDO_REQUEST + self.node:
            self.send_to(self.address, data)
        else:
            super().send(identifier, data, **kind)

    def wait_id(self, base: int, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame of a service; an SDO reply in proprietary A."""
        if self.mode == p.J1939 and base == c.SDO_REPLY:
            answer = p.identifier(p.PROPRIETARY_A, self.address, self.me) | EXTENDED
            return self.wait(lambda frame: frame.id == answer, timeout)
        return super().wait_id(base, timeout)

    # SDO in proprietary A.

    def sdo(self, data: bytes, timeout: float = REPLY_TIMEOUT) -> bytes | None:
        """Sends one SDO frame, filled with zeros, and returns the answer."""
        if self.mode == p.CANOPEN:
            return super().sdo(data, timeout)
        self.send_to(self.address, data)
        frame = self.wait_id(c.SDO_REPLY, timeout)
        return frame.data if frame else None

    def becomes(self, name: str, pgn: int, wanted: Wanted, timeout: float = 4.0) -> bool:
        """Requests a group until its data is as wanted, for example because a filter settles."""
        end = self.now() + timeout
        while (data := self.ask(pgn)) is None or (not wanted.fits(data, self.quantized) and self.now() < end):
            self.sleep(0.01)
        return self.report.verdict(wanted.fits(data, self.quantized), name, str(wanted), data.hex().upper())

    def save(self, sub: int = 1) -> None:
        """1010h."""
        self.download(0x1010, sub, c.SAVE)

    def load(self, sub: int = 1) -> None:
        """1011h."""
        self.download(0x1011, sub, c.LOAD)


def quantized(context: Context) -> bool:
    """Whether the sensor is a firmware image, with a part of 16 bits."""
    return "--elf" in context.arguments


@dataclass
class J1939Context(Context):
    """A context whose sessions are in J1939 mode, for groups of the CANopen check."""

    def session(self, **options: object) -> Node:
        """Starts a sensor."""
        return Node(self, scene=options.get("scene", "tilt=0,0"))


def prepare(context: Context, settings: Settings, name: str | None = None) -> Path:
    """A store of a sensor that starts in J1939 mode with these settings, written over CANopen (S17, S20)."""
    known = "-".join(f"{index:04x}.{sub}.{value}" for (index, sub), value in settings.items())
    master = context.folder / f"prepared-{abs(hash(known))}.bin"
    if not master.exists():
        with Context.session(context, store=master, table=p.TABLE) as session:
            for key, value in settings.items():
                session.put(*key, value)
            session.put(*p.SWITCH, p.J1939)
            session.send(c.SDO_REQUEST + session.node, b"\x23\x10\x10\x01" + c.SAVE)
            if not session.wait_id(c.SDO_REPLY):
                raise SensorGone("the save was not answered")
    count = len(list(context.folder.glob("node-*.bin")))
    copy = context.folder / f"node-{name or count}.bin"
    shutil.copy(master, copy)
    return copy
