"""The traces of the CANopen sensors, written from the device manual of the ifm JN2101 and CiA 301."""

from collections.abc import Iterator

import wire

NODE_ID = 10
NMT, SYNC = 0x000, 0x080
TPDO0, TPDO1 = 0x180 + NODE_ID, 0x280 + NODE_ID
SDO_REPLY, SDO_REQUEST = 0x580 + NODE_ID, 0x600 + NODE_ID
ERROR_CONTROL = 0x700 + NODE_ID

# 125 kbit/s
BIT_US = 8


def all_traces() -> Iterator["Trace"]:
    """Every trace of this file."""
    yield boot_up()


class Trace:
    """Frames in the order of time."""

    def __init__(self, name: str, origin: str, *, scene: str, serial: int = 1) -> None:
        self.name = name
        self.now = 0
        self._lines = [
            f"# origin: {origin}",
            f"# model: {name.split('-')[0]}",
            f"# scene: tilt={scene}",
            "# bitrate: 125000",
            "# tolerance-us: 300",
            f"# serial: {serial}",
            "",
        ]

    def text(self) -> str:
        """The text of the file."""
        return "\n".join(self._lines) + "\n"

    def note(self, text: str) -> None:
        """A heading."""
        self._lines += ["", f"# -- {text}"]

    def _frame(self, identifier: int, data: str, direction: str) -> None:
        at = f"{self.now // 1_000_000}.{self.now % 1_000_000:06}"
        self._lines.append(f"({at}) can0 {identifier:03X}#{data} {direction}")

    def wait(self, milliseconds: int) -> None:
        """Advances the time."""
        self.now += 1000 * milliseconds

    def send(self, identifier: int, data: str = "") -> None:
        """The tester sends; sets `now` to the end of the frame."""
        self._frame(identifier, data, "T")
        remote = int(data[1:]) if data.startswith("R") else None
        payload = b"" if remote is not None else bytes.fromhex(data)
        self.now += BIT_US * wire.frame_bits(identifier, payload, remote)

    def expect(self, identifier: int, data: str) -> None:
        """The sensor sends at the first time at which the bus is free; sets `now` to the end of the frame."""
        self.now += BIT_US * (wire.INTERMISSION + wire.frame_bits(identifier, bytes.fromhex(data)))
        self._frame(identifier, data, "R")

    def ask(self, request: str, reply: str) -> None:
        """An SDO request, its reply, and a pause."""
        self.send(SDO_REQUEST, request)
        self.expect(SDO_REPLY, reply)
        self.wait(10)


def boot_up() -> Trace:
    """Boot-up, identity, guarding, and the inclination by SYNC and remote frame."""
    trace = Trace("jn2101-boot-up", "written from ifm JN2101 device manual, 7.3 to 7.6, and CiA 301", scene="12.34,-5.67")
    trace.note("The boot-up message, without a request.")
    trace.expect(ERROR_CONTROL, "00")
    trace.wait(100)
    trace.note("Device type and vendor; the name in segments; a missing object.")
    trace.ask("4000100000000000", "430010009A010400")
    trace.ask("4018100100000000", "431810010069666D")
    trace.ask("4008100000000000", "4108100006000000")
    trace.ask("6000000000000000", "034A4E3231303100")
    trace.ask("4004100000000000", "8004100000000206")
    trace.note("Guarding: the toggle bit starts at 0.")
    for answer in ("7F", "FF", "7F"):
        trace.send(ERROR_CONTROL, "R1")
        trace.expect(ERROR_CONTROL, answer)
        trace.wait(10)
    trace.note("In operational both TPDOs answer the SYNC: 1234 and -567.")
    trace.send(NMT, f"01{NODE_ID:02X}")
    trace.wait(10)
    for _ in range(3):
        trace.send(SYNC)
        trace.expect(TPDO0, "D204C9FD")
        trace.expect(TPDO1, "D2040000C9FDFFFF")
        trace.wait(10)
    trace.note("A remote frame requests one of them.")
    trace.send(TPDO0, "R4")
    trace.expect(TPDO0, "D204C9FD")
    trace.wait(10)
    trace.note("In stopped only guarding is answered.")
    trace.send(NMT, f"02{NODE_ID:02X}")
    trace.send(SYNC)
    trace.send(SDO_REQUEST, "4000100000000000")
    trace.wait(10)
    trace.send(ERROR_CONTROL, "R1")
    trace.expect(ERROR_CONTROL, "84")
    trace.note("Reset communication: boot-up message.")
    trace.wait(10)
    trace.send(NMT, "8200")
    trace.expect(ERROR_CONTROL, "00")
    return trace
