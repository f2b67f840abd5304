"""Identifiers, services, error codes and objects of the sensors, as the manual and DeviceNet define them."""

from collections.abc import Callable
from dataclasses import dataclass

FACTORY_MAC = 63
MASTER = 0x0A
OTHER = 0x0B
STRANGER = 0x3E

VENDOR = 354
RESPONSE_BIT = 0x80

# Message ids of group 2 (bits 2..0); bits 8..3 are the MAC ID.
STROBE, MULTICAST_POLL, ACKNOWLEDGE, RESPONSE, EXPLICIT, POLL, PORT, DUPLICATE = range(8)

# Services.
RESET, GET, SET, ALLOCATE, RELEASE = 0x05, 0x0E, 0x10, 0x4B, 0x4C

# General error codes, as bytes of an error response: code, additional code.
PORT_BUSY = "0C01"
PORT_UNSUPPORTED_SERVICE = "0203"
CHOICE_UNSUPPORTED = "0202"
CHOICE_INVALID = "0902"
CHOICE_STATE = "0B02"
NO_SERVICE = "08FF"
INVALID_VALUE = "09FF"
INHIBIT_ABOVE_RATE = "0911"
STATE_CONFLICT = "0CFF"
NOT_SETTABLE = "0EFF"
TOO_SHORT = "13FF"
NO_ATTRIBUTE = "14FF"
TOO_LONG = "15FF"
NO_OBJECT = "16FF"
INVALID_PARAMETER = "20FF"

# Allocation choice.
CHOICE_EXPLICIT, CHOICE_POLL, CHOICE_COS, CHOICE_CYCLIC, CHOICE_SUPPRESS = 0x01, 0x02, 0x10, 0x20, 0x40

# Classes.
IDENTITY, ROUTER, DEVICENET, ASSEMBLY, CONNECTION, HANDLER, ANGLE = 1, 2, 3, 4, 5, 0x2B, 0x65
CLASSES = (IDENTITY, ROUTER, DEVICENET, ASSEMBLY, CONNECTION, HANDLER, ANGLE)

# States of a connection.
CONFIGURING, ESTABLISHED, TIMED_OUT, DEFERRED = 1, 3, 4, 5

# Instances of the connection object.
C_EXPLICIT, C_POLL, C_COS = 1, 2, 4

RESOLUTIONS = (10, 100, 1000)


@dataclass(frozen=True)
class Subject:
    """A product: its name, whether it measures 360 deg on one axis, and a scene with its words at 0.01 deg."""

    product: str
    name: str
    circular: bool
    scene: str
    long: int
    lateral: int

    def units(self, resolution: int) -> int:
        """The number of steps in 360 deg."""
        return 360_000 // resolution

    def rounded(self, hundredths: int, resolution: int) -> int:
        """An angle in 0.01 deg as a word: to the nearest, halves away from zero (T14)."""
        word = half_away(hundredths * 10, resolution)
        return word % self.units(resolution) if self.circular else word

    def limits(self, resolution: int) -> tuple[int, int]:
        """The range of a preset or a differential offset (T6, T10, T14)."""
        return (0, self.units(resolution) - 1) if self.circular else (-80_000 // resolution, 80_000 // resolution)


def half_away(number: int, by: int) -> int:
    """Quotient, rounded to the nearest, halves away from zero."""
    quotient = (2 * abs(number) + by) // (2 * by)
    return quotient if number >= 0 else -quotient


SUBJECTS = {
    subject.product: subject
    for subject in (
        Subject("tiltix080", "INCLINOMETER 080 degree", False, "tilt=12.34,-5.67", 1234, -567),
        Subject("tiltix360", "INCLINOMETER 360 degree", True, "tilt=123.47,0", 12347, 0),
    )
}

Range = Callable[[Subject, int], tuple[int, ...]]


def span(low: int, high: int) -> Range:
    """A range that is the same for all products and resolutions."""
    return lambda subject, resolution: (low, high)


def angle(subject: Subject, resolution: int) -> tuple[int, ...]:
    """A preset or a differential offset."""
    return subject.limits(resolution)


def delta(subject: Subject, resolution: int) -> tuple[int, ...]:
    """COS delta: at most 2 deg."""
    return (0, 2000 // resolution)


@dataclass(frozen=True)
class Attribute:
    """An attribute of the angle object: size in bytes, its range if it can be set, factory value, whether it is an angle."""

    id: int
    name: str
    size: int
    range: Range | None = None
    factory: int | None = None
    angle: bool = False

    def __str__(self) -> str:
        return f"{self.id:02X}h {self.name}"


ATTRIBUTES = (
    Attribute(0x01, "number of attributes", 2, factory=22),
    Attribute(0x71, "resolution", 2, span(10, 1000), 10),
    Attribute(0x72, "slope long16", 2, angle=True),
    Attribute(0x73, "long operating parameter", 1, span(0, 3), 0),
    Attribute(0x74, "long preset value", 2, angle, 0, True),
    Attribute(0x75, "long preset enable", 1, span(0, 1), 0),
    Attribute(0x76, "long offset", 2, factory=0, angle=True),
    Attribute(0x77, "long differential offset", 2, angle, 0, True),
    Attribute(0x78, "diagnostic slope long", 4),
    Attribute(0x7A, "slope lateral16", 2, angle=True),
    Attribute(0x7B, "lateral operating parameter", 1, span(0, 3), 0),
    Attribute(0x7C, "lateral preset value", 2, angle, 0, True),
    Attribute(0x7D, "lateral preset enable", 1, span(0, 1), 0),
    Attribute(0x7E, "lateral offset", 2, factory=0, angle=True),
    Attribute(0x7F, "lateral differential offset", 2, angle, 0, True),
    Attribute(0x80, "diagnostic slope lateral", 4),
    Attribute(0x81, "polled assembly instance", 1, span(101, 103), 103),
    Attribute(0x82, "cyclic/COS assembly instance", 1, span(101, 103), 103),
    Attribute(0x84, "size of the moving average filter", 1, span(0, 250), 100),
    Attribute(0x85, "weight of the recursive filter", 2, span(0, 1000), 0),
    Attribute(0x87, "terminal resistor", 1, span(0, 1), 0),
    Attribute(0x88, "COS delta", 1, delta, 0),
)
BY_ID = {attribute.id: attribute for attribute in ATTRIBUTES}


def group1(message: int, mac: int) -> int:
    """The identifier of a group 1 message."""
    return message << 6 | mac


def group2(message: int, mac: int) -> int:
    """The identifier of a group 2 message."""
    return 0x400 | mac << 3 | message


def poll_response(mac: int) -> int:
    """The identifier of the poll response."""
    return group1(0x0F, mac)


def change_of_state(mac: int) -> int:
    """The identifier of a COS or cyclic message."""
    return group1(0x0D, mac)


def encode(value: int, size: int) -> str:
    """An integer as hex digits, low byte first."""
    return (value & (1 << 8 * size) - 1).to_bytes(size, "little").hex().upper()


def decode(data: str, signed: bool = False) -> int:
    """Hex digits, low byte first, as an integer."""
    return int.from_bytes(bytes.fromhex(data), "little", signed=signed)


def error(code: str, master: int = MASTER) -> str:
    """The data of an error response."""
    return f"{master:02X}94{code}"
