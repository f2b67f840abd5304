"""DM1 as a receiver has it: single frames, and BAMs that are complete (S37, S29).

DM1      lamps: 04h amber warning, 00h none; FFh; then for each code SPN bits 0..7, SPN bits 8..15, SPN bits 16..18 and FMI,
         conversion method and occurrence count; one code is filled with FFh to 8 bytes
"""

from dataclasses import dataclass
from itertools import permutations

from gemac.harness import Frame

from . import protocol as p
from .session import Node

NONE = "00FF00000000FFFF"
CHANGE = 0.1  # s from a change to its DM1: the next sample, 50 ms after the DM1 before, and the frames before it
BAM = 0.13  # s for two packets, and the frames before them

Code = tuple[int, int, int]  # SPN, FMI, occurrence count


def codes(data: bytes) -> list[Code]:
    """The codes of a DM1."""
    found = []
    for at in range(2, len(data) - 3, 4):
        one = data[at : at + 4]
        spn = one[0] | one[1] << 8 | one[2] >> 5 << 16
        found.append((spn, one[2] & 0x1F, one[3] & 0x7F))
    return found


def message(*found: Code) -> bytes:
    """A DM1 with these codes."""
    if not found:
        return bytes.fromhex(NONE)
    body = b"\x04\xff" + b"".join(
        bytes([spn & 0xFF, spn >> 8 & 0xFF, spn >> 16 << 5 | fmi, count]) for spn, fmi, count in found
    )
    return body.ljust(8, b"\xff")


def fits(data: bytes, found: tuple[Code, ...]) -> bool:
    """Whether a DM1 has exactly these codes, in any order."""
    return any(data == message(*order) for order in permutations(found))


@dataclass(frozen=True)
class Message:
    """A complete DM1, or why it is wrong; the time of its frame or of its announcement, and of its last frame."""

    data: bytes
    begin: float
    end: float
    wrong: str = ""

    def __str__(self) -> str:
        return self.wrong or self.data.hex().upper()


class Assembler:
    """Composes the DM1 of frames."""

    def __init__(self) -> None:
        self._announced: Frame | None = None
        self._data = b""
        self._count = 0

    def feed(self, frame: Frame) -> Message | None:
        """Takes the next frame; returns the message that it completes."""
        parts = p.split(frame)
        if parts is None or parts.destination != p.GLOBAL:
            return None
        running = self._announced is not None and p.split(self._announced).source == parts.source
        if parts.pgn == p.DM1:
            # The older message ends later, so a receiver believes it.
            return Message(frame.data, frame.at, frame.at, "one frame within a BAM of DM1" if running else "")
        if parts.pgn == p.TP_CM and frame.data[0] == 0x20:
            self._announced = frame if frame.data[5:] == p.pgn_bytes(p.DM1) else None
            self._data, self._count = b"", 0
            return Message(b"", frame.at, frame.at, "announced within a BAM of DM1") if running else None
        if parts.pgn == p.TP_DT and running:
            self._count += 1
            self._data += frame.data[1:]
            return self._packet(frame)
        return None

    def _packet(self, frame: Frame) -> Message | None:
        announced = self._announced
        size, count = int.from_bytes(announced.data[1:3], "little"), announced.data[3]
        if frame.data[0] == self._count < count:
            return None
        self._announced = None
        wrong = ""
        if frame.data[0] != self._count:
            wrong = f"packet {frame.data[0]} instead of {self._count}"
        elif not 8 < size <= 7 * count < size + 7:
            wrong = f"BAM of {size} bytes in {count} packets"
        elif set(self._data[size:]) - {0xFF}:
            wrong = f"unused bytes {self._data[size:].hex()}"
        return Message(self._data[:size], announced.at, frame.at, wrong)


class Dm1Log:
    """The DM1 of a session, in their order: nothing is left out but what `others` lost by a call of `clear`."""

    def __init__(self, session: Node) -> None:
        self.session = session
        self.changed: float | None = None
        self._assembler = Assembler()
        self._last: Message | None = None
        session.others.clear()

    def next(self, timeout: float = 1.2) -> Message | None:
        """The next DM1. It comes once a second, by BAM 120 ms later."""
        session, end = self.session, self.session.now() + timeout
        while True:
            frame = session.others.pop(0) if session.others else session.tester.receive(max(0.0, end - session.now()))
            if frame is None:
                return None
            if found := self._assembler.feed(frame):
                return found

    def collect(self, seconds: float) -> list[Message]:
        """All DM1 that are complete within this time."""
        found, end = [], self.session.now() + seconds
        while (left := end - self.session.now()) > 0 and (one := self.next(left)):
            found.append(one)
        return found

    def put(self, index: int, sub: int, value: int) -> None:
        """Writes an object that changes the set of codes."""
        self.changed = self.session.now()
        self.session.put(index, sub, value)

    def until(self, name: str, *found: Code, timeout: float = 1.2, limit: float = CHANGE) -> Message | None:
        """Checks the next DM1 that differs from the last one: that it has these codes in any order, and, after `put`, that it
        comes within the limit. If there was no last one, the next DM1 must have them."""
        end = self.session.now() + timeout
        before = self._last
        while True:
            one = self.next(max(0.0, end - self.session.now()))
            repeated = one and before and not one.wrong and one.data == before.data and not fits(one.data, found)
            if not repeated:
                break
        good = one is not None and not one.wrong and fits(one.data, found)
        self.session.report.verdict(good, name, f"{message(*found).hex().upper()} in any order", str(one))
        if one and self.changed is not None:
            # A BAM of the codes before must end first.
            limit += BAM if before and len(before.data) > 8 else 0.0
            self.session.report.within(f"{name}: s from the change", 0.0, limit, one.begin - self.changed)
        self.changed = None
        self._last = one
        return one
