"""I/O messages: poll, change of state with its delta, cyclic, inhibit time."""

import statistics

from gemac import scenes

from . import protocol as p
from .runner import Context
from .session import Session, text

SCALE = 2


def shift(session: Session, by: int) -> int:
    """Moves the long slope by a differential offset; returns the new word."""
    session.put_angle(0x77, by % session.subject.units(10) if session.subject.circular else by)
    return session.subject.long + by


def produced(session: Session, seconds: float) -> list[str]:
    """The data of the COS or cyclic messages within this time."""
    return [text(frame) for frame in session.produced(seconds)]


def polls(context: Context) -> None:
    """Poll before and after each step of the allocation, beside COS and cyclic connections."""
    with context.session() as session:
        report, words = session.report, session.words(session.subject.long)
        report.equal("not allocated", None, session.poll(timeout=0.1))
        for choice in (0x03, 0x13, 0x23, 0x53, 0x63):
            session.connect(choice)
            report.equal(f"choice {choice:02X}h: configuring", None, session.poll(timeout=0.1))
            session.rate(p.C_POLL, 0)
            for number in range(5):
                report.equal(f"choice {choice:02X}h: poll {number}", words, session.poll())
            report.equal(f"choice {choice:02X}h: no production yet", [], produced(session, 0.1))
            report.equal(f"choice {choice:02X}h: poll with data", None, session.poll("00", timeout=0.08))
            report.equal(f"choice {choice:02X}h: poll after it", words, session.poll())
            session.release(choice)
            report.equal(f"choice {choice:02X}h: released", None, session.poll(timeout=0.1))
        for choice in (0x01, 0x11, 0x51):
            session.connect(choice)
            report.equal(f"choice {choice:02X}h: poll of what is not allocated", None, session.poll(timeout=0.1))
            session.release(choice)
        session.connect(3, poll=0)
        session.put_angle(0x73, SCALE)
        for by in (1, 100, 1000, 0):
            word = shift(session, by)
            session.sleep(0.01)
            report.equal(f"poll with differential offset {by}", session.words(word), session.poll())


def burst(context: Context) -> None:
    """1000 polls, and requests between them: each is answered, in order."""
    with context.session() as session:
        session.connect(3, poll=0)
        report, words = session.report, session.words(session.subject.long)
        for number in range(1000):
            session.send(p.POLL)
            if number % 100 == 50:
                session.send(p.EXPLICIT, "0A0E030101")
        polled, answers = [], []
        while frame := session.tester.receive(0.5):
            (polled if frame.id == p.poll_response(session.mac) else answers).append(text(frame))
        report.equal("1000 polls: answers", 1000, len(polled))
        report.equal("1000 polls: data", {words}, set(polled))
        report.equal("requests between the polls", ["0A8E3F"] * 10, answers)
        times = []
        for _ in range(200):
            started = session.now()
            session.poll()
            times.append(session.now() - started)
        report.within("response time in s, median of 200", 0, 0.02, statistics.median(times))


def change_of_state(context: Context) -> None:
    """Once when established, then one message for each change."""
    with context.session() as session:
        report, long = session.report, session.subject.long
        for choice in (0x51, 0x53):
            session.connect(choice)
            session.put_angle(0x73, SCALE)
            shift(session, 0)
            session.others.clear()
            report.equal("configuring: no production", [], produced(session, 0.2))
            shift(session, 5)
            report.equal("configuring: no production on a change", [], produced(session, 0.1))
            shift(session, 0)
            session.sleep(0.02)
            session.rate(p.C_COS, 0)
            report.equal("established: once", [session.words(long)], produced(session, 0.4))
            for by in (1, 2, 100, 99, 0):
                word = shift(session, by)
                report.equal(f"differential offset {by}: one message", [session.words(word)], produced(session, 0.15))
            session.put_angle(0x84, 100)
            report.equal("a set that changes no value", [], produced(session, 0.15))
            session.put_angle(0x7B, SCALE)
            session.put_angle(0x7F, 7)
            report.equal("lateral change", [session.words(long, session.subject.lateral + 7)], produced(session, 0.15))
            session.put_angle(0x7F, 0)
            report.equal("lateral change back", [session.words(long)], produced(session, 0.15))
            session.rate(p.C_COS, 0)
            session.others.clear()
            session.collect(0.1)
            session.release(choice)
            shift(session, 9) if session.allocate(1) == "0ACB00" else None
            report.equal("released: no production", [], produced(session, 0.15))
            shift(session, 0)
            session.release(1)


def state_deltas(context: Context) -> None:
    """COS delta: a message when a word differs by the delta or more from the one sent last (T21)."""
    with context.session() as session:
        report, long = session.report, session.subject.long
        session.connect(0x51)
        session.put_angle(0x73, SCALE)
        session.put_angle(0x7B, SCALE)
        session.put_angle(0x88, 20)
        session.rate(p.C_COS, 0)
        report.equal("established: once", [session.words(long)], produced(session, 0.2))
        for by, sent in (
            (19, False),
            (20, True),
            (1, False),
            (0, True),
            (10, False),
            (19, False),
            (-19, None),
            (-20, None),
            (200, True),
            (181, False),
            (180, True),
        ):
            if by < 0 and sent is None:
                sent = by == -20
            word = shift(session, by)
            word = word % session.subject.units(10) if session.subject.circular else word
            expected = [session.words(word)] if sent else []
            report.equal(f"delta 20, offset {by}", expected, produced(session, 0.12))
        session.put_angle(0x7F, 19)
        report.equal("delta 20, lateral 19", [], produced(session, 0.12))
        session.put_angle(0x7F, 20)
        report.equal("delta 20, lateral 20", [session.words(long + 180, session.subject.lateral + 20)], produced(session, 0.12))
        session.put_angle(0x88, 0)
        report.equal("delta 0: nothing differs", [], produced(session, 0.12))
        shift(session, 181)
        report.equal("delta 0: any change", [session.words(long + 181, session.subject.lateral + 20)], produced(session, 0.12))
        session.put_angle(0x88, 200)
        for by, sent in ((380, False), (381, True)):
            word = shift(session, by)
            expected = [session.words(word, session.subject.lateral + 20)] if sent else []
            report.equal(f"delta 200, offset {by}", expected, produced(session, 0.12))


def delta_across(context: Context) -> None:
    """On the 360 model the difference is taken across 360 deg; on the other, across 0."""
    with context.session() as session:
        report, subject = session.report, session.subject
        session.connect(0x51)
        session.put_angle(0x73, SCALE)
        session.put_angle(0x88, 30)
        near = 35990 if subject.circular else -10
        units = subject.units(10)

        def go(word: int) -> str:
            by = word - subject.long
            session.put_angle(0x77, by % units if subject.circular else by)
            return session.words(word % units if subject.circular else word)

        expected = go(near)
        session.sleep(0.02)
        session.rate(p.C_COS, 0)
        report.equal("established", [expected], produced(session, 0.2))
        start = 36000 if subject.circular else 0
        for offset, sent in ((19, False), (20, True), (-9, False), (-10, True), (0, False), (20, True), (49, False), (50, True)):
            expected = go(start + offset)
            report.equal(f"delta 30, at {offset}", [expected] if sent else [], produced(session, 0.12))


def state_rate(context: Context) -> None:
    """COS with a rate: repeated at the rate; a change comes at once and restarts the rate."""
    with context.session() as session:
        report, long = session.report, session.subject.long
        session.connect(0x51)
        session.put_angle(0x73, SCALE)
        session.rate(p.C_COS, 200)
        frames = session.produced(2.1)
        report.within("messages in 2.1 s at rate 200", 10, 12, len(frames))
        report.equal("their data", {session.words(long)}, {text(frame) for frame in frames})
        gaps = [b.at - a.at for a, b in zip(frames, frames[1:], strict=False)]
        report.within("median period in s", 0.195, 0.205, statistics.median(gaps))
        session.wait(lambda frame: frame.id == p.change_of_state(session.mac), 0.5)
        session.sleep(0.08)
        shift(session, 50)
        frames = session.produced(0.5)
        report.equal("a change in between: data", [session.words(long + 50)] * 3, [text(frame) for frame in frames[:3]])
        report.within("a change restarts the rate", 0.19, 0.21, frames[1].at - frames[0].at)
        session.rate(p.C_COS, 2)
        # Long enough to read what has come in before.
        session.collect(0.4)
        frames = session.collect(2.0, p.change_of_state(session.mac))
        report.within("messages in 2 s at rate 2", 900, 1030, len(frames))
        session.rate(p.C_COS, 0)
        session.sleep(0.05)
        session.collect(0.05)
        session.others.clear()
        report.verdict(len(produced(session, 0.5)) == 0, "rate 0: no repetition", 0, "see left")


def cyclic(context: Context) -> None:
    """Cyclic sends at its rate only, with the newest value."""
    with context.session() as session:
        report, long = session.report, session.subject.long
        session.connect(0x61)
        session.put_angle(0x73, SCALE)
        report.equal("configuring: no production", [], produced(session, 0.2))
        session.rate(p.C_COS, 200)
        established = session.now()
        frames = session.produced(2.1)
        report.within("messages in 2.1 s at rate 200", 10, 12, len(frames))
        report.within("first one after s", -0.05, 0.215, frames[0].at - established)
        gaps = [b.at - a.at for a, b in zip(frames, frames[1:], strict=False)]
        report.within("median period in s", 0.195, 0.205, statistics.median(gaps))
        last = session.wait(lambda frame: frame.id == p.change_of_state(session.mac), 0.5)
        session.sleep(0.05)
        shift(session, 50)
        frames = session.produced(0.3)
        report.equal("a change waits for the period", session.words(long + 50), text(frames[0]))
        report.within("its time in s", 0.19, 0.21, frames[0].at - last.at)
        for rate in (10, 50, 500):
            session.rate(p.C_COS, rate)
            session.sleep(0.05)
            session.others.clear()
            frames = session.produced(max(1.0, rate * 0.0045))
            gaps = [b.at - a.at for a, b in zip(frames, frames[1:], strict=False)]
            report.within(
                f"rate {rate}: median period in s",
                0.00095 * rate - 0.001,
                0.00105 * rate + 0.001,
                statistics.median(gaps or [99]),
            )
        session.rate(p.C_COS, 0)
        session.sleep(0.05)
        session.collect(0.05)
        session.others.clear()
        shift(session, 0)
        report.equal("rate 0: nothing", [], produced(session, 0.6))


def inhibit(context: Context) -> None:
    """After a production nothing new for the inhibit time, then the newest value if it still differs."""
    with context.session() as session:
        report, long = session.report, session.subject.long
        session.connect(0x51)
        session.put_angle(0x73, SCALE)
        session.put(p.CONNECTION, p.C_COS, 17, p.encode(400, 2))
        session.rate(p.C_COS, 0)
        report.equal("established: once", 1, len(produced(session, 0.6)))
        shift(session, 1)
        first = session.produced(0.05)
        report.equal("first change: at once", [session.words(long + 1)], [text(frame) for frame in first])
        shift(session, 2)
        shift(session, 3)
        frames = session.produced(0.9)
        report.equal("changes within the time: the newest", [session.words(long + 3)], [text(frame) for frame in frames])
        report.within("after the inhibit time", 0.39, 0.42, frames[0].at - first[0].at if frames and first else 99)
        shift(session, 4)
        report.equal("later change: at once", [session.words(long + 4)], produced(session, 0.05))
        shift(session, 5)
        shift(session, 4)
        report.equal("change and change back: nothing", [], produced(session, 0.8))
        session.put(p.CONNECTION, p.C_COS, 17, "0000")
        for by in (10, 11, 12):
            shift(session, by)
            report.equal(f"no inhibit time: change {by}", [session.words(long + by)], produced(session, 0.05))


def changes_of_parameters(context: Context) -> None:
    """Parameters that change the words: one message each."""
    with context.session() as session:
        report, subject = session.report, session.subject
        session.connect(0x51, cos=0)
        report.equal("established: once", [session.words(subject.long)], produced(session, 0.2))
        for resolution in (100, 1000, 100, 10):
            session.put_angle(0x71, resolution)
            words = session.words(*(subject.rounded(one, resolution) for one in (subject.long, subject.lateral)))
            report.equal(f"resolution {resolution}: one message", [words], produced(session, 0.15))
        session.put_angle(0x73, 1)
        words = session.words(subject.rounded(-subject.long, 10))
        report.equal("inversion: one message", [words], produced(session, 0.15))
        session.put_angle(0x73, 3)
        report.equal("scaling without offsets: no message", [], produced(session, 0.15))
        session.put_angle(0x74, 100)
        report.equal("preset value: no message", [], produced(session, 0.15))
        session.put_angle(0x75, 1)
        report.equal("preset: one message", [session.words(100)], produced(session, 0.15))
        for attribute, value in ((0x87, 1), (0x84, 50), (0x85, 5), (0x88, 10), (0x81, 101)):
            session.put_angle(attribute, value)
            report.equal(f"{p.BY_ID[attribute]}: no message", [], produced(session, 0.1))


def moving(context: Context) -> None:
    """A turn: each message differs from the one before by the delta or more, and polls agree with it."""
    up = scenes.one_axis_up if context.subject.circular else scenes.two_axis_up
    rows = scenes.plateaus([(0.0, up(10.0, 0.0))])
    rows += [(5.0 + 0.05 * step, up(10.0 + 0.25 * step, 0.0)) for step in range(61)]
    with context.session(scene=scenes.write(context.folder / "turn.csv", rows)) as session:
        report = session.report
        session.connect(0x51)
        session.put_angle(0x88, 50)
        session.put_angle(0x84, 0)
        session.rate(p.C_COS, 0)
        session.sleep(max(0.0, session.sensor.started + 9.0 - session.now()))
        words = [p.decode(text(frame)[:4], True) for frame in session.produced(0.3)]
        report.within("first and last", 0, 50, abs(words[0] - 1000) + abs(words[-1] - 2500))
        steps = [abs(b - a) for a, b in zip(words, words[1:], strict=False)]
        report.within("messages of 15 deg in steps of 0.5 deg", 24, 31, len(words))
        report.within("least step", 50, 60, min(steps))
        report.within("greatest step", 50, 60, max(steps))
        session.put_angle(0x88, 0)
        report.equal("end of the turn", 2500, session.angle(0x72))


GROUPS = (polls, burst, change_of_state, state_deltas, delta_across, state_rate, changes_of_parameters, cyclic, inhibit, moving)
