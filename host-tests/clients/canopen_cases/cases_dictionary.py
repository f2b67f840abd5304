"""The object dictionary: every object of the manual's lists with type, access, default and limits (sections 7.6 and 7.7)."""

import re

from . import protocol as p
from .runner import Context

# Values that a setting accepts and refuses (sections 7.6 and 7.7; 2.3 of CiA 301 for the transmission type).
LIMITS: dict[tuple[int, int], tuple[list[int], list[int]]] = {
    (0x100C, 0): ([1, 65535], []),
    (0x100D, 0): ([1, 255], []),
    (0x1015, 0): ([1, 65535], []),
    (0x1017, 0): ([65535], []),
    (0x1029, 1): ([1, 2], [3, 127, 128, 255]),
    (0x1800, 2): ([0, 2, 240, 252, 253, 254, 255], [241, 248, 251]),
    (0x1801, 2): ([0, 2, 240, 252, 253, 254, 255], [241, 248, 251]),
    (0x1800, 3): ([1, 65535], []),
    (0x1801, 3): ([1, 65535], []),
    (0x1800, 5): ([0, 1, 65535], []),
    (0x1801, 5): ([0, 1, 65535], []),
    (0x2000, 0): ([1, 2, 127], [0, 128, 255]),
    (0x2001, 0): ([10, 20, 50, 250, 500, 800, 1000], [0, 1, 100, 124, 126, 62, 65535]),
    (0x2002, 0): ([], [2, 255]),
    (0x2040, 0): ([0, 2], [3, 255]),
    (0x2041, 0): ([0], [2, 255]),
    (0x2042, 0): ([], [3, 255]),
    (0x2043, 0): ([0, 1, 3, 4], [5, 255]),
    (0x2044, 0): ([1, 2, 3], [4, 255]),
    (0x2045, 0): ([0], [2, 255]),
    (0x2046, 0): ([], [3, 255]),
    (0x207F, 0): ([], [2, 255]),
    (0x4004, 1): ([], [2, 255]),
    (0x6000, 0): ([1, 100, 1000], [0, 2, 9, 11, 10000, 65535]),
}


def defaults(context: Context) -> None:
    """Type and factory value of every object."""
    with context.session() as session:
        for entry in p.OBJECTS:
            value = session.upload(entry.index, entry.sub)
            expected = entry.expected()
            if expected is not None:
                session.report.equal(f"{entry}: default", expected, value)
            elif entry.size is not None:
                session.report.equal(f"{entry}: size", entry.size, len(value))
        for index, name in ((0x1009, "hardware"), (0x100A, "software")):
            text = session.upload(index).decode()
            good = re.fullmatch(r"\d+\.\d+\.\d+", text) is not None
            session.report.verdict(good, f"{index:04X}h: {name} version", "X.Y.Z", text)


def access(context: Context) -> None:
    """Read-only objects refuse every write, except that a fixed mapping accepts its own value; all others accept theirs."""
    with context.session() as session:
        before = session.snapshot()
        for entry in p.OBJECTS:
            if not entry.writable:
                data = (session.upload(entry.index, entry.sub) + bytes(4))[:4]
                data = data[: entry.size or 4]
                if entry.index in (0x1A00, 0x1A01):
                    data = bytes([data[0] ^ 1]) + data[1:]
                session.refused(f"{entry}: write", p.READ_ONLY, session.download, entry.index, entry.sub, data)
        for entry in p.SETTINGS:
            value = session.upload(entry.index, entry.sub)
            code = session.abort_code(session.download, entry.index, entry.sub, value)
            session.report.equal(f"{entry}: its own value is accepted", 0, code)
        session.report.equal("nothing has changed", before, session.snapshot())


def absent(context: Context) -> None:
    """Missing objects and sub-indices."""
    with context.session() as session:
        for index in (0x0000, 0x0001, 0x0FFF, 0x1004, 0x1201, 0x1280, 0x1400, 0x1600, 0x1802, 0x1A02, 0x2003, 0x3001, 0x5FFF,
                      0x6012, 0x67FF, 0xFFFF):  # fmt: skip
            session.refused(f"{index:04X}h: read", p.NO_OBJECT, session.upload, index)
            session.refused(f"{index:04X}h: write", p.NO_OBJECT, session.download, index, 0, b"\x00")
        wrong = {index: 1 for index in p.LISTED if not any((index, sub) in p.BY_KEY for sub in (1, 2))}
        wrong |= {0x1003: 51, 0x1010: 2, 0x1011: 2, 0x1018: 5, 0x1029: 2, 0x1200: 3, 0x1800: 4, 0x1801: 6, 0x1A00: 3, 0x1A01: 3}
        wrong |= {0x4004: 3}
        for index, sub in sorted(wrong.items()):
            session.refused(f"{index:04X}h:{sub:02X}h: read", p.NO_SUB_INDEX, session.upload, index, sub)
            session.refused(f"{index:04X}h:FFh: read", p.NO_SUB_INDEX, session.upload, index, 255)
            session.refused(f"{index:04X}h:FFh: write", p.NO_SUB_INDEX, session.download, index, 255, b"\x00")


def scan(context: Context) -> None:
    """There are no other objects than those of the manual."""
    with context.session() as session:
        found = set()
        for index in [*range(0x1000, 0x1030), *range(0x1200, 0x1300), *range(0x1400, 0x1410), *range(0x1600, 0x1610),
                      *range(0x1800, 0x1810), *range(0x1A00, 0x1A10), *range(0x1F50, 0x1F90), *range(0x2000, 0x2090),
                      *range(0x3000, 0x3010), *range(0x4000, 0x40C0), *range(0x6000, 0x6130)]:  # fmt: skip
            if session.abort_code(session.upload, index) != p.NO_OBJECT:
                found.add(index)
        session.report.equal("existing objects", hexadecimal(p.LISTED), hexadecimal(found))


def hexadecimal(indices: set[int]) -> str:
    """Indices as text."""
    return " ".join(f"{index:04X}" for index in sorted(indices))


def limits(context: Context) -> None:
    """Every setting accepts its limits, and refuses the values beyond them without a change."""
    with context.session() as session:
        for (index, sub), (good, bad) in LIMITS.items():
            name = p.BY_KEY[index, sub]
            before = session.get(index, sub)
            for value in bad:
                session.refused(f"{name} = {value}", p.RANGE, session.put, index, sub, value)
            session.reads(f"{name}: refused values change nothing", index, sub, before)
            for value in good:
                session.accepted(f"{name} = {value}", index, sub, value)
            if index not in p.ACTIONS:
                session.accepted(f"{name} = {before} again", index, sub, before)
        for index in (0x2042, 0x2046):
            session.put(index, 0, 0)
            session.reads(f"{index:04X}h = 0: no change", index, 0, 2)


def sync_identifier(context: Context) -> None:
    """1005h: a consumer only, 11 bit, and none of the restricted identifiers (CiA 301, 7.5.2.5 and 7.3.5)."""
    with context.session() as session:
        for value in (0x081, 0x0FF, 0x100, 0x19F, 0x57F, 0x6DF, 0x080):
            session.accepted(f"1005h = {value:08X}h", 0x1005, 0, value)
        for value in (0x40000080, 0x00000001, 0x0000007F, 0x00000101, 0x00000180, 0x0000058A, 0x0000060A, 0x000006FF,
                      0x0000070A, 0x00000780, 0x000007FF, 0x00000000):  # fmt: skip
            session.refused(f"1005h = {value:08X}h", p.RANGE, session.put, 0x1005, 0, value)
        session.reads("1005h: refused values change nothing", 0x1005, 0, 0x80)


GROUPS = (defaults, access, absent, scan, limits, sync_identifier)
