"""The acknowledge handler: resends without an acknowledge, none with it, and acknowledge suppression."""

from gemac.harness import Frame

from . import protocol as p
from .cases_io import SCALE, shift
from .runner import Context
from .session import Session, text


def production(session: Session, by: int, seconds: float) -> list[Frame]:
    """Makes a change and returns the messages that follow."""
    session.collect(0.01)
    session.others.clear()
    shift(session, by)
    return session.produced(seconds)


def gaps(frames: list[Frame]) -> list[float]:
    """Times between messages in s."""
    return [b.at - a.at for a, b in zip(frames, frames[1:], strict=False)]


def established(session: Session, choice: int = 0x11, rate: int = 0) -> None:
    """A COS or cyclic connection that has sent its first message."""
    session.connect(choice)
    session.put_angle(0x73, SCALE)
    session.rate(p.C_COS, rate)
    session.produced(0.1)


def resends(context: Context) -> None:
    """Nobody acknowledges: timer and retries tell how often and when a message is sent again."""
    with context.session() as session:
        report = session.report
        session.connect(0x11)
        session.put_angle(0x73, SCALE)
        session.rate(p.C_COS, 0)
        first = session.produced(0.3)
        report.equal("first message: twice", [session.words(session.subject.long)] * 2, [text(frame) for frame in first])
        plan = ((16, 1), (16, 3), (16, 0), (50, 1), (50, 3), (100, 2), (200, 1), (16, 1))
        for by, (timer, retries) in enumerate(plan, 1):
            session.put(p.HANDLER, 1, 1, p.encode(timer, 2))
            session.put(p.HANDLER, 1, 2, f"{retries:02X}")
            frames = production(session, by, 0.3 + 0.001 * timer * (retries + 1))
            name = f"timer {timer}, retries {retries}"
            report.equal(
                f"{name}: messages", [session.words(session.subject.long + by)] * (retries + 1), [text(frame) for frame in frames]
            )
            for gap in gaps(frames):
                report.within(f"{name}: gap in s", 0.001 * timer - 0.001, 0.001 * timer + 0.002, gap)
        report.equal("still established", p.ESTABLISHED, session.state(p.C_COS))


def acknowledged(context: Context) -> None:
    """Acknowledged in time: one message; after the first resend: two."""
    with context.session() as session:
        report, wanted = session.report, lambda frame: frame.id == p.change_of_state(session.mac)
        established(session)
        session.put(p.HANDLER, 1, 1, p.encode(150, 2))
        session.put(p.HANDLER, 1, 2, "03")
        for number in range(1, 6):
            session.collect(0.01)
            session.others.clear()
            shift(session, number)
            frames = [frame for frame in session.others if wanted(frame)] or [session.wait(wanted, 0.1)]
            session.send(p.ACKNOWLEDGE)
            report.equal(
                f"acknowledged in time {number}",
                [session.words(session.subject.long + number)],
                [text(frame) for frame in frames],
            )
            session.others.clear()
            report.equal(f"acknowledged in time {number}: nothing follows", [], session.produced(0.4))
        for late in (1, 2):
            session.collect(0.01)
            session.others.clear()
            shift(session, 10 + late)
            frames = [frame for frame in session.others if wanted(frame)]
            while len(frames) < 1 + late:
                frames.append(session.wait(wanted, 0.5))
            session.send(p.ACKNOWLEDGE)
            session.others.clear()
            report.equal(f"acknowledged after resend {late}: nothing follows", [], session.produced(0.5))
        session.collect(0.01)
        session.others.clear()
        shift(session, 20)
        session.send(p.ACKNOWLEDGE, "00")
        session.tester.send(session.id(p.ACKNOWLEDGE) ^ 8)
        report.equal("an acknowledge with data, and one to another node, do not count", 4, len(session.produced(0.9)))
        session.send(p.ACKNOWLEDGE)
        report.equal("an acknowledge without a message", [], session.collect(0.3))


def cyclic_acknowledged(context: Context) -> None:
    """Cyclic with acknowledges: one message a period; without them two."""
    with context.session() as session:
        established(session, 0x21, 200)
        session.put(p.HANDLER, 1, 1, p.encode(60, 2))
        session.sleep(0.3)
        session.others.clear()
        session.collect(0.01)
        frames = session.collect(2.0, p.change_of_state(session.mac))
        session.report.within("without acknowledges: messages in 2 s", 18, 22, len(frames))
        found = []
        end = session.now() + 2.0
        while session.now() < end:
            if frame := session.wait(lambda frame: frame.id == p.change_of_state(session.mac), 0.3):
                session.send(p.ACKNOWLEDGE)
                found.append(frame)
        session.report.within("with acknowledges: messages in 2 s", 9, 12, len(found))


def suppressed(context: Context) -> None:
    """Acknowledge suppression: one message for each production; acknowledges are ignored."""
    with context.session() as session:
        report = session.report
        for choice in (0x51, 0x53):
            session.connect(choice)
            session.put_angle(0x73, SCALE)
            session.rate(p.C_COS, 0)
            report.equal("first message: once", 1, len(session.produced(0.3)))
            for by in (1, 2, 0):
                report.equal(f"change {by}: once", 1, len(production(session, by, 0.2)))
            session.send(p.ACKNOWLEDGE)
            report.equal("an acknowledge", [], session.collect(0.1))
            session.release(choice)
        session.connect(0x61, cos=100)
        session.produced(0.05)
        report.within("cyclic: messages in 1 s", 9, 11, len(session.collect(1.0, p.change_of_state(session.mac))))


def newest_value(context: Context) -> None:
    """A change while a message waits for its acknowledge: the newest value comes, at the latest after the resends."""
    with context.session() as session:
        established(session)
        session.put(p.HANDLER, 1, 1, p.encode(80, 2))
        session.collect(0.01)
        session.others.clear()
        shift(session, 1)
        session.sleep(0.02)
        shift(session, 2)
        frames = session.produced(0.6)
        session.report.equal("last message", session.words(session.subject.long + 2), text(frames[-1]) if frames else None)
        session.report.equal("first message", session.words(session.subject.long + 1), text(frames[0]) if frames else None)


GROUPS = (resends, acknowledged, cyclic_acknowledged, suppressed, newest_value)
