"""IMS360: the object dictionary (chapter 7), texts, limits, the status byte, zero point and offsets."""

import re

from . import protocol as p
from .ims360_objects import LISTED, NODE, OBJECTS, SETTINGS, TABLE
from .runner import Context
from .session import Session

# What a setting accepts and refuses.
LIMITS: dict[tuple[int, int], tuple[list[int], list[int]]] = {
    (0x1017, 0): ([10, 65535, 0], [1, 9]),
    (0x1800, 2): ([1, 2, 240, 252, 253, 255, 254], [0, 241, 248, 251]),
    (0x1803, 2): ([1, 2, 240, 252, 253, 255, 254], [0, 241, 248, 251]),
    (0x1800, 3): ([1, 65535, 0], []),
    (0x1800, 5): ([1, 65535, 0], []),
    (0x2001, 0): ([250_000, 500_000, 800_000, 1_000_000, 125_000], [0, 125, 10_000, 20_000, 50_000, 100_000, 125_001, 0xFFFFFFFF]),
    (0x2002, 0): ([1, 126, NODE], [0, 127, 128, 254, 255]),
    (0x2102, 0): ([0, 253, 128], [254, 255]),
    (0x2104, 1): ([0, 65535, 10], [1, 9]),
    (0x2104, 4): ([10, 65535, 0], [1, 9]),
    (0x2105, 1): ([0, 7, 3], [8, 255]),
    (0x2106, 1): ([0, 1], [2, 255]),
    (0x2106, 2): ([7, 0], [8, 255]),
    (0x2106, 3): ([15, 0], [16, 255]),
    (0x2106, 4): ([127, 0], [128, 255]),
    (0x2106, 5): ([0, 255, 145], []),
    (0x2106, 6): ([31, 0], [32, 255]),
    (0x2106, 7): ([7, 0], [8, 255]),
    (0x2106, 8): ([0, 2046, 2047], [2048, 65535]),
    (0x3100, 2): ([0, 1], [2, 255]),
    (0x3110, 2): ([1, 0], [2, 255]),
    (0x3112, 1): ([1, 127], [0, -1, -128]),
    (0x3112, 2): ([-10, 10, -3], [-11, 11, 127, -128]),
    (0x3112, 3): ([127, 1], [0, -1, -128]),
    (0x3112, 4): ([-10, 10, 1], [-11, 11, 127, -128]),
    (0x3120, 1): ([0, 1], [2, -1, 127]),
    (0x3210, 0): ([2**31 - 1, -(2**31), 0], []),
    (0x3220, 0): ([2**31 - 1, -(2**31), 0], []),
}


def defaults(context: Context) -> None:
    """Size and factory value of every object."""
    with context.session() as session:
        for one in OBJECTS:
            if not one.readable:
                session.refused(f"{one}: read", p.WRITE_ONLY, session.upload, one.index, one.sub)
                continue
            value = session.upload(one.index, one.sub)
            expected = one.expected(NODE)
            if expected is not None:
                session.report.equal(f"{one}: default", expected, value)
            elif one.size is not None:
                session.report.equal(f"{one}: size", one.size, len(value))
        texts = {(0x1009, 0): r"\d\d", (0x100A, 0): r"\d{6}", (0x2000, 1): str(session.get(0x1018, 4))}
        for (index, sub), pattern in texts.items():
            text = session.upload(index, sub).decode()
            session.report.verdict(re.fullmatch(pattern, text) is not None, f"{TABLE[index, sub]}: text", pattern, text)


def access(context: Context) -> None:
    """A read-only object refuses a write; a setting accepts what is read from it."""
    with context.session() as session:
        for one in OBJECTS:
            if not one.writable:
                data = session.upload(one.index, one.sub)[: one.size or 4]
                session.refused(f"{one}: write", p.READ_ONLY, session.download, one.index, one.sub, data)
        for state in (p.ENTER_PRE_OPERATIONAL, p.START):
            session.nmt(state)
            for one in SETTINGS:
                if state == p.START and one.index in (0x1005, 0x1014):
                    continue  # written in pre-operational only
                code = session.abort_code(session.download, one.index, one.sub, session.upload(one.index, one.sub))
                session.report.equal(f"NMT command {state}: {one} written back", 0, code)
        for one in SETTINGS:
            if one.size > 1:
                session.refused(f"{one}: a byte less", p.SHORT, session.download, one.index, one.sub, bytes(one.size - 1))
            if one.size < 4:
                session.refused(f"{one}: a byte more", p.LONG, session.download, one.index, one.sub, bytes(one.size + 1))


def absent(context: Context) -> None:
    """Objects and sub-indices that the manual has not: no node guarding, no 1200h, no sub-index 4 of 180xh."""
    with context.session() as session:
        others = {0x1002, 0x1006, 0x100C, 0x100D, 0x1015, 0x1029, 0x1200, 0x1400, 0x1804, 0x1A04, 0x1F80, 0x6010, 0x6020}
        others |= {index + step for index in LISTED for step in (-1, 1)} - LISTED
        for index in sorted(others):
            session.refused(f"{index:04X}h: read", p.NO_OBJECT, session.upload, index)
            session.refused(f"{index:04X}h: write", p.NO_OBJECT, session.download, index, 0, b"\x00")
        for index in sorted(LISTED):
            subs = {one.sub for one in OBJECTS if one.index == index} | (set(range(1, 9)) if index == 0x1003 else set())
            for sub in ({max(subs) + 1, 127, 255} | ({4} if 0x1800 <= index < 0x1804 else set())) - subs:
                session.refused(f"{index:04X}h:{sub:02X}h: read", p.NO_SUB_INDEX, session.upload, index, sub)
                session.refused(f"{index:04X}h:{sub:02X}h: write", p.NO_SUB_INDEX, session.download, index, sub, b"\x00")
        session.send(p.ERROR_CONTROL + NODE, remote=True, dlc=1)
        session.quiet("node guarding is not answered")


def limits(context: Context) -> None:
    """What each setting accepts and refuses; a refused value changes nothing."""
    with context.session() as session:
        for (index, sub), (good, bad) in LIMITS.items():
            for value in good:
                session.accepted(f"{TABLE[index, sub]} = {value}", index, sub, value)
            for value in bad:
                session.refused(f"{TABLE[index, sub]} = {value}", p.RANGE, session.put, index, sub, value)
            session.reads(f"{TABLE[index, sub]} is unchanged", index, sub, good[-1])
        # 1 J1939, 2 CANopen (S17); the protocol changes at the restart.
        for value in (1, 2):
            session.accepted(f"3100h:01h = {value}", 0x3100, 1, value)
        for value in (0, 3, 255):
            session.refused(f"3100h:01h = {value}", p.INVALID_VALUE, session.put, 0x3100, 1, value)
        session.reads("3100h:01h is unchanged", 0x3100, 1, 2)
        for value in (0, 2, 255):
            session.refused(f"2010h:01h = {value}", p.INVALID_VALUE, session.put, 0x2010, 1, value)
        for value in (0, 4, -1, 127):
            session.refused(f"3200h = {value}", p.INVALID_VALUE, session.put, 0x3200, 0, value)
        low_pass(session)
        cob_ids(session)
        session.nmt(p.START)
        for index in (0x1005, 0x1014):
            session.refused(f"{index:04X}h in operational", p.DEVICE_STATE, session.put, index, 0, 0x85)


def low_pass(session: Session) -> None:
    """Type and frequency (S58): the write that would break the pair is refused."""
    for kind, good, bad in ((0, (100, 25000), ()), (1, (100, 25000), ()), (2, (100, 8000), (8001, 25000))):
        session.put(0x3111, 0, 2000)
        session.accepted(f"3110h:01h = {kind}", 0x3110, 1, kind)
        for value in good:
            session.accepted(f"type {kind}: 3111h = {value}", 0x3111, 0, value)
        for value in bad:
            session.refused(f"type {kind}: 3111h = {value}", p.INVALID_VALUE, session.put, 0x3111, 0, value)
        for value in (0, 99, 25001, 65535):
            session.refused(f"type {kind}: 3111h = {value}", p.RANGE, session.put, 0x3111, 0, value)
    session.put(0x3110, 1, 1)
    session.put(0x3111, 0, 8001)
    session.refused("type 2 at 8001 mHz", p.INVALID_VALUE, session.put, 0x3110, 1, 2)
    session.put(0x3111, 0, 8000)
    session.accepted("type 2 at 8000 mHz", 0x3110, 1, 2)
    session.refused("type 3", p.RANGE, session.put, 0x3110, 1, 3)


def cob_ids(session: Session) -> None:
    """The identifiers (S45, S46)."""
    own = session.get(0x1800, 1)
    session.refused("1800h:01h: another identifier while valid", p.INVALID_VALUE, session.put, 0x1800, 1, 0x1C0)
    session.refused("1800h:01h: 29 bits", p.INVALID_VALUE, session.put, 0x1800, 1, p.INVALID | 1 << 29 | 0x1C0)
    session.accepted("1800h:01h: disabled", 0x1800, 1, p.INVALID)
    for value in (0x000, 0x080, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF, 0x701, 0x7FF, 0x800):
        session.refused(f"1800h:01h = {value:03X}h", p.INVALID_VALUE, session.put, 0x1800, 1, value)
    for value in (p.NO_RTR | 0x1C0, p.INVALID | own, own):
        session.accepted(f"1800h:01h = {value:X}h", 0x1800, 1, value)
    for value in (0x85, 0x80):
        session.accepted(f"1005h = {value:X}h", 0x1005, 0, value)
    for value in (1 << 30 | 0x80, 1 << 29 | 0x80, 0x000, 0x7E5):
        session.refused(f"1005h = {value:X}h", p.INVALID_VALUE, session.put, 0x1005, 0, value)
    session.refused("1014h: bit 30", p.INVALID_VALUE, session.put, 0x1014, 0, p.INVALID | 1 << 30 | 0xB2)
    for value in (p.INVALID | 0xB2, 1 << 29 | 0x12345, p.INVALID | 0xB2, 0xB2):
        session.accepted(f"1014h = {value:X}h", 0x1014, 0, value)


def scan(context: Context) -> None:
    """No other object in the ranges of the manual."""
    with context.session() as session:
        ranges = ((0x1000, 0x1020), (0x1800, 0x1810), (0x1A00, 0x1A10), (0x2000, 0x2130), (0x3000, 0x3230), (0x6000, 0x6200))
        for first, last in ranges:
            found = [index for index in range(first, last) if session.abort_code(session.upload, index) != p.NO_OBJECT]
            expected = sorted(LISTED & set(range(first, last)))
            session.report.equal(f"objects in {first:04X}h..{last - 1:04X}h", expected, found)


def status(context: Context) -> None:
    """ST0 bit 2: the factory settings are in force (S65)."""
    with context.session() as session:
        for (index, sub), value in {(0x1017, 0): 100, (0x3111, 0): 3000, (0x3210, 0): 1, (0x1A01, 1): 0x65110008}.items():
            session.put(index, sub, value)
            session.reads(f"{TABLE[index, sub]} changed: ST0", 0x3000, 1, 0b001)
            session.put(index, sub, TABLE[index, sub].default)
            session.reads(f"{TABLE[index, sub]} as delivered: ST0", 0x3000, 1, 0b101)


def angles(context: Context) -> None:
    """Angles, zero point and offsets of the sensor with two axes (S8, S62)."""
    with context.session(scene="tilt=12.34,-5.67") as session:
        report = session.report
        report.equal("6110h and 6120h", (1234, -567), session.settle())
        for kind, expected in ((1, (0, -567)), (2, (0, 0))):
            session.put(0x3200, 0, kind)
            session.sleep(0.05)
            report.equal(f"3200h = {kind}", expected, session.slopes(wide=True))
        report.equal("3210h and 3220h hold the negative angle", (-1234, 567), (session.get(0x3210), session.get(0x3220)))
        session.put(0x3210, 0, 100)
        session.put(0x3220, 0, -200)
        session.sleep(0.05)
        report.equal("offsets are added", (1334, -767), session.slopes(wide=True))
        session.put(0x3200, 0, 3)
        session.sleep(0.05)
        report.equal("3200h = 3: both", (0, 0), session.slopes(wide=True))
        session.put(0x3210, 0, 2**31 - 1)
        session.put(0x3220, 0, -(2**31))
        session.sleep(0.05)
        report.equal("the sum saturates", (2**31 - 1, -(2**31)), session.slopes(wide=True))


def raw_values(context: Context) -> None:
    """Acceleration in 0.001 g and temperature in degC (S7, S63)."""
    with context.session(scene="tilt=30,0") as session:
        session.sleep(0.5)
        for index, expected in ((1, -500), (2, 0), (3, 866)):
            session.report.within(f"3010h:{index:02X}h", expected - 3, expected + 3, session.get(0x3010, index))
            session.report.within(f"{0x3010 + index:04X}h", expected - 3, expected + 3, session.get(0x3010 + index))
            session.report.within(f"3020h:{index:02X}h: at rest", -5, 5, session.get(0x3020, index))
        session.report.within("6511h", 20, 30, session.get(0x6511))


GROUPS = (defaults, access, absent, limits, scan, status, angles, raw_values)
