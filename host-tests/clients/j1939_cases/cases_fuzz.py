"""Random frames: nothing stops the node, and what is invalid changes nothing."""

import random

from canopen_cases.ims360_objects import COMMANDS
from canopen_cases.runner import Context

from . import protocol as p
from .cases_switch import everything
from .session import Node

SEED = 1939
COUNT = 1500


def still_there(session: Node, name: str) -> None:
    """The node answers requests, parameters and a transport."""
    session.report.equal(f"{name}: the process runs", True, session.sensor.running)
    session.wait(lambda frame: False, 1.5)  # open transfers time out
    session.tester.collect_until_quiet(0.2, 3.0)
    session.others.clear()
    session.tx(session.request(p.CLAIMED, p.GLOBAL))
    frame = session.wait_pgn(p.CLAIMED)
    session.report.verdict(frame is not None, f"{name}: a claim", "an address", str(frame))
    if frame is None:
        return
    session.address = p.split(frame).source
    session.wait_online()
    session.report.equal(f"{name}: 1000h", 0x0704019A, session.get(0x1000))
    session.others.clear()
    session.tx(session.request(p.COMPONENT))
    opened = session.wait(lambda frame: p.split(frame).pgn == p.TP_CM and p.split(frame).destination == p.ME)
    session.report.verdict(opened is not None and opened.data[0] == 16, f"{name}: RTS", "RTS", str(opened))


def random_line(session: Node, generator: random.Random) -> str:
    """A frame that must not change a parameter or the address."""
    us, data = session.address, generator.randbytes(generator.randrange(9))
    other = generator.choice([a for a in range(254) if a != us])
    kind = generator.randrange(9)
    if kind == 0:
        return p.shown(p.REQUEST, other, generator.randbytes(generator.randrange(9)), generator.choice([us, p.GLOBAL]))
    if kind == 1:
        return p.shown(
            p.REQUEST,
            other,
            p.pgn_bytes(generator.choice([p.CLAIMED, p.COMPONENT, p.ECU, p.DM1, *p.PROCESS])),
            generator.choice([us, p.GLOBAL]),
        )
    if kind == 2:
        pgn = generator.choice([p.COMPONENT, p.ECU, p.DM1])
        return p.shown(
            p.TP_CM,
            other,
            bytes([generator.choice([16, 17, 19, 32, 255, generator.randrange(256)])])
            + generator.randbytes(4)
            + p.pgn_bytes(pgn),
            us,
            7,
        )
    if kind == 3:
        return p.shown(p.TP_DT, other, data, generator.choice([us, p.GLOBAL]), 7)
    if kind == 4:
        # Reads, segments and blocks of reads, aborts; never a download.
        command = generator.choice([one for one in range(256) if one >> 5 not in (0, 1, 6)])
        return p.shown(p.PROPRIETARY_A, other, (bytes([command]) + data).ljust(8, b"\0")[: generator.choice([8, 8, 8, 5])], us)
    if kind == 5:
        return p.claim(other, generator.randbytes(8))
    if kind == 6:
        return p.claim(us, b"\xff" * 7 + bytes([generator.randrange(0x80, 256)]))
    if kind == 7:
        number = generator.randrange(1 << 29)
        if number >> 16 & 0xFF in (0xEE, 0xEF, 0xEC, 0xEB) or number >> 8 & 0xFFFF == p.COMMANDED:
            number ^= 1 << 25 if not number & 1 << 25 else 0
        return f"{number:08X}#{data.hex().upper()}"
    return f"{generator.randrange(0x800):03X}#{data.hex().upper()}"


def invalid_frames(context: Context) -> None:
    """1500 frames that must change nothing."""
    generator = random.Random(SEED)
    with Node(context) as session:
        before = everything(session)
        for number in range(COUNT):
            session.tx(random_line(session, generator))
            if number % 20 == 0:
                session.tester.collect_until_quiet(0.01, 0.2)
        still_there(session, f"{COUNT} invalid frames")
        session.report.equal(f"{COUNT} invalid frames: the address", p.PREFERRED, session.address)
        session.report.equal(f"{COUNT} invalid frames: all values", before, everything(session))


def random_frames(context: Context) -> None:
    """1500 frames of any kind, claims that win and Commanded Address too; then a restart has the stored values."""
    generator = random.Random(SEED + 1)
    with Node(context) as session:
        before = everything(session)
        objects = [
            one for key, one in p.TABLE.items() if key not in COMMANDS and key != p.SWITCH and one.index not in (0x1010, 0x1011)
        ]
        for number in range(COUNT):
            kind = generator.randrange(5)
            us, other = session.address, generator.randrange(254)
            if kind == 0:
                one = generator.choice(objects)
                data = (
                    bytes([generator.choice([0x2F, 0x2B, 0x23, 0x22, 0x21, 0x20, 0x40, 0xC6, 0xA4])])
                    + one.index.to_bytes(2, "little")
                    + bytes([one.sub])
                )
                session.tx(p.shown(p.PROPRIETARY_A, other, data + generator.randbytes(4), us))
            elif kind == 1 and number % 20 == 1:
                session.tx(p.claim(us, generator.randbytes(8)))
            elif kind == 2 and number % 20 == 2:
                body = p.OURS.data + bytes([generator.randrange(256)])
                session.tx(p.bam(other, p.COMMANDED, 9), *p.packets(other, p.GLOBAL, body))
            else:
                session.tx(random_line(session, generator))
            if number % 20 == 0:
                for frame in session.tester.collect_until_quiet(0.01, 0.2):
                    parts = p.split(frame)
                    if parts and parts.pgn == p.CLAIMED and parts.source != p.NULL:
                        session.address = parts.source
        session.wait(lambda frame: False, 0.5)
        still_there(session, f"{COUNT} random frames")
        session.address = p.PREFERRED
        session.power_cycle()
        session.report.equal("after power off and on: all values", before, everything(session))


def bursts(context: Context) -> None:
    """Frames without a pause: none of them stops the node."""
    generator = random.Random(SEED + 2)
    with Node(context, {(0x2104, sub): 10 for sub in (1, 2, 3, 4)}) as session:
        for round_ in range(10):
            session.tx(*(random_line(session, generator) for _ in range(100)))
            session.tester.collect_until_quiet(0.002, 0.3)
        session.tx(*(session.request(p.ECU, p.GLOBAL if number % 2 else session.address, number) for number in range(100)))
        session.report.equal("10 bursts of 100 frames: the process runs", True, session.sensor.running)
        session.wait_online()
        session.report.equal("10 bursts of 100 frames: 1000h", 0x0704019A, session.get(0x1000))
        count = len(session.all_of(p.SSI2, 1.0))
        session.report.within("10 bursts of 100 frames: SSI2 goes on, frames in 1 s", 99, 101, count)


GROUPS = (invalid_frames, random_frames, bursts)
