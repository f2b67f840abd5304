"""The traces of the CANopen sensors, written from the manuals of the ifm JN2101 and the SIKO IMS360, CiA 301 and CiA 305."""

import binascii
from collections.abc import Iterator

import wire

NODE_ID = 10
NMT, SYNC = 0x000, 0x080
TPDO0, TPDO1 = 0x180 + NODE_ID, 0x280 + NODE_ID
SDO_REPLY, SDO_REQUEST = 0x580, 0x600
ERROR_CONTROL = 0x700 + NODE_ID
LSS_ANSWER, LSS_REQUEST = 0x7E4, 0x7E5

IMS360 = 50

# 125 kbit/s
BIT_US = 8


def all_traces() -> Iterator["Trace"]:
    """Every trace of this file."""
    yield boot_up()
    yield ims360_boot_up()
    yield ims360_mapping()
    yield ims360_lss()
    yield ims360_block()


class Trace:
    """Frames in the order of time."""

    def __init__(self, name: str, origin: str, *, scene: str, serial: int = 1, node: int = NODE_ID) -> None:
        self.name = name
        self.node = node
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
        number = f"{identifier & 0x1FFF_FFFF:08X}" if identifier & wire.EXTENDED else f"{identifier:03X}"
        self._lines.append(f"({at}) can0 {number}#{data} {direction}")

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
        self.send(SDO_REQUEST + self.node, request)
        self.expect(SDO_REPLY + self.node, reply)
        self.wait(10)

    def lss(self, request: str, answer: str | None = None) -> None:
        """An LSS request, its answer if there is one, and a pause."""
        self.send(LSS_REQUEST, request.ljust(16, "0"))
        if answer:
            self.expect(LSS_ANSWER, answer.ljust(16, "0"))
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
    trace.send(SDO_REQUEST + NODE_ID, "4000100000000000")
    trace.wait(10)
    trace.send(ERROR_CONTROL, "R1")
    trace.expect(ERROR_CONTROL, "84")
    trace.note("Reset communication: boot-up message.")
    trace.wait(10)
    trace.send(NMT, "8200")
    trace.expect(ERROR_CONTROL, "00")
    return trace


def ims360(name: str, sections: str) -> Trace:
    """A trace of the IMS360, which begins with its boot-up message."""
    origin = f"by the virtual sensor ims360, checked against the SIKO IMS360 CANopen manual, {sections}"
    trace = Trace(f"ims360-{name}", origin, scene="12.34,-5.67", node=IMS360)
    trace.note("The boot-up message, without a request.")
    trace.expect(0x700 + IMS360, "00")
    trace.wait(100)
    return trace


def ims360_boot_up() -> Trace:
    """Boot-up, identity, texts, the inclination by SDO and SYNC, heartbeat."""
    trace = ims360("boot-up", "6 and 7.2")
    trace.note("Device type, the identity of 6.3, the name in segments, a missing object and a missing sub-index.")
    trace.ask("4000100000000000", "430010009A010407")
    for sub, number in ((1, 0x195), (2, 0x1869F), (3, 0), (4, 1)):
        trace.ask(f"401810{sub:02X}00000000", f"431810{sub:02X}{number.to_bytes(4, 'little').hex().upper()}")
    trace.ask("4008100000000000", "4108100006000000")
    trace.ask("6000000000000000", "03494D5333363000")
    trace.ask("400C100000000000", "800C100000000206")
    trace.ask("4000180400000000", "8000180411000906")
    trace.note("Longitudinal and lateral: 1234 and -567; status: two axes, factory values.")
    trace.ask("4010610000000000", "43106100D2040000")
    trace.ask("4020610000000000", "43206100C9FDFFFF")
    trace.ask("4000300100000000", "4F00300105000000")
    trace.note("Type 1: TPDO 1 answers the SYNC. Type 253: a remote frame alone.")
    trace.ask("2F00180201000000", "6000180200000000")
    trace.send(NMT, "0132")
    trace.wait(10)
    for _ in range(2):
        trace.send(SYNC)
        trace.expect(0x1B2, "D2040000C9FDFFFF")
        trace.wait(10)
    trace.ask("2F001802FD000000", "6000180200000000")
    trace.send(SYNC)
    trace.wait(10)
    trace.send(0x1B2, "R8")
    trace.expect(0x1B2, "D2040000C9FDFFFF")
    trace.wait(10)
    trace.note("There are no types 0 and 241; 1005h is written in pre-operational only.")
    trace.ask("2F00180200000000", "8000180230000906")
    trace.ask("2F001802F1000000", "8000180230000906")
    trace.ask("2305100085000000", "8005100022000008")
    trace.note("Reset communication: boot-up message.")
    trace.send(NMT, "8232")
    trace.expect(0x700 + IMS360, "00")
    return trace


def ims360_mapping() -> Trace:
    """The procedure of 6.1.3 with its wrong steps."""
    trace = ims360("mapping", "6.1.3")
    trace.note("Refused while TPDO 1 is on: its mapping.")
    trace.ask("2F001A0000000000", "80001A0000000106")
    trace.note("TPDO 2 is off: its number is 0. No such object, not mappable, wrong length, an empty entry, too many.")
    trace.ask("23011A0110001060", "80011A0100000206")
    trace.ask("23011A0108000110", "80011A0141000406")
    trace.ask("23011A0110001061", "80011A0141000406")
    trace.ask("2F011A0001000000", "80011A0041000406")
    trace.ask("2F011A0009000000", "80011A0042000406")
    trace.note("Lateral angle and status byte; on with another identifier; type 1.")
    trace.ask("23011A0120002061", "60011A0100000000")
    trace.ask("23011A0208010030", "60011A0200000000")
    trace.ask("2F011A0002000000", "60011A0000000000")
    trace.ask("23011801C0010000", "6001180100000000")
    trace.ask("2F01180201000000", "6001180200000000")
    trace.send(NMT, "0132")
    trace.wait(10)
    trace.send(SYNC)
    trace.expect(0x1C0, "C9FDFFFF01")
    trace.wait(10)
    trace.note("Another identifier while it is on is refused; off is silent.")
    trace.ask("23011801C1010000", "8001180130000906")
    trace.ask("23011801C0010080", "6001180100000000")
    trace.send(SYNC)
    trace.wait(10)
    trace.send(0x1C0, "R5")
    trace.wait(10)
    return trace


def ims360_lss() -> Trace:
    """Layer setting services, up to a new node-ID."""
    trace = ims360("lss", "6.3")
    trace.note("Waiting: no answer.")
    trace.lss("5E")
    trace.note("Switch state selective; node-ID and identity.")
    for request in ("4095010000", "419F860100", "4200000000"):
        trace.lss(request)
    trace.lss("4301000000", "44")
    trace.lss("5E", "5E32")
    for request, answer in (("5A", "5A95010000"), ("5B", "5B9F860100"), ("5C", "5C"), ("5D", "5D01000000")):
        trace.lss(request, answer)
    trace.note("Node-ID 127 and 10 kbit/s: error 1. Node-ID 60.")
    trace.lss("117F", "1101")
    trace.lss("130008", "1301")
    trace.lss("113C", "11")
    trace.ask("4002200000000000", "4F0220003C000000")
    trace.note("Waiting, reset communication: boot-up of node 60.")
    trace.lss("04")
    trace.send(NMT, "8232")
    trace.expect(0x73C, "00")
    trace.wait(10)
    trace.node = 60
    trace.ask("4001180100000000", "43011801BC020080")
    return trace


def ims360_block() -> Trace:
    """SDO block upload of the name, and block download of the heartbeat time with a wrong and a right CRC."""
    trace = ims360("block", "7.2.5 and 7.2.11, and CiA 301, 7.2.4.3.8")
    trace.note("1008h in one block; the CRC of IMS360.")
    trace.ask("A40810007F000000", "C608100006000000")
    trace.ask("A300000000000000", "81494D5333363000")
    check = binascii.crc_hqx(b"IMS360", 0).to_bytes(2, "little").hex().upper()
    trace.ask("A2017F0000000000", f"C5{check}0000000000")
    trace.send(SDO_REQUEST + IMS360, "A100000000000000")
    trace.wait(10)
    trace.note("1017h = 500 in blocks of 31 segments: with a wrong CRC 05040004h, then with the right one.")
    value = (500).to_bytes(2, "little")
    check = binascii.crc_hqx(value, 0)
    for number, answer in ((check ^ 1, "8017100004000405"), (check, "A100000000000000")):
        trace.ask("C617100002000000", "A41710001F000000")
        trace.ask("81F4010000000000", "A2011F0000000000")
        trace.ask(f"D5{number.to_bytes(2, 'little').hex().upper()}0000000000", answer)
    return trace
