"""Cyclic mode and all three modes at once (sections 9.9.3 and 9.10.1, G4, G13, G23, G27)."""

from . import protocol as p
from .context import Context
from .harness import Frame, Tester
from .session import Session, counter


def start(session: Session, period_ms: int) -> float:
    """Switches cyclic mode on; returns the time of the reply."""
    session.accept(p.CYCLIC_TIME, p.u16(period_ms), f"Cyclic Time {period_ms} ms")
    session.values[p.CYCLIC_MODE] = b"\x01"
    frame = session.reply("Cyclic Mode on", b"\x26\x01", bytes([0x26, session.status]))
    return frame.at if frame else session.now()


def stop(session: Session) -> None:
    """Switches cyclic mode off, between two frames."""
    session.tester.send(session.set_id, b"\x26\x00")
    session.values[p.CYCLIC_MODE] = b"\x00"
    session.tester.collect(0.1)


def counters(session: Session, frames: list[Frame]) -> list[int | None]:
    """The counters of inclination replies."""
    return [counter(session.product, frame.data) for frame in frames]


def check_run(session: Session, name: str, frames: list[Frame], first: int, period: float) -> None:
    """Checks that the frames have consecutive counters from `first` on and the period."""
    report = session.report
    count = len(frames)
    report.equal(f"{name}: counters", list(range(first, first + count)), counters(session, frames))
    angles = (0,) * session.product.axes
    expected = [str(Frame(session.reply_id, session.angles_reply(angles, first + n))) for n in range(count)]
    report.equal(f"{name}: complete frames", expected[:2], [str(frame) for frame in frames[:2]])
    if count > 1:
        mean = (frames[-1].at - frames[0].at) / (count - 1)
        slack = max(0.004 / (count - 1), 0.01 * period)
        report.within(f"{name}: mean period in s", period - slack, period + slack, mean)
        gaps = [b.at - a.at for a, b in zip(frames, frames[1:])]
        report.within(f"{name}: longest gap in s", 0, period + 0.02, max(gaps))


def cyclic(context: Context) -> None:
    """Period, first frame, counter, changes while it runs."""
    with context.session() as session:
        tester, report = session.tester, session.report
        switched_on = start(session, 50)
        session.reply("polled before the first period: counter 0", b"\x00", level(session, 0))
        frames = tester.take(20, 2.0)
        if frames:
            report.within("first frame after one full period", 0.045, 0.075, frames[0].at - switched_on)
        check_run(session, "50 ms", frames, 1, 0.050)
        session.reply("polled: the counter of the last frame", b"\x00", level(session, 20))
        tester.take(1, 0.2)
        session.accept(p.CYCLIC_TIME, p.u16(20), "Cyclic Time 20 ms while it runs")
        check_run(session, "20 ms, the counter continues", tester.take(10, 1.0), 22, 0.020)
        session.values[p.CYCLIC_TIME] = p.u16(200)
        tester.request(session.set_id, b"\x25" + p.u16(200))
        last = tester.take(1, 0.6)
        session.sleep(0.09)
        session.acknowledged("Cyclic Mode on while it is on", b"\x26\x01")
        again = tester.take(1, 0.6)
        if last and again:
            first, second = counters(session, last + again)
            report.equal("on while on: the counter continues", (first or 0) + 1, second)
            report.within("on while on: the period continues", 0.17, 0.23, again[0].at - last[0].at)
        session.accept(p.CYCLIC_MODE, b"\x00", "Cyclic Mode off")
        session.quiet("off: nothing is sent", 0.45)
        session.reply("off: no counter", b"\x00", level(session, None))
        start(session, 30)
        session.reply("on again: counter 0", b"\x00", level(session, 0))
        check_run(session, "30 ms, on again", tester.take(5, 1.0), 1, 0.030)
        stop(session)
        check_fastest(session)


def level(session: Session, value: int | None) -> bytes:
    """The inclination reply of a level sensor."""
    return session.angles_reply((0,) * session.product.axes, value)


def check_fastest(session: Session) -> None:
    """1 ms: the counter follows the time, also if not every frame is sent (9.9.3)."""
    start(session, 1)
    session.tester.collect(0.1)
    frames = session.tester.collect(0.8)
    stop(session)
    report = session.report
    report.within("1 ms: frames in 0.8 s", 200, 830, len(frames))
    if len(frames) < 2:
        return
    passed = (counter(session.product, frames[-1].data) or 0) - (counter(session.product, frames[0].data) or 0)
    seconds = frames[-1].at - frames[0].at
    report.within("1 ms: counter per ms", 0.97, 1.03, passed / (1000 * seconds))


def unsent(context: Context) -> None:
    """The counter also counts periods whose frame was not sent (9.9.3, G13): for some time there is no other node."""
    with context.session() as session:
        start(session, 20)
        before = session.tester.take(5, 1.0)
        session.tester.close()
        session.sleep(0.6)
        session.tester = Tester(session.sensor)
        after = session.tester.collect(0.4)
        if not before or not after:
            session.report.verdict(False, "frames before and after", "some", (len(before), len(after)))
            return
        periods = (after[-1].at - before[-1].at) / 0.020
        first, last = counters(session, [before[-1], after[-1]])
        session.report.within("periods counted while closed", periods - 1.5, periods + 1.5, (last or 0) - (first or 0))
        session.report.equal("no boot-up: the reconnection of a client is no power cycle (G30)", 0, after[0].data[0])


def stored(context: Context) -> None:
    """Cyclic mode in the memory: silent until traffic with automatic detection (G27), at once with a fixed rate."""
    with context.session(store=context.store()) as session:
        start(session, 80)
        session.acknowledged("SAVE", b"\x50SAVE")
        session.tester.send(session.set_id, b"\xffRESET")
        # The sensor may send one more cyclic frame before it restarts; then it must be silent.
        session.tester.collect(0.1)
        session.quiet("RESET with automatic detection: silent, also with cyclic mode", 0.3)
        session.check_wake("then boot-up")
        frames = session.tester.take(6, 1.0)
        values = counters(session, frames)
        good = len(values) == 6 and None not in values and values == list(range(values[0], values[0] + 6))
        session.report.verdict(good, "then cyclic frames", "six with consecutive counters", values)
        session.values[p.BAUD_RATE] = b"\x06"
        session.tester.send(session.set_id, b"\x23\x06")
        session.tester.send(session.set_id, b"\x50SAVE")
        session.tester.collect(0.2)
        session.power_down()
        session.power_up(wake=False)
        frames = session.tester.take(7, 2.0)
        got = [str(frame) for frame in frames[:2]]
        session.report.equal("fixed rate: boot-up comes first", session.boot_up(), got)
        check_run(session, "fixed rate: cyclic from power-up", frames[2:], 1, 0.080)


def modes(context: Context) -> None:
    """Polling, sync and cyclic at once (9.9): every request and every period is answered."""
    with context.session() as session:
        start(session, 20)
        tester = session.tester
        requests = 0
        frames = []
        end = session.now() + 1.5
        while session.now() < end:
            if requests % 3:
                tester.send(session.set_id, b"\x00")
            else:
                tester.send(session.sync_id)
            requests += 1
            frames += tester.collect(0.004)
        tester.send(session.set_id, b"\x26\x00")
        frames += tester.collect(0.2)
        replies = [frame for frame in frames if frame.data[:1] == b"\x00"]
        values = [value if value is not None else -1 for value in counters(session, replies)]
        report = session.report
        report.equal("counters never decrease", sorted(values), values)
        periods = max(values, default=0)
        report.within("periods in 1.5 s", 70, 78, periods)
        report.equal("one reply per request and one frame per period", requests + periods, len(replies))
        missing = set(range(1, periods + 1)) - set(values)
        report.equal("every period was sent", set(), missing)
        report.equal("no other frames than the reply to 26h", 1, len(frames) - len(replies))


def wrap(context: Context) -> None:
    """The counter wraps from 65535 to 0 (G13). Takes 66 s, so it runs only on request."""
    with context.session() as session:
        start(session, 1)
        end = session.now() + 64.5
        while session.now() < end:
            session.tester.collect(0.5)
        frames = session.tester.collect(2.0)
        values = [value if value is not None else -1 for value in counters(session, frames)]
        steps = [(b - a) % 65536 for a, b in zip(values, values[1:])]
        report = session.report
        report.verdict(max(values) > 65000 and min(values) < 1000, "wraps", "65535 -> 0", (max(values), min(values)))
        report.within("longest step in ms", 0, 50, max(steps))


GROUPS = (cyclic, unsent, stored, modes)
SLOW_GROUPS = (wrap,)
