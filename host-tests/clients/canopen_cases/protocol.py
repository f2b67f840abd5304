"""The CANopen protocol: identifiers, NMT, SDO abort codes, and the object dictionary of the tables in the manual."""

from dataclasses import dataclass

FACTORY_NODE_ID = 10  # section 9.1

# The pre-defined connection set (section 11.2, J1).
NMT, SYNC = 0x000, 0x080
EMCY, TPDO0, TPDO1, SDO_REPLY, SDO_REQUEST, ERROR_CONTROL = 0x080, 0x180, 0x280, 0x580, 0x600, 0x700

# NMT commands and states (CiA 301, 7.2.8).
START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F

# SDO abort codes (CiA 301, table 22).
TOGGLE = 0x05030000
TIME_OUT = 0x05040000
UNKNOWN_COMMAND = 0x05040001
BLOCK_SIZE = 0x05040002
SEQUENCE_NUMBER = 0x05040003
CRC_ERROR = 0x05040004
UNSUPPORTED_ACCESS = 0x06010000
WRITE_ONLY = 0x06010001
READ_ONLY = 0x06010002
NO_OBJECT = 0x06020000
NOT_MAPPABLE = 0x06040041
PDO_TOO_LONG = 0x06040042
LENGTH = 0x06070010
TOO_LONG = 0x06070012
TOO_SHORT = 0x06070013
NO_SUB_INDEX = 0x06090011
INVALID_VALUE = 0x06090030
TOO_HIGH = 0x06090031
TOO_LOW = 0x06090032
CANNOT_STORE = 0x08000020
LOCAL_CONTROL = 0x08000021
DEVICE_STATE = 0x08000022
NO_DATA = 0x08000024

# The abort codes for a value out of range and for data of the wrong length: CiA 301 permits several.
RANGE = {INVALID_VALUE, TOO_HIGH, TOO_LOW}
LONG = {LENGTH, TOO_LONG}
SHORT = {LENGTH, TOO_SHORT}

# Emergency error codes (section 7.6.1).
NO_ERROR, ERROR_PASSIVE, LIFE_GUARD = 0x0000, 0x8120, 0x8130

SAVE, LOAD = b"save", b"load"


@dataclass(frozen=True)
class Object:
    """An entry of the object dictionary. `size` is in bytes, None for a string; `default` is None if devices differ in it."""

    index: int
    sub: int
    size: int | None
    writable: bool
    default: int | str | None
    signed: bool = False
    relative: bool = False  # the node-ID is added to the default
    readable: bool = True

    def __str__(self) -> str:
        return f"{self.index:04X}h:{self.sub:02X}"

    def expected(self, node: int = FACTORY_NODE_ID) -> bytes | None:
        """The bytes of the default value."""
        if self.default is None:
            return None
        if isinstance(self.default, str):
            return self.default.encode()
        return encode(self.default + node * self.relative, self.size)


def encode(value: int, size: int) -> bytes:
    """An integer in the format of CANopen."""
    return (value % (1 << 8 * size)).to_bytes(size, "little")


def decode(data: bytes, signed: bool = False) -> int:
    """The integer in these bytes."""
    return int.from_bytes(data, "little", signed=signed)


def _pdo(number: int, cob: int, slopes: tuple[int, int]) -> list[Object]:
    """The communication and mapping parameter of a transmit PDO."""
    communication, mapping = 0x1800 + number, 0x1A00 + number
    return [
        Object(communication, 0, 1, False, 5),
        Object(communication, 1, 4, True, cob, relative=True),  # its own COB-ID only (J25)
        Object(communication, 2, 1, True, 1),
        Object(communication, 3, 2, True, 0),
        Object(communication, 5, 2, True, 10),
        Object(mapping, 0, 1, False, 2),
        Object(mapping, 1, 4, False, slopes[0]),
        Object(mapping, 2, 4, False, slopes[1]),
    ]


def _slope(index: int, size: int) -> list[Object]:
    """A slope and its operating parameter, which is read-only."""
    return [Object(index, 0, size, False, 0, signed=True), Object(index + 1, 0, 1, False, 0)]


# Sections 7.6 and 7.7, defaults of chapter 14.
OBJECTS = [
    Object(0x1000, 0, 4, False, 0x0004019A),
    Object(0x1001, 0, 1, False, 0),
    Object(0x1003, 0, 1, True, 0),  # u8 as in CiA 301 (J16)
    Object(0x1005, 0, 4, True, 0x80),
    Object(0x1008, 0, None, False, "JN2101"),
    Object(0x1009, 0, None, False, None),
    Object(0x100A, 0, None, False, None),
    Object(0x100C, 0, 2, True, 0),
    Object(0x100D, 0, 1, True, 0),
    Object(0x1010, 0, 1, False, 1),
    Object(0x1010, 1, 4, True, None),
    Object(0x1011, 0, 1, False, 1),
    Object(0x1011, 1, 4, True, None),
    Object(0x1014, 0, 4, False, EMCY, relative=True),
    Object(0x1015, 0, 2, True, 0),
    Object(0x1017, 0, 2, True, 0),
    Object(0x1018, 0, 1, False, 4),
    Object(0x1018, 1, 4, False, 0x6D666900),
    Object(0x1018, 2, 4, False, 0x01),
    Object(0x1018, 3, 4, False, 0xAA),
    Object(0x1018, 4, 4, False, None),
    Object(0x1029, 0, 1, False, 1),
    Object(0x1029, 1, 1, True, 0),
    Object(0x1200, 0, 1, False, 2),
    Object(0x1200, 1, 4, False, SDO_REQUEST, relative=True),
    Object(0x1200, 2, 4, False, SDO_REPLY, relative=True),
    *_pdo(0, TPDO0, (0x60100010, 0x60200010)),
    *_pdo(1, TPDO1, (0x61100020, 0x61200020)),
    Object(0x1F80, 0, 4, True, 0),
    Object(0x2000, 0, 1, True, FACTORY_NODE_ID),
    Object(0x2001, 0, 2, True, 125),
    Object(0x2002, 0, 1, True, 0),
    Object(0x2040, 0, 1, True, 1),
    Object(0x2041, 0, 1, True, 1),
    Object(0x2042, 0, 1, True, 2),
    Object(0x2043, 0, 1, True, 2),
    Object(0x2044, 0, 1, True, 0),
    Object(0x2045, 0, 1, True, 1),
    Object(0x2046, 0, 1, True, 2),
    Object(0x207F, 0, 1, True, None),
    Object(0x3000, 0, None, True, "D0UfZEgRKHAI5Ag="),
    Object(0x4004, 0, 1, False, 2),
    Object(0x4004, 1, 1, True, 0),
    Object(0x4004, 2, 1, False, None),
    Object(0x4080, 0, 4, False, None, signed=True),
    Object(0x4081, 0, 2, False, None),
    Object(0x6000, 0, 2, True, 10),
    *_slope(0x6010, 2),
    *_slope(0x6020, 2),
    *_slope(0x6110, 4),
    *_slope(0x6120, 4),
]
BY_KEY = {(entry.index, entry.sub): entry for entry in OBJECTS}
LISTED = {entry.index for entry in OBJECTS}

# Bits of the COB-ID of a TPDO (CiA 301, 7.5.2.37).
INVALID, NO_RTR = 1 << 31, 1 << 30

# What dcfgen writes to set all parameters of both TPDOs: index, sub-index, value. `eds_check.py` compares it with the output of
# dcfgen, and `tools` writes it to the sensor.
PDO_CONFIGURATION = [
    (0x1800, 1, INVALID | 0x18A),
    (0x1800, 2, 254),
    (0x1800, 3, 50),
    (0x1800, 5, 20),
    (0x1A00, 0, 0),
    (0x1A00, 1, 0x60100010),
    (0x1A00, 2, 0x60200010),
    (0x1A00, 0, 2),
    (0x1800, 1, 0x18A),
    (0x1801, 1, INVALID | 0x28A),
    (0x1801, 2, 2),
    (0x1801, 3, 100),
    (0x1801, 5, 1000),
    (0x1A01, 0, 0),
    (0x1A01, 1, 0x61100020),
    (0x1A01, 2, 0x61200020),
    (0x1A01, 0, 2),
    (0x1801, 1, 0x28A),
]

# Actions and measured values have their own checks. All other objects are settings.
ACTIONS = {0x1003, 0x1010, 0x1011, 0x2002, 0x207F, 0x4004}
MEASURED = {0x4080, 0x4081}
SETTINGS = [entry for entry in OBJECTS if entry.writable and entry.index not in ACTIONS]
STEADY = [entry for entry in OBJECTS if entry.index not in ACTIONS | MEASURED]
