"""Fragmentation in both directions: the rules of the sender and of the receiver, one by one."""

from . import protocol as p
from .runner import Context
from .session import Session, shown, text

GET_NAME = "0A0E010107"
ACK_TIMEOUT = 1.0


def fragments(session: Session, header: int = 0x8A) -> list[str]:
    """The fragments of the product name, as they must come."""
    name = session.subject.name.encode()
    body = bytes([0x8E, len(name)]) + name
    parts = [body[at : at + 6] for at in range(0, len(body), 6)]
    kinds = [0x00, *(0x40 | n for n in range(1, len(parts) - 1)), 0x80 | len(parts) - 1]
    return [f"{header:02X}{kind:02X}{part.hex().upper()}" for kind, part in zip(kinds, parts, strict=True)]


def connected(context: Context) -> Session:
    """A sensor with an explicit connection."""
    session = context.session()
    session.connect()
    return session


def sends(context: Context) -> None:
    """The product name in fragments, each after the acknowledge of the one before."""
    with connected(context) as session:
        for header in (0x0A, 0x4A):
            expected = fragments(session, header | 0x80)
            got = [session.ask(f"{header:02X}0E010107")]
            for number in range(len(expected) - 1):
                session.quiet(f"header {header:02X}h: nothing before acknowledge {number}", 0.05)
                got.append(session.ask(f"{header | 0x80:02X}{0xC0 | number:02X}00"))
            for number, pair in enumerate(zip(expected, got, strict=True)):
                session.report.equal(f"header {header:02X}h: fragment {number}", *pair)
            session.send(p.EXPLICIT, f"{header | 0x80:02X}{0xC0 | len(expected) - 1:02X}00")
            session.quiet("after the last acknowledge", 1.3)
        session.expect("then a request", "0A0E030101", "0A8E3F")


def start(session: Session, count: int = 0) -> list[str]:
    """Requests the name and acknowledges `count` fragments; returns all fragments."""
    session.collect(0.01)
    session.ask(GET_NAME)
    for number in range(count):
        session.ask(f"8A{0xC0 | number:02X}00")
    return fragments(session)


def wrong_acknowledges(context: Context) -> None:
    """An acknowledge with another count or from another MAC ID is ignored, one with a status ends the transfer."""
    with connected(context) as session:
        report = session.report
        expected = start(session, 1)
        for data in ("8AC000", "8AC200", "8AFF00", "8BC100", "89C100", "8AC300"):
            session.send(p.EXPLICIT, data)
            session.quiet(f"acknowledge {data} in fragment 1", 0.04)
        report.equal("the right acknowledge goes on", expected[2], session.ask("8AC100"))
        report.equal("an acknowledge twice: first", expected[3], session.ask("8AC200"))
        session.send(p.EXPLICIT, "8AC200")
        session.quiet("an acknowledge twice: second", 0.05)
        report.equal("it goes on", expected[4], session.ask("8AC300"))
        session.send(p.EXPLICIT, "8AC400")
        for status in ("01", "02", "FF"):
            start(session, 1)
            session.send(p.EXPLICIT, "8AC1" + status)
            session.quiet(f"status {status}: over", 1.2)
            session.send(p.EXPLICIT, "8AC100")
            session.quiet(f"status {status}: an acknowledge afterwards", 0.05)
            session.expect("a request afterwards", "0A0E030101", "0A8E3F")
        for data in ("8AC000", "8AC100", "8AC001"):
            session.send(p.EXPLICIT, data)
            session.quiet(f"acknowledge {data} without a transfer", 0.05)


def resends(context: Context) -> None:
    """Without an acknowledge for 1 s the same fragment once more; then it is given up."""
    with connected(context) as session:
        report = session.report
        for count in (0, 2, 4):
            expected = start(session, count)[count]
            sent = session.now()
            again = session.collect(3.2)
            report.equal(f"fragment {count}: once more", [expected], [text(frame) for frame in again])
            if again:
                report.within(f"fragment {count}: after s", 0.95, 1.15, again[0].at - sent)
            session.send(p.EXPLICIT, f"8A{0xC0 | count:02X}00")
            session.quiet(f"fragment {count}: given up", 0.05)
        expected = start(session, 1)
        again = session.wait_message(p.RESPONSE, 1.5)
        report.equal("fragment 1 once more", expected[1], text(again) if again else None)
        report.equal("acknowledged after the second", expected[2], session.ask("8AC100"))
        again = session.wait_message(p.RESPONSE, 1.5)
        report.equal("fragment 2 once more", expected[2], text(again) if again else None)
        report.equal("acknowledged after the second", expected[3], session.ask("8AC200"))
        report.equal("until the end", expected[4], session.ask("8AC300"))
        session.send(p.EXPLICIT, "8AC400")
        session.quiet("done", 1.2)


def interrupted(context: Context) -> None:
    """An unfragmented request, or a release, ends the transfer and is served."""
    with connected(context) as session:
        start(session, 1)
        session.expect("a request ends the transfer", "0A0E030101", "0A8E3F")
        session.send(p.EXPLICIT, "8AC100")
        session.quiet("no fragment after the request", 1.3)
        expected = start(session, 2)
        session.expect("the same request anew", GET_NAME, expected[0])
        session.report.equal("it starts with fragment 0", expected[1], session.ask("8AC000"))
        session.expect("an error ends the transfer", "0A0E030163", "0A9414FF")
        session.quiet("no fragment after the error", 1.3)
        start(session, 1)
        session.expect_port("the port refuses another master", "0B4B0301010B", p.error(p.PORT_BUSY, 0x0B))
        session.report.equal("the transfer goes on", expected[2], session.ask("8AC100"))
        session.expect_port("release on the port", "0A4C030101", "0ACC")
        session.quiet("no fragment after the release", 1.3)
        session.connect()
        start(session, 1)
        session.expect("release on the explicit connection", "0A4C030101", "0ACC")
        session.quiet("no fragment after the release", 1.3)
        session.connect()
        session.send(p.EXPLICIT, "8AC000")
        session.quiet("no fragment in the new connection", 0.1)


def receives(context: Context) -> None:
    """Requests in fragments of any size, with and without XID."""
    with connected(context) as session:
        report = session.report
        for header, done in (("8A", "0A90"), ("CA", "4A90")):
            for value, parts in (
                (300, ("00106501", "81852C01")),
                (301, ("0010650185", "812D01")),
                (302, ("00106501852E", "8101")),
                (303, ("0010", "4165", "4201", "4385", "442F", "8501")),
                (304, ("00106501853001", "81")),
            ):
                transfer(session, f"set 85h = {value}", header, parts, done)
                report.equal(f"85h = {value}", value, session.angle(0x85))
        transfer(session, "get in two fragments", "8A", ("000E03", "810101"), "0A8E3F")
        transfer(session, "an error", "8A", ("001065", "810184FB"), "0A9409FF")
        transfer(session, "a value that is too long", "8A", ("00106501", "81850000000000"), "0A9415FF")
        transfer(session, "no such object", "8A", ("000E99", "810101"), "0A9416FF")
        transfer(session, "a fragmented answer", "8A", ("000E01", "810107"), fragments(session)[0])
        session.ask("8AC001")
        session.expect("then a request", "0A0E030101", "0A8E3F")


def transfer(session: Session, name: str, header: str, parts: tuple[str, ...], done: str) -> None:
    """Sends fragments; each is acknowledged, and the last one also answered."""
    for part in parts:
        count = int(part[:2], 16) & 0x3F
        session.expect(f"{name}: acknowledge", header + part, f"{header}{0xC0 | count:02X}00")
    session.report.equal(f"{name}: answer", done, session.answer())


def dropped(context: Context) -> None:
    """Fragments that are dropped or acknowledged again, and what resets the receiver."""
    with connected(context) as session:
        report = session.report
        session.put_angle(0x85, 7)
        for name, parts in (
            ("first with count 1", ("01106501", "81852C01", "82852C01")),
            ("first with count 63", ("3F106501", "80852C01")),
            ("middle without a first", ("40106501", "81852C01")),
            ("middle 1 without a first", ("41106501", "82852C01")),
            ("last without a first", ("80852C01", "81852C01")),
        ):
            for part in parts:
                session.send(p.EXPLICIT, "8A" + part)
                session.quiet(f"{name}: {part} is dropped", 0.04)
        session.expect("first", "8A00106501", "8AC000")
        session.expect("first again: starts anew", "8A001065", "8AC000")
        session.expect("middle", "8A410185", "8AC100")
        session.expect("middle again: acknowledged, not appended", "8A410185", "8AC100")
        session.expect("middle with the previous count and other data", "8A41FFFF", "8AC100")
        session.expect("last", "8A820801", "8AC200")
        report.equal("answer", "0A90", session.answer())
        report.equal("85h", 0x108, session.angle(0x85))
        for name, part in (
            ("middle with a count too far", "428500"),
            ("last with a count too far", "8285"),
            ("last with the previous count", "8085"),
        ):
            session.expect("first", "8A00106501", "8AC000")
            session.send(p.EXPLICIT, "8A" + part)
            session.quiet(f"{name}: reset in silence", 0.04)
            session.send(p.EXPLICIT, "8A81851200")
            session.quiet(f"{name}: the right one afterwards is dropped", 0.04)
        session.expect("first", "8A00106501", "8AC000")
        for data in ("8B81851200", "0B0E030101", "8981851200"):
            session.send(p.EXPLICIT, data)
            session.quiet(f"{data} is not of the owner", 0.04)
        session.expect("the owner goes on", "8A81850901", "8AC100")
        report.equal("answer", "0A90", session.answer())
        session.expect("first", "8A00106501", "8AC000")
        session.expect("an unfragmented request clears it", "0A0E030101", "0A8E3F")
        session.send(p.EXPLICIT, "8A81851200")
        session.quiet("the rest is dropped", 0.04)
        report.equal("85h", 0x109, session.angle(0x85))
        for data in ("8A", "CA"):
            session.send(p.EXPLICIT, data)
            session.quiet(f"{data}: no fragment byte", 0.04)
        session.expect("still there", "0A0E030101", "0A8E3F")


def too_long(context: Context) -> None:
    """A request longer than the consumed size: status 1, and the receiver starts anew."""
    with connected(context) as session:
        size = session.number(p.CONNECTION, 1, 8)
        session.report.within("consumed size of connection 1", 7, 1024, size)
        body = bytes.fromhex("1065018512") + bytes(size + 20)
        for _ in range(2):
            sent, number, answers = 0, 0, []
            while sent <= size and number < 64:
                part = body[sent : sent + 6]
                answers.append(session.ask(f"8A{number | (0x40 if number else 0):02X}{part.hex().upper()}"))
                sent += len(part)
                number += 1
                if answers[-1][4:] != "00":
                    break
            expected = [f"8A{0xC0 | n:02X}00" for n in range(number - 1)] + [f"8A{0xC0 | number - 1:02X}01"]
            session.report.equal(f"fragments of {sent} bytes for {size}", expected, answers)
            session.send(p.EXPLICIT, f"8A{0x80 | number & 0x3F:02X}00")
            session.quiet("the rest is dropped", 0.05)
        session.report.equal("nothing has changed", 0, session.angle(0x85))
        session.expect("a new transfer", "8A00106501", "8AC000")
        session.expect("its last fragment", "8A81850800", "8AC100")
        session.report.equal("its answer", "0A90", session.answer())
        session.quiet("nothing follows")


def polls_between(context: Context) -> None:
    """Polls do not disturb a transfer in either direction."""
    with context.session() as session:
        session.connect(3, poll=0)
        expected = fragments(session)
        got = [session.ask(GET_NAME)]
        for number in range(len(expected) - 1):
            session.report.equal("poll between", True, session.poll() is not None)
            got.append(session.ask(f"8A{0xC0 | number:02X}00"))
        session.report.equal("all fragments", expected, got)
        session.send(p.EXPLICIT, f"8A{0xC0 | len(expected) - 1:02X}00")
        session.expect("first", "8A00106501", "8AC000")
        session.report.equal("poll between", True, session.poll() is not None)
        session.expect("last", "8A81852C01", "8AC100")
        session.report.equal("answer", "0A90", session.answer())
        session.report.equal("nothing else", [], shown(session.collect(0.1)))


GROUPS = (sends, wrong_acknowledges, resends, interrupted, receives, dropped, too_long, polls_between)
