"""Requests 59904 and what answers them: one frame, BAM, RTS/CTS, negative acknowledgement, or nothing (S26..S28)."""

from canopen_cases.runner import Context

from . import protocol as p
from .session import AT_ONCE, BAM_STEP, Node

ONE_FRAME = (p.SSI2, p.SSI, p.ARI, p.ACCS, p.DM1, p.SOFTWARE)


def of(session: Node, pgn: int, lines: list[str]) -> list[str]:
    """Sends frames; returns the frames of this parameter group that follow, and what is not expected at all."""
    session.others.clear()
    session.tx(*lines)
    for _ in range(2):
        session.send_to(session.address, bytes([0x40, 0xFE, 0x5F, 0]), p.PROBE)
        session.wait(session.is_mark)
    session.wait(lambda frame: False, 0.04)
    found, session.others = session.others, []
    return [str(one) for one in found if p.split(one).pgn == pgn or not session.cyclic(one)]


def answered(context: Context) -> None:
    """S26: each supported group, to us, to all, with more bytes; one frame also while its rate is 0."""
    with Node(context) as session:
        version = session.upload(0x100A).decode()
        fixed = {
            p.CLAIMED: p.claim(),
            p.SOFTWARE: None if len(version) != 6 else p.shown(p.SOFTWARE, 0x80, b"\x01" + version.encode() + b"*"),
        }
        priorities = {pgn: 3 for pgn in p.PROCESS}
        for pgn in (p.CLAIMED, *ONE_FRAME):
            for name, line in (
                ("to us", session.request(pgn)),
                ("to all", session.request(pgn, p.GLOBAL)),
                ("with 8 bytes", session.request(pgn, rest=b"\xff" * 5)),
                ("with 4 bytes", session.request(pgn, p.GLOBAL, rest=b"\x00")),
                ("priority 3", "0C" + session.request(pgn)[2:]),
            ):
                got = of(session, pgn, [line])
                head = f"{p.identifier(pgn, 0x80, priority=priorities.get(pgn, 6)):08X}#"
                if pgn in fixed:
                    session.report.equal(f"S26 {pgn} {name}", [fixed[pgn]], got)
                else:
                    # Within this time, DM1 may be sent by itself too.
                    right = len(got) in ((1, 2) if pgn == p.DM1 else (1,)) and all(
                        one.startswith(head) and len(one) == 25 for one in got
                    )
                    session.report.verdict(right, f"S26 {pgn} {name}", f"{head} and 8 bytes", got)


def refused(context: Context) -> None:
    """S26, S27: unknown groups: to us a negative acknowledgement with these bytes, to all nothing."""
    unknown = [
        65262,
        65241,
        0,
        0xEA00,
        0xE800,
        0xEC00,
        0xEB00,
        0xEF00,
        65240,
        0xFF00,
        0xFFFF,
        0x1FECA,
        0x3FFFF,
        0xFFFFFF,
        0x100,
        61484,
        65227,
        65228,
        65229,
        65230,
        65231,
        65235,
        57088,
    ]
    with Node(context) as session:
        for pgn in unknown:
            session.expect(f"S26 S27 {pgn} to us", session.request(pgn), p.nack(pgn))
            session.expect(f"S26 {pgn} to all", session.request(pgn, p.GLOBAL))
        session.expect("S27 the bytes in facts: FEEEh", "18EA8021#EEFE00", "18E8FF80#01FFFFFF21EEFE00")
        session.expect("S27 asked by 00h", session.request(65262, source=0), p.nack(65262, 0))
        session.expect("S27 asked by 253", session.request(65262, source=253), p.nack(65262, 253))
        session.expect("S27 with 8 bytes", session.request(65262, rest=b"\x01\x02\x03\x04\x05"), p.nack(65262))
        for count in (0, 1, 2):
            for pgn in (p.CLAIMED, p.SSI2, p.COMPONENT, 65262):
                for to in (session.address, p.GLOBAL):
                    line = session.request(pgn, to)[: 9 + 2 * count]
                    session.report.equal(
                        f"S26 {count} bytes are ignored: {line}", [], of(session, pgn if pgn != p.DM1 else 0, [line])
                    )
        for pgn in (p.CLAIMED, p.SSI2, p.COMPONENT, 65262):
            for to in (0x90, 0x00, p.NULL):
                session.report.equal(f"S26 {pgn} to {to:02X}h", [], of(session, pgn, [session.request(pgn, to)]))
        # From a node without an address: only the claim is answered.
        for to in (session.address, p.GLOBAL):
            session.expect(f"S26 254 asks {to:02X}h for the claim", session.request(p.CLAIMED, to, p.NULL), p.claim())
            for pgn in (p.SSI2, p.SOFTWARE, p.COMPONENT, 65262):
                session.report.equal(
                    f"S26 254 asks {to:02X}h for {pgn}", [], of(session, pgn, [session.request(pgn, to, p.NULL)])
                )
        for body in ("00FFFFFF80EBFE00", "01FFFFFF80EBFE00", "02FFFFFF8000EE00", "03FFFFFF8000EA00"):
            session.expect("S27 acknowledgements of others are ignored", f"18E8FF21#{body}")
            session.expect("S27 acknowledgements to us are ignored", f"18E88021#{body}")
        for pgn in (p.SSI2, p.SSI, p.ARI, p.ACCS, p.DM1, 65262, p.COMPONENT):
            session.expect(f"S18 the group {pgn} of others is ignored", p.shown(pgn, 0x40, bytes(8)))


def texts(session: Node) -> dict[int, bytes]:
    """S28: the identifications."""
    serial = session.get(0x1018, 4)
    version = session.upload(0x100A).decode()
    name = session.upload(0x1008).decode()
    return {
        p.COMPONENT: f"Plumbline*{name}*{serial}**".encode(),
        p.SOFTWARE: b"\x01" + f"{version}*".encode(),
        p.ECU: f"{name}*{serial}**Inclinometer*Plumbline*".encode(),
    }


def identification(context: Context) -> None:
    """S28: the texts, by RTS/CTS to the requester, by BAM to all."""
    with Node(context) as session:
        whole = texts(session)
        session.report.equal("S28 1008h", b"IMS360", session.upload(0x1008))
        for pgn in (p.COMPONENT, p.ECU):
            text = whole[pgn]
            count = (len(text) + 6) // 7
            session.tx(session.request(pgn))
            session.comes(f"S28 {pgn} to us: RTS", p.rts(0x80, p.ME, pgn, len(text)))
            session.tx(p.cts(p.ME, 0x80, pgn, count, 1))
            for number in range(1, count + 1):
                session.comes(f"S28 {pgn}: packet {number}", p.packet(0x80, p.ME, text, number))
            session.expect(f"S29 {pgn}: end of message, then nothing", p.end_of_message(p.ME, 0x80, pgn, len(text)))
            session.tx(session.request(pgn, p.GLOBAL))
            last = session.comes(f"S28 {pgn} to all: BAM", p.bam(0x80, pgn, len(text)))
            for number in range(1, count + 1):
                frame = session.comes(f"S28 {pgn}: BAM packet {number}", p.packet(0x80, p.GLOBAL, text, number))
                if frame and last:
                    session.report.within(f"S29 {pgn}: time before packet {number}", *BAM_STEP, frame.at - last.at)
                last = frame
        session.expect("S28 software", session.request(p.SOFTWARE), p.shown(p.SOFTWARE, 0x80, whole[p.SOFTWARE]))


def many(context: Context) -> None:
    """S26: requests in a burst are all answered; several nodes ask."""
    with Node(context) as session:
        lines = [session.request(65262 + number, source=number + 1) for number in range(20)]
        expected = {p.nack(65262 + number, number + 1) for number in range(20)}
        got = session.after(*lines)
        session.report.equal("S27 20 requests at once", sorted(expected), sorted(got))
        for round_ in range(25):
            session.tx(session.request(p.CLAIMED, source=round_), session.request(65262, source=round_))
            got = [str(session.next(AT_ONCE)) for _ in range(2)]
            if sorted(got) != sorted([p.claim(), p.nack(65262, round_)]):
                session.report.equal(f"S26 round {round_}", [p.claim(), p.nack(65262, round_)], got)
                break
        session.report.equal("S26 25 rounds of two requests", 24, round_)


GROUPS = (answered, refused, identification, many)
