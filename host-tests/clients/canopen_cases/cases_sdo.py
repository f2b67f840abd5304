"""SDO transfers as frames: expedited, in segments, aborted, malformed (CiA 301, 7.2.4)."""

from gemac.harness import EXTENDED

from . import protocol as p
from .runner import Context
from .session import Session, initiate


def frame(session: Session, name: str, request: str, expected: str) -> None:
    """Sends one frame and compares the complete answer; both in hexadecimal, filled with zeros."""
    answer = session.sdo(bytes.fromhex(request))
    wanted = bytes.fromhex(expected).ljust(8, b"\x00").hex()
    session.report.equal(name, wanted, answer.hex() if answer else None)


def aborts(session: Session, name: str, request: bytes, codes: int | set[int], index: int | None = None) -> None:
    """Sends one frame that is answered with an abort, and checks the index in it."""
    session.refused(name, codes, session.exchange, request)
    if index is not None:
        answer = session.sdo(request)
        named = answer[1:3].hex() if answer else None
        session.report.equal(f"{name}: the abort contains the index", p.encode(index, 2).hex(), named)


def alive(session: Session, name: str) -> None:
    """Checks that the server accepts the next transfer."""
    session.report.equal(name, 0x0004019A, session.get(0x1000))


def download_without_size(session: Session, index: int, data: bytes) -> None:
    """A download in segments without the size in the first frame."""
    session.download_segments(index, 0, data, with_size=False)


def expedited(context: Context) -> None:
    """Complete frames of expedited transfers; reserved bytes are zero."""
    with context.session() as session:
        frame(session, "upload of u32", "40 00 10 00", "43 00 10 00 9a 01 04 00")
        frame(session, "upload of u16", "40 01 20 00", "4b 01 20 00 7d 00")
        frame(session, "upload of u8", "40 00 20 00", "4f 00 20 00 0a")
        frame(session, "upload of an element of an array", "40 18 10 01", "43 18 10 01 00 69 66 6d")
        frame(session, "download of u8", "2f 43 20 00 01", "60 43 20 00")
        frame(session, "download of u16", "2b 0c 10 00 e8 03", "60 0c 10 00")
        frame(session, "download of u32", "23 05 10 00 80 00 00 00", "60 05 10 00")
        frame(session, "download without a size", "22 0c 10 00 d0 07 00 00", "60 0c 10 00")
        session.reads("download without a size: the size of the object is used", 0x100C, 0, 2000)
        frame(session, "abort of an unknown object", "40 04 10 00", "80 04 10 00 00 00 02 06")
        frame(session, "abort of an unknown sub-index", "40 00 10 01", "80 00 10 01 11 00 09 06")
        frame(session, "abort of a write to a constant", "23 00 10 00 00 00 00 00", "80 00 10 00 02 00 01 06")
        frame(session, "unused bytes are ignored", "40 00 10 00 ff ff ff ff", "43 00 10 00 9a 01 04 00")


def lengths(context: Context) -> None:
    """Data of the wrong length."""
    with context.session() as session:
        for index, size in ((0x2043, 1), (0x100C, 2), (0x1005, 4)):
            before = session.get(index)
            for length in range(1, 5):
                if length != size:
                    codes = p.LONG if length > size else p.SHORT
                    name = f"{index:04X}h: {length} bytes for {size}"
                    session.refused(name, codes, session.download, index, 0, bytes(length))
            session.refused(f"{index:04X}h: 8 bytes in segments", p.LONG, session.download_segments, index, 0, bytes(8))
            for data, codes in ((bytes(8), p.LONG), (b"", p.SHORT)):
                name = f"{index:04X}h: {len(data)} bytes in segments, without the size"
                session.refused(name, codes, download_without_size, session, index, data)
            session.reads(f"{index:04X}h: unchanged", index, 0, before)
        session.exchange(initiate(0x21, 0x100C, 0, p.encode(2, 4)))
        session.refused("size 2 bytes, sent 1", p.SHORT, session.exchange, bytes([0x0D, 0x05]))
        session.exchange(initiate(0x21, 0x100C, 0, p.encode(2, 4)))
        session.refused("size 2 bytes, sent 3", p.LONG, session.exchange, bytes([0x09, 0x05, 0x06, 0x07]))
        session.reads("100Ch: unchanged", 0x100C, 0, 0)
        alive(session, "after wrong lengths")


def segmented_upload(context: Context) -> None:
    """Objects of more than 4 bytes, their frames and the toggle bit."""
    with context.session() as session:
        frame(session, "1008h: the size in the first frame", "40 08 10 00", "41 08 10 00 06")
        frame(session, "1008h: one segment", "60", "03" + b"JN2101".hex())
        frame(session, "3000h: the size in the first frame", "40 00 30 00", "41 00 30 00 10")
        frame(session, "3000h: first segment", "60", "00" + b"D0UfZEg".hex())
        frame(session, "3000h: second segment", "70", "10" + b"RKHAI5A".hex())
        frame(session, "3000h: last segment", "60", "0b" + b"g=".hex())
        aborts(session, "a segment after the last", b"\x70", p.UNKNOWN_COMMAND)
        session.exchange(initiate(0x40, 0x3000, 0))
        aborts(session, "first segment with toggle 1", b"\x70", p.TOGGLE)
        aborts(session, "the transfer has ended", b"\x60", p.UNKNOWN_COMMAND)
        session.exchange(initiate(0x40, 0x3000, 0))
        session.exchange(b"\x60")
        aborts(session, "second segment with toggle 0", b"\x60", p.TOGGLE)
        alive(session, "after a wrong toggle bit")
        session.exchange(initiate(0x40, 0x3000, 0))
        frame(session, "a new upload during an upload", "40 08 10 00", "41 08 10 00 06")
        frame(session, "the new upload continues", "60", "03" + b"JN2101".hex())
        session.exchange(initiate(0x40, 0x3000, 0))
        frame(session, "a download during an upload", "2f 43 20 00 03", "60 43 20 00")
        aborts(session, "the upload has ended", b"\x60", p.UNKNOWN_COMMAND)
        session.exchange(initiate(0x40, 0x3000, 0))
        aborts(session, "a download segment during an upload", b"\x00", p.UNKNOWN_COMMAND)


def segmented_download(context: Context) -> None:
    """Small objects and the programming key in segments."""
    with context.session() as session:
        for name, index, size, value in (
            ("heartbeat time", 0x1017, 2, 0),
            ("guard time", 0x100C, 2, 1234),
            ("life time factor", 0x100D, 1, 3),
            ("SYNC COB-ID", 0x1005, 4, 0x81),
        ):
            for with_size in (True, False):
                session.put(index, 0, p.BY_KEY[index, 0].default)
                session.download_segments(index, 0, p.encode(value, size), with_size=with_size)
                session.reads(f"{name} in a segment, {'with' if with_size else 'without'} the size", index, 0, value)
        frame(session, "initiate", "21 0c 10 00 02", "60 0c 10 00")
        frame(session, "a segment", "0b 34 12", "20")
        session.reads("the value", 0x100C, 0, 0x1234)
        frame(session, "initiate of 16 bytes", "21 00 30 00 10", "60 00 30 00")
        frame(session, "first segment", "00" + b"D0UfZEg".hex(), "20")
        frame(session, "second segment", "10" + b"RKHAI5A".hex(), "30")
        frame(session, "last segment", "0b" + b"g=".hex(), "20")
        for step, toggle in (("first", 0x10), ("second", 0x00)):
            session.exchange(initiate(0x21, 0x3000, 0, p.encode(16, 4)))
            if step == "second":
                session.exchange(b"\x00D0UfZEg")
            aborts(session, f"{step} segment with the wrong toggle bit", bytes([toggle]) + b"D0UfZEg", p.TOGGLE)
            aborts(session, "the transfer has ended", b"\x10RKHAI5A", p.UNKNOWN_COMMAND)
        session.exchange(initiate(0x21, 0x100C, 0, p.encode(2, 4)))
        alive(session, "an upload during a download")
        aborts(session, "the download has ended", bytes([0x0B, 1, 2]), p.UNKNOWN_COMMAND)
        session.exchange(initiate(0x21, 0x100C, 0, p.encode(2, 4)))
        session.exchange(initiate(0x21, 0x100D, 0, p.encode(1, 4)))
        frame(session, "a new download during a download", "0d 09", "20")
        session.reads("the new download is written", 0x100D, 0, 9)
        session.reads("the old download changed nothing", 0x100C, 0, 0x1234)
        session.refused("read-only object in segments", p.READ_ONLY, session.download_segments, 0x1008, 0, b"JN21012")
        session.refused("absent object in segments", p.NO_OBJECT, session.download_segments, 0x2003, 0, b"x" * 8)
        session.refused("absent sub-index in segments", p.NO_SUB_INDEX, session.download_segments, 0x1008, 1, b"x" * 8)


def aborted_by_client(context: Context) -> None:
    """An abort by the client ends the transfer and is not answered."""
    with context.session() as session:
        for name, begin, follow in (
            ("upload", initiate(0x40, 0x3000, 0), b"\x60"),
            ("download", initiate(0x21, 0x100C, 0, p.encode(2, 4)), bytes([0x0B, 1, 2])),
        ):
            session.exchange(begin)
            session.send(p.SDO_REQUEST + session.node, initiate(0x80, 0x3000, 0, p.encode(0x08000000, 4)))
            session.quiet(f"abort during {name} is not answered")
            aborts(session, f"{name} has ended", follow, p.UNKNOWN_COMMAND)
        session.send(p.SDO_REQUEST + session.node, initiate(0x80, 0x1000, 0, p.encode(0x08000000, 4)))
        session.quiet("abort without a transfer is not answered")
        session.reads("100Ch unchanged", 0x100C, 0, 0)


def unknown_commands(context: Context) -> None:
    """Unknown command specifiers, including block transfer."""
    with context.session() as session:
        for name, request in (
            ("block upload", initiate(0xA4, 0x1008, 0, bytes([127, 0]))),
            ("block upload without CRC", initiate(0xA0, 0x1000, 0, bytes([127, 0]))),
            ("block download", initiate(0xC6, 0x1017, 0, p.encode(2, 4))),
            ("block download without CRC", initiate(0xC2, 0x1017, 0, p.encode(2, 4))),
            ("command 7", initiate(0xE0, 0x1000, 0)),
        ):
            aborts(session, name, request, p.UNKNOWN_COMMAND)
            alive(session, f"after {name}")
        aborts(session, "upload segment without a transfer", b"\x60", p.UNKNOWN_COMMAND)
        aborts(session, "download segment without a transfer", b"\x00", p.UNKNOWN_COMMAND)
        session.exchange(initiate(0x40, 0x3000, 0))
        aborts(session, "block upload during an upload", initiate(0xA4, 0x1008, 0, bytes([127])), p.UNKNOWN_COMMAND)
        alive(session, "after that")
        aborts(session, "unknown object", initiate(0x40, 0x1004, 0), p.NO_OBJECT, 0x1004)
        aborts(session, "read-only object", initiate(0x23, 0x1018, 1), p.READ_ONLY, 0x1018)


def malformed(context: Context) -> None:
    """Frames that are not SDO requests are ignored."""
    with context.session() as session:
        request, write = initiate(0x40, 0x1000, 0), initiate(0x2F, 0x2043, 0, b"\x01")
        mine = p.SDO_REQUEST + session.node
        for length in range(8):
            session.send(mine, request[:length])
            session.send(mine, write[:length])
        session.quiet("frames of fewer than 8 bytes")
        for data in (request, write):
            session.send(mine | EXTENDED, data)
            for node in (0, 1, session.node - 1, session.node + 1, 127):
                session.send(p.SDO_REQUEST + node, data)
            session.send(p.SDO_REPLY + session.node, data)
        session.quiet("29-bit frames, and SDOs of other nodes")
        for dlc in range(9):
            session.send(mine, remote=True, dlc=dlc)
            session.send(mine | EXTENDED, remote=True, dlc=dlc)
        session.quiet("remote frames")
        session.exchange(initiate(0x40, 0x3000, 0))
        session.send(mine, b"\x60")
        session.send(mine | EXTENDED, b"\x60".ljust(8, b"\x00"))
        session.send(mine, remote=True, dlc=8)
        session.quiet("all of them during a transfer")
        frame(session, "the transfer continues", "60", "00" + b"D0UfZEg".hex())
        session.reads("nothing was written", 0x2043, 0, 2)


def resets(context: Context) -> None:
    """A reset ends a transfer."""
    with context.session() as session:
        for command in (p.RESET_COMMUNICATION, p.RESET_NODE):
            session.exchange(initiate(0x40, 0x3000, 0))
            session.reset(command)
            aborts(session, f"command {command}: the transfer has ended", b"\x60", p.UNKNOWN_COMMAND)


def stopped(context: Context) -> None:
    """There is no SDO in stopped, also no time-out and no further segments of an earlier transfer."""
    with context.session() as session:
        session.exchange(initiate(0x40, 0x3000, 0))
        session.nmt(p.STOP)
        session.send(p.SDO_REQUEST + session.node, b"\x60".ljust(8, b"\x00"))
        session.quiet("an earlier transfer: no frame in stopped", 3.0)
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        alive(session, "pre-operational again")


def pause(context: Context) -> None:
    """After a pause of the client, the transfer continues or is aborted with the time-out; then the server is free again."""
    with context.session() as session:
        session.exchange(initiate(0x40, 0x3000, 0))
        session.sleep(0.3)
        frame(session, "a pause of 0.3 s", "60", "00" + b"D0UfZEg".hex())
        session.others.clear()
        abort = session.wait_id(p.SDO_REPLY, 6.0)
        if abort:
            got = f"{p.decode(abort.data[4:]):08X}h"
            session.report.equal("a pause of 6 s: aborted with the time-out", f"{p.TIME_OUT:08X}h", got)
        else:
            frame(session, "a pause of 6 s: the transfer continues", "70", "10" + b"RKHAI5A".hex())
        alive(session, "after the pause")


def burst(context: Context) -> None:
    """500 transfers, one after the other without a pause, are all answered in order."""
    with context.session() as session:
        wanted = []
        for number in range(500):
            session.send(p.SDO_REQUEST + session.node, initiate(0x2B, 0x100C, 0, p.encode(number, 2)))
            session.send(p.SDO_REQUEST + session.node, initiate(0x40, 0x100C, 0))
            wanted += [initiate(0x60, 0x100C, 0), initiate(0x4B, 0x100C, 0, p.encode(number, 2))]
        got = [frame.data for frame in session.tester.take(1000, 20.0)]
        right = sum(a == b for a, b in zip(wanted, got, strict=False))
        session.report.equal("1000 requests in a burst: correct answers", 1000, right)


GROUPS = (
    expedited,
    lengths,
    segmented_upload,
    segmented_download,
    aborted_by_client,
    unknown_commands,
    malformed,
    resets,
    stopped,
    pause,
    burst,
)
