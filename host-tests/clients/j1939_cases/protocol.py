"""SAE J1939: identifiers, NAME, parameter groups, transport frames, and the objects that only J1939 has.

identifier       priority 3 bits, data pages 2, PDU format 8, PDU specific 8, source address 8
NAME             identity 21 bits, manufacturer 11, ECU instance 3, function instance 5, function 8, reserved 1, vehicle system 7,
                 vehicle system instance 4, industry group 3, arbitrary address capable 1; least significant byte first
"""

from dataclasses import dataclass, replace

from canopen_cases.ims360_objects import OBJECTS as CANOPEN_OBJECTS
from canopen_cases.protocol import Object
from gemac.harness import Frame
from gemac.protocol import EXTENDED

PREFERRED = 0x80  # 2102h as delivered
ME, OTHER, PROBE = 0x21, 0x35, 0xF9  # addresses of the checking nodes
GLOBAL, NULL = 0xFF, 0xFE

REQUEST, ACKNOWLEDGE, CLAIMED, COMMANDED, PROPRIETARY_A = 59904, 59392, 60928, 65240, 61184
TP_CM, TP_DT = 60416, 60160
SSI, SSI2, ARI, ACCS = 61459, 61481, 61482, 61485
DM1, COMPONENT, SOFTWARE, ECU = 65226, 65259, 65242, 64965
PROCESS = (SSI2, SSI, ARI, ACCS)  # in the order of 2104h and 2105h

# Abort reasons of the transport protocol.
BUSY, RESOURCES, TIMEOUT, BAD_SEQUENCE = 1, 2, 3, 7


@dataclass(frozen=True)
class Identifier:
    """The parts of a 29-bit identifier. `page` has both data page bits."""

    priority: int
    page: int
    pgn: int
    destination: int
    source: int


def split(frame: Frame) -> Identifier | None:
    """The parts of the identifier of a frame; None if it has 11 bits."""
    if not frame.id & EXTENDED:
        return None
    number = frame.id & 0x1FFF_FFFF
    kind, specific = number >> 16 & 0xFF, number >> 8 & 0xFF
    page = number >> 24 & 3
    pgn = page << 16 | kind << 8 | (specific if kind >= 240 else 0)
    return Identifier(number >> 26, page, pgn, specific if kind < 240 else GLOBAL, number & 0xFF)


def identifier(pgn: int, source: int, destination: int = GLOBAL, priority: int = 6) -> int:
    """A 29-bit identifier, without the bit that marks the format."""
    specific = 0 if pgn >> 8 & 0xFF >= 240 else destination
    return priority << 26 | pgn << 8 | specific << 8 | source


def shown(pgn: int, source: int, data: bytes, destination: int = GLOBAL, priority: int = 6) -> str:
    """A frame as text, as in a candump log."""
    return f"{identifier(pgn, source, destination, priority):08X}#{data.hex().upper()}"


def pgn_bytes(pgn: int) -> bytes:
    """A PGN in three bytes."""
    return pgn.to_bytes(3, "little")


def nack(pgn: int, asker: int = ME, source: int = PREFERRED) -> str:
    """The negative acknowledgement, sent to all (S27)."""
    return shown(ACKNOWLEDGE, source, bytes([1, 0xFF, 0xFF, 0xFF, asker]) + pgn_bytes(pgn))


@dataclass(frozen=True)
class Name:
    """The fields of a NAME, as delivered (S21)."""

    capable: int = 1
    industry: int = 0
    system_instance: int = 0
    system: int = 0
    function: int = 145
    function_instance: int = 0
    ecu_instance: int = 0
    manufacturer: int = 2047
    identity: int = 1

    @property
    def value(self) -> int:
        """The 64-bit number; the lower one wins."""
        return (
            self.identity
            | self.manufacturer << 21
            | self.ecu_instance << 32
            | self.function_instance << 35
            | self.function << 40
            | self.system << 49
            | self.system_instance << 56
            | self.industry << 60
            | self.capable << 63
        )

    @property
    def data(self) -> bytes:
        """The eight bytes on the bus."""
        return self.value.to_bytes(8, "little")

    def settings(self) -> dict[tuple[int, int], int]:
        """The fields as objects 2106h:01 to :08."""
        fields = (
            self.capable, self.industry, self.system_instance, self.system,
            self.function, self.function_instance, self.ecu_instance, self.manufacturer,
        )  # fmt: skip
        return {(0x2106, sub): value for sub, value in enumerate(fields, 1)}


OURS = Name()
HIGHER = replace(OURS, identity=2).data  # loses against ours
LOWER = replace(OURS, capable=0).data  # wins against ours


def claim(address: int = PREFERRED, name: bytes = OURS.data) -> str:
    """Address Claimed (S22)."""
    return shown(CLAIMED, address, name)


def other_name(number: int, *, capable: int = 0) -> bytes:
    """The NAME of some other node."""
    return replace(OURS, capable=capable, function=20, manufacturer=100, identity=number).data


# Transport frames.


def rts(source: int, to: int, pgn: int, size: int, limit: int = 255) -> str:
    """Request to send."""
    body = bytes([16]) + size.to_bytes(2, "little") + bytes([(size + 6) // 7, limit]) + pgn_bytes(pgn)
    return shown(TP_CM, source, body, to, 7)


def bam(source: int, pgn: int, size: int) -> str:
    """Broadcast announce."""
    body = bytes([32]) + size.to_bytes(2, "little") + bytes([(size + 6) // 7, 255]) + pgn_bytes(pgn)
    return shown(TP_CM, source, body, GLOBAL, 7)


def cts(source: int, to: int, pgn: int, count: int, first: int) -> str:
    """Clear to send; a count of 0 holds the connection."""
    return shown(TP_CM, source, bytes([17, count, first, 0xFF, 0xFF]) + pgn_bytes(pgn), to, 7)


def end_of_message(source: int, to: int, pgn: int, size: int) -> str:
    """End of message acknowledged."""
    body = bytes([19]) + size.to_bytes(2, "little") + bytes([(size + 6) // 7, 255]) + pgn_bytes(pgn)
    return shown(TP_CM, source, body, to, 7)


def abort(source: int, to: int, pgn: int, reason: int) -> str:
    """Connection abort."""
    return shown(TP_CM, source, bytes([255, reason, 0xFF, 0xFF, 0xFF]) + pgn_bytes(pgn), to, 7)


def packet(source: int, to: int, data: bytes, number: int) -> str:
    """The data frame with this number, from 1; unused bytes are FFh."""
    part = data[7 * (number - 1) : 7 * number].ljust(7, b"\xff")
    return shown(TP_DT, source, bytes([number & 0xFF]) + part, to, 7)


def packets(source: int, to: int, data: bytes) -> list[str]:
    """All data frames of a message."""
    return [packet(source, to, data, number) for number in range(1, (len(data) + 6) // 7 + 1)]


# The objects of S20 and S21; with them, the CANopen dictionary is complete.
OBJECTS = [
    Object(0x2102, 0, 1, True, PREFERRED),
    Object(0x2104, 0, 1, False, 4),
    *(Object(0x2104, sub, 2, True, value) for sub, value in enumerate((10, 0, 0, 0), 1)),
    Object(0x2105, 0, 1, False, 4),
    *(Object(0x2105, sub, 1, True, 3) for sub in (1, 2, 3, 4)),
    Object(0x2106, 0, 1, False, 9),
    *(Object(0x2106, sub, 2 if sub == 8 else 1, True, value) for (_, sub), value in OURS.settings().items()),
    Object(0x2106, 9, 4, False, None),
]
TABLE = {(one.index, one.sub): one for one in (*CANOPEN_OBJECTS, *OBJECTS)}
SWITCH = (0x3100, 1)
J1939, CANOPEN = 1, 2
