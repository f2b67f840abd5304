"""IMS360: SDO block transfer in both directions (CiA 301, 7.2.4.3.8 to 7.2.4.3.16, S74)."""

import binascii

from . import protocol as p
from .ims360_objects import NODE, OBJECTS, TABLE
from .runner import Context
from .session import Abort, Session, initiate

START, END = bytes([0xA3]), bytes([0xA1])


def crc(data: bytes) -> int:
    """CRC-16 with the polynomial 1021h that starts at 0."""
    return binascii.crc_hqx(data, 0)


def initiate_upload(session: Session, index: int, sub: int, size: int) -> int:
    """Initiates an upload in blocks of `size` segments; returns the number of bytes."""
    reply = session.exchange(initiate(0xA4, index, sub, bytes([size, 0])))
    session.report.equal(f"{index:04X}h:{sub:02X}h: size and CRC are offered", 0xC6, reply[0])
    return p.decode(reply[4:])


def segments(session: Session, count: int) -> list[bytes]:
    """The next segments."""
    frames = [session.wait_id(p.SDO_REPLY) for _ in range(count)]
    return [frame.data if frame else b"" for frame in frames]


def upload(session: Session, index: int, sub: int, size: int = 127) -> bytes:
    """Reads an object by block upload, checks its CRC and returns it."""
    length = initiate_upload(session, index, sub, size)
    session.send(p.SDO_REQUEST + NODE, START.ljust(8, b"\x00"))
    value, done = b"", False
    while True:
        left = max(1, -(-(length - len(value)) // 7))
        block = segments(session, min(size, left))
        for place, segment in enumerate(block, 1):
            done = bool(segment[0] & 0x80)
            if segment[0] & 0x7F != place:
                session.report.equal("number of the segment", place, segment[0] & 0x7F)
            value += segment[1:]
        acknowledge = bytes([0xA2, len(block), size])
        if done:
            break
        session.send(p.SDO_REQUEST + NODE, acknowledge.ljust(8, b"\x00"))
    reply = session.exchange(acknowledge)
    value = value[: len(value) - (reply[0] >> 2 & 7)]
    session.report.equal(f"{index:04X}h:{sub:02X}h: end and CRC", (0xC1, crc(value)), (reply[0] & 0xE3, p.decode(reply[1:3])))
    session.send(p.SDO_REQUEST + NODE, END.ljust(8, b"\x00"))
    return value


def download(session: Session, index: int, sub: int, value: bytes, *, wrong_crc: int = 0) -> None:
    """Writes an object by block download."""
    reply = session.exchange(initiate(0xC6, index, sub, p.encode(len(value), 4)))
    session.report.equal(f"{index:04X}h:{sub:02X}h: CRC is offered", 0xA4, reply[0])
    size = reply[4]
    parts = [value[at : at + 7] for at in range(0, len(value), 7)]
    for first in range(0, len(parts), size):
        block = parts[first : first + size]
        for place, part in enumerate(block, 1):
            last = first + place == len(parts)
            session.send(p.SDO_REQUEST + NODE, bytes([place | (0x80 if last else 0)]) + part.ljust(7, b"\x00"))
        reply = session.wait_id(p.SDO_REPLY)
        session.report.equal("block acknowledged", (0xA2, len(block)), tuple(reply.data[:2]) if reply else None)
        size = reply.data[2]
    unused = 7 - len(parts[-1])
    reply = session.exchange(bytes([0xC1 | unused << 2]) + p.encode(crc(value) ^ wrong_crc, 2))
    session.report.equal("download ended", 0xA1, reply[0])


def both_ways(context: Context) -> None:
    """Every object is read in a block as it is read otherwise; a setting is written in a block."""
    with context.session() as session:
        for one in OBJECTS:
            if one.readable and not 0x2020 <= one.index < 0x3080 and one.index != 0x6511:
                session.report.equal(f"{one}: block upload", session.upload(one.index, one.sub), upload(session, one.index, one.sub))
        for index, sub, value in ((0x1017, 0, 500), (0x3210, 0, -123456), (0x3112, 2, -10), (0x1A01, 1, 0x61100020)):
            session.report.equal(
                f"{TABLE[index, sub]}: block download", 0, session.abort_code(download, session, index, sub, p.encode(value, TABLE[index, sub].size))
            )
            session.reads(f"{TABLE[index, sub]}: written", index, sub, value)
        session.put(0x1017, 0, 0)


def errors(context: Context) -> None:
    """The aborts; none of them changes anything, and the next transfer works."""
    with context.session() as session:
        for size in (0, 128, 255):
            session.refused(f"upload: block of {size}", p.BLOCK_SIZE, session.exchange, initiate(0xA4, 0x1008, 0, bytes([size, 0])))
        session.refused("upload: no such object", p.NO_OBJECT, initiate_upload, session, 0x1002, 0, 127)
        session.refused("upload: no such sub-index", p.NO_SUB_INDEX, initiate_upload, session, 0x1018, 5, 127)
        session.refused("upload: write-only", p.WRITE_ONLY, initiate_upload, session, 0x3200, 0, 127)
        session.refused("download: read-only", p.READ_ONLY, download, session, 0x6110, 0, bytes(4))
        session.refused("download: too long", p.LONG, download, session, 0x1017, 0, bytes(3))
        session.refused("download: too short", p.SHORT, download, session, 0x3210, 0, bytes(3))
        session.refused("download: a value that is not permitted", p.INVALID_VALUE, download, session, 0x1017, 0, p.encode(5, 2))
        session.refused("download: wrong CRC", p.CRC_ERROR, wrong_crc, session)
        session.reads("1017h is unchanged", 0x1017, 0, 0)
        lost_segment(session)
        repeated(session)


def wrong_crc(session: Session) -> None:
    """A download with a wrong CRC."""
    download(session, 0x1017, 0, p.encode(500, 2), wrong_crc=1)


def lost_segment(session: Session) -> None:
    """A download whose segment has a wrong number: 0 are acknowledged, and the block is repeated."""
    session.exchange(initiate(0xC6, 0x1017, 0, p.encode(2, 4)))
    request = p.SDO_REQUEST + NODE
    value = p.encode(400, 2)
    session.send(request, bytes([0x80 | 2]) + value.ljust(7, b"\x00"))
    frame = session.wait_id(p.SDO_REPLY, 2.0)
    session.report.equal("a segment is missing: 0 acknowledged", (0xA2, 0), tuple(frame.data[:2]) if frame else None)
    session.send(request, bytes([0x80 | 1]) + value.ljust(7, b"\x00"))
    frame = session.wait_id(p.SDO_REPLY)
    session.report.equal("repeated: 1 acknowledged", (0xA2, 1), tuple(frame.data[:2]) if frame else None)
    reply = session.exchange(bytes([0xC1 | 5 << 2]) + p.encode(crc(value), 2))
    session.report.equal("repeated: ended", 0xA1, reply[0])
    session.reads("repeated: written", 0x1017, 0, 400)
    session.put(0x1017, 0, 0)


def repeated(session: Session) -> None:
    """An upload whose segment is not acknowledged: the segment is sent again. Then the client stops in the middle."""
    length = initiate_upload(session, 0x1008, 0, 1)
    session.report.equal("1008h: size", 6, length)
    session.send(p.SDO_REQUEST + NODE, START.ljust(8, b"\x00"))
    expected = b"\x81IMS360\x00"
    for name in ("segment", "repeated segment"):
        (segment,) = segments(session, 1)
        session.report.equal(name, expected, segment)
        session.send(p.SDO_REQUEST + NODE, bytes([0xA2, 0, 1]).ljust(8, b"\x00"))
    segments(session, 1)
    session.report.equal("a new transfer in the middle", b"IMS360", session.upload(0x1008))


def refused_by_client(context: Context) -> None:
    """An abort of the client in each phase; the next transfer works."""
    with context.session() as session:
        abort = initiate(0x80, 0x1008, 0, p.encode(0x08000000, 4))
        for phase in range(3):
            initiate_upload(session, 0x1008, 0, 127)
            if phase:
                session.send(p.SDO_REQUEST + NODE, START.ljust(8, b"\x00"))
                segments(session, 1)
            if phase == 2:
                session.exchange(bytes([0xA2, 1, 127]))
            session.send(p.SDO_REQUEST + NODE, abort)
            session.quiet(f"abort in phase {phase}: no answer")
            session.report.equal(f"abort in phase {phase}: the next transfer", b"IMS360", upload(session, 0x1008, 0))
        try:
            session.exchange(START)
            code = 0
        except Abort as aborted:
            code = aborted.code
        session.report.equal("start without an upload", f"{p.UNKNOWN_COMMAND:08X}", f"{code:08X}")


GROUPS = (both_ways, errors, refused_by_client)
