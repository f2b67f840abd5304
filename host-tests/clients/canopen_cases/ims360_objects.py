"""The objects of SIKO's IMS360: chapter 7 of the manual, with the decisions S1..S76 in core/src/model/ims360/README.md."""

from .protocol import EMCY, INVALID, TPDO0, Object
from .runner import Subject

NODE = 50  # 2002h: 32h

# The mappable objects (table 7, and the four that only the pages of the objects mark, S48), with their length in bits.
MAPPABLE = {
    (0x3000, 1): 8,
    (0x3010, 1): 16,
    (0x3010, 2): 16,
    (0x3010, 3): 16,
    (0x3011, 0): 32,
    (0x3012, 0): 32,
    (0x3013, 0): 32,
    (0x3020, 1): 16,
    (0x3020, 2): 16,
    (0x3020, 3): 16,
    (0x3021, 0): 32,
    (0x3022, 0): 32,
    (0x3023, 0): 32,
    (0x3100, 1): 8,
    (0x3110, 2): 8,
    (0x3112, 1): 8,
    (0x3112, 4): 8,
    (0x6110, 0): 32,
    (0x6120, 0): 32,
    (0x6511, 0): 8,
}
LONGITUDINAL, LATERAL = 0x61100020, 0x61200020
GYRO = (0x30200110, 0x30200210, 0x30200310)


def entry(index: int, sub: int) -> int:
    """The mapping entry of a mappable object."""
    return index << 16 | sub << 8 | MAPPABLE[index, sub]


def _highest(index: int, sub: int) -> Object:
    return Object(index, 0, 1, False, sub)


def _commands(index: int, count: int) -> list[Object]:
    """1010h and 1011h: a read returns 1."""
    return [_highest(index, count), *(Object(index, sub, 4, True, 1) for sub in range(1, count + 1))]


def _tpdo(number: int, cob_id: int, mapped: tuple[int, ...]) -> list[Object]:
    """The communication and mapping parameter of a TPDO. Sub-index 4 does not exist (S76)."""
    communication, mapping = 0x1800 + number, 0x1A00 + number
    entries = [*mapped, *[0] * (8 - len(mapped))]
    return [
        _highest(communication, 5),
        Object(communication, 1, 4, True, cob_id, relative=True),
        Object(communication, 2, 1, True, 254),
        Object(communication, 3, 2, True, 0),
        Object(communication, 5, 2, True, 0),
        Object(mapping, 0, 1, True, len(mapped)),
        *(Object(mapping, sub, 4, True, value) for sub, value in enumerate(entries, 1)),
    ]


def _raw(index: int) -> list[Object]:
    """Three raw values, and the three objects with a high resolution that follow."""
    return [
        _highest(index, 3),
        *(Object(index, sub, 2, False, None, signed=True) for sub in (1, 2, 3)),
        *(Object(index + axis, 0, 4, False, None, signed=True) for axis in (1, 2, 3)),
    ]


# Sections 7.2.1 to 7.2.49, and the objects of the J1939 mode (S20, S21), which CANopen reads and writes as well.
OBJECTS = [
    Object(0x1000, 0, 4, False, 0x0704019A),
    Object(0x1001, 0, 1, False, 0),
    Object(0x1003, 0, 1, True, 0),
    Object(0x1005, 0, 4, True, 0x80),
    Object(0x1008, 0, None, False, "IMS360"),
    Object(0x1009, 0, None, False, None),
    Object(0x100A, 0, None, False, None),
    *_commands(0x1010, 4),
    *_commands(0x1011, 5),
    Object(0x1014, 0, 4, True, EMCY, relative=True),
    Object(0x1017, 0, 2, True, 0),
    _highest(0x1018, 4),
    Object(0x1018, 1, 4, False, 0x195),
    Object(0x1018, 2, 4, False, 0x1869F),
    Object(0x1018, 3, 4, False, 0),
    Object(0x1018, 4, 4, False, None),
    *_tpdo(0, TPDO0, (LONGITUDINAL, LATERAL)),
    *_tpdo(1, INVALID | 0x280, ()),
    *_tpdo(2, INVALID | 0x380, ()),
    *_tpdo(3, INVALID | 0x480, ()),
    _highest(0x2000, 3),
    Object(0x2000, 1, None, False, None),
    Object(0x2000, 2, 4, False, 1),
    Object(0x2000, 3, None, False, "IMS360"),
    Object(0x2001, 0, 4, True, 125_000),
    Object(0x2002, 0, 1, True, NODE),
    _highest(0x2010, 2),
    Object(0x2010, 1, 1, True, None, readable=False),
    _highest(0x2020, 1),
    Object(0x2020, 1, 4, False, None),
    Object(0x20FF, 0, 2, False, 1),
    Object(0x2102, 0, 1, True, 128),
    _highest(0x2104, 4),
    *(Object(0x2104, sub, 2, True, rate) for sub, rate in enumerate((10, 0, 0, 0), 1)),
    _highest(0x2105, 4),
    *(Object(0x2105, sub, 1, True, 3) for sub in (1, 2, 3, 4)),
    _highest(0x2106, 9),
    *(Object(0x2106, sub, 1, True, value) for sub, value in enumerate((1, 0, 0, 0, 145, 0, 0), 1)),
    Object(0x2106, 8, 2, True, 2047),
    Object(0x2106, 9, 4, False, None),
    _highest(0x3000, 5),
    Object(0x3000, 1, 1, False, 0b101),
    *(Object(0x3000, sub, 1, False, 0) for sub in (2, 3, 4, 5)),
    *_raw(0x3010),
    *_raw(0x3020),
    _highest(0x3100, 2),
    Object(0x3100, 1, 1, True, 2),
    Object(0x3100, 2, 1, True, 1),
    _highest(0x3110, 2),
    Object(0x3110, 1, 1, True, 2),
    Object(0x3110, 2, 1, True, 0),
    Object(0x3111, 0, 2, True, 2000),
    _highest(0x3112, 4),
    Object(0x3112, 1, 1, True, 1, signed=True),
    Object(0x3112, 2, 1, True, -3, signed=True),
    Object(0x3112, 3, 1, True, 1, signed=True),
    Object(0x3112, 4, 1, True, 1, signed=True),
    _highest(0x3120, 1),
    Object(0x3120, 1, 1, True, 1, signed=True),
    Object(0x3200, 0, 1, True, None, signed=True, readable=False),
    Object(0x3210, 0, 4, True, 0, signed=True),
    Object(0x3220, 0, 4, True, 0, signed=True),
    Object(0x6000, 0, 2, False, 10),
    Object(0x6110, 0, 4, False, None, signed=True),
    Object(0x6111, 0, 1, False, 0),
    Object(0x6120, 0, 4, False, None, signed=True),
    Object(0x6121, 0, 1, False, 0),
    Object(0x6511, 0, 1, False, None, signed=True),
]
TABLE = {(one.index, one.sub): one for one in OBJECTS}
LISTED = {one.index for one in OBJECTS}

# What a tool must not write back (S75).
COMMANDS = {(0x1003, 0), (0x2010, 1), (0x3200, 0)} | {key for key in TABLE if key[0] in (0x1010, 0x1011) and key[1]}
SETTINGS = [one for one in OBJECTS if one.writable and (one.index, one.sub) not in COMMANDS]

IMS360 = Subject("ims360", NODE, TABLE)

# What dcfgen writes to map 6120h and 3000h:01 into TPDO 2, which is off as delivered: index, sub-index, value. `eds_check.py`
# compares it with the output of dcfgen, and `configuration` writes it to the sensor.
PDO_CONFIGURATION = [
    (0x1801, 5, 20),
    (0x1A01, 0, 0),
    (0x1A01, 1, LATERAL),
    (0x1A01, 2, 0x30000108),
    (0x1A01, 0, 2),
    (0x1801, 1, 0x2B2),
]
