"""Watchdogs: when connections time out, and what each action does."""

from . import protocol as p
from .runner import Context
from .session import Session

# The default of the explicit connection (4 x 2500 ms) and the least time of an I/O connection until its first consumption.
LONG = 10.0
TOLERANCE = (-0.01, 0.11)


def timed(session: Session, name: str, expected: float, since: float, at: float | None) -> None:
    """Checks the time of an event."""
    if at is None:
        session.report.verdict(False, name, f"after {expected} s", "not")
    else:
        session.report.within(name, expected + TOLERANCE[0], expected + TOLERANCE[1], at - since)


def until(session: Session, wanted: int, instance: int, limit: float, step: float = 0.02) -> float | None:
    """Reads the state of a connection until it is the wanted one; returns the time."""
    end = session.now() + limit
    while session.now() < end:
        if session.state(instance) == wanted:
            return session.now()
        session.sleep(step)
    return None


def explicit_default(context: Context) -> None:
    """The explicit connection dies 10 s after the last request to it."""
    with context.session() as session:
        session.allocate(1)
        session.sleep(6)
        session.expect("request after 6 s", "0A0E030101", "0A8E3F")
        session.sleep(6)
        session.expect("request after 6 s more", "0A0E030163", session.error(p.NO_ATTRIBUTE))
        last = session.now()
        # Neither the port nor frames of other nodes keep it alive.
        timed(session, "explicit connection dies", LONG, last, session.until_free(13))


def explicit_rates(context: Context) -> None:
    """4 x the rate, from the set and from each request; a change of the rate acts at once."""
    with context.session() as session:
        for rate in (100, 250, 700):
            session.allocate(1)
            session.rate(p.C_EXPLICIT, rate)
            since = session.now()
            timed(session, f"rate {rate}: from the set", 0.004 * rate, since, session.until_free(6))
            session.release(1, p.OTHER)
            session.allocate(1)
            session.rate(p.C_EXPLICIT, rate)
            for _ in range(4):
                session.sleep(0.003 * rate)
                session.expect(f"rate {rate}: kept alive", "0A0E030101", "0A8E3F")
            timed(session, f"rate {rate}: from the last request", 0.004 * rate, session.now(), session.until_free(6))
            session.ignored(f"rate {rate}: explicit is gone", (session.id(p.EXPLICIT), "0A0E030101"))
            session.release(1, p.OTHER)
        session.allocate(1)
        session.rate(p.C_EXPLICIT, 60000)
        session.rate(p.C_EXPLICIT, 100)
        timed(session, "from 60000 to 100", 0.4, session.now(), session.until_free(6))
        session.release(1, p.OTHER)
        session.allocate(1)
        session.rate(p.C_EXPLICIT, 100)
        session.ask("4A0E030199")
        session.send(p.EXPLICIT, "8A00106501")
        session.wait_message(p.RESPONSE)
        session.sleep(0.25)
        timed(session, "a refused request and a fragment keep it alive", 0.4, session.now() - 0.25, session.until_free(6))


def explicit_for_ever(context: Context) -> None:
    """Rate 0: no time-out."""
    with context.session() as session:
        session.connect()
        session.report.equal("rate 0: still owned after 12 s", None, session.until_free(12, step=0.5))
        session.expect("rate 0: still there", "0A0E030101", "0A8E3F")


def action_delete(context: Context) -> None:
    """Action 1: deleted, its bit cleared; established I/O and the owner stay, and the owner may allocate it again."""
    with context.session() as session:
        report = session.report
        session.connect(3, poll=0, explicit=0)
        session.rate(p.C_EXPLICIT, 100)
        session.sleep(0.6)
        session.ignored("explicit is gone", (session.id(p.EXPLICIT), "0A0E030101"))
        report.equal("poll goes on", True, session.poll() is not None)
        session.expect_port("another master", "0B4B0301010B", p.error(p.PORT_BUSY, 0x0B))
        session.expect_port("release of explicit", "0A4C030101", p.error(p.CHOICE_STATE))
        session.expect_port("poll without explicit", "0A4B0301100A", p.error(p.CHOICE_INVALID))
        session.expect_port("the owner again", "0A4B0301010A", "0ACB00")
        report.equal("allocation", "030A", session.get(3, 1, 5))
        report.equal("poll goes on", True, session.poll() is not None)
        session.rate(p.C_EXPLICIT, 100)
        session.sleep(0.6)
        session.expect_port("release of poll, nothing is established then", "0A4C030102", "0ACC")
        session.expect_port("free", "0B4B0301030B", "0BCB00")


def action_defer(context: Context) -> None:
    """Action 3 with I/O established: deferred, still allocated; the next request establishes it again."""
    with context.session() as session:
        report = session.report
        session.connect(3, poll=0)
        session.put(p.CONNECTION, 1, 12, "03")
        for _ in range(2):
            session.rate(p.C_EXPLICIT, 100)
            session.sleep(0.6)
            report.equal("deferred: poll goes on", True, session.poll() is not None)
            session.expect_port("deferred: still allocated", "0A4B0301010A", p.error(p.CHOICE_STATE))
            session.expect_port("deferred: another master", "0B4B0301010B", p.error(p.PORT_BUSY, 0x0B))
            session.expect("the next request is served", "0A0E050101", "0A8E03")
            report.equal("allocation", "030A", session.get(3, 1, 5))
        session.sleep(0.6)
        session.expect("deferred again, then a set", "0A100501090000", "0A900000")
        session.rate(p.C_EXPLICIT, 100)
        session.sleep(0.6)
        session.expect_port("release of a deferred connection", "0A4C030101", "0ACC")
        session.ignored("released", (session.id(p.EXPLICIT), "0A0E050101"))
        report.equal("poll goes on", True, session.poll() is not None)


def defer_ends(context: Context) -> None:
    """A deferred explicit connection is deleted with the time-out of I/O; without established I/O it is not deferred."""
    with context.session() as session:
        session.connect(3, poll=300)
        session.put(p.CONNECTION, 1, 12, "03")
        session.rate(p.C_EXPLICIT, 100)
        session.poll()
        last = session.now()
        session.sleep(0.7)
        session.expect_port("deferred: another master", "0B4B0301010B", p.error(p.PORT_BUSY, 0x0B))
        timed(session, "deferred, then poll times out: all is free", 1.2, last, session.until_free(6))
        session.release(1, p.OTHER)
        for name, choice in (("explicit alone", 1), ("poll configuring", 3)):
            session.connect(choice)
            session.put(p.CONNECTION, 1, 12, "03")
            session.rate(p.C_EXPLICIT, 100)
            timed(session, f"action 3, {name}: deleted", 0.4, session.now(), session.until_free(6))
            session.release(1, p.OTHER)
        session.connect(0x13, cos=0)
        session.put(p.CONNECTION, 1, 12, "03")
        session.rate(p.C_EXPLICIT, 100)
        session.sleep(0.6)
        session.expect("COS established: deferred", "0A0E050101", "0A8E03")


def poll_times_out(context: Context) -> None:
    """4 x the rate after the last poll: timed out, bit cleared, no answer; it may be allocated again, or released."""
    with context.session() as session:
        report = session.report
        session.connect(3, poll=100)
        for _ in range(3):
            session.poll()
            session.sleep(0.3)
            report.equal("kept alive", p.ESTABLISHED, session.state(p.C_POLL))
        session.poll()
        timed(session, "poll times out", 0.4, session.now(), until(session, p.TIMED_OUT, p.C_POLL, 2))
        report.equal("timed out: no answer", None, session.poll(timeout=0.1))
        report.equal("timed out: allocation", "010A", session.get(3, 1, 5))
        report.equal("timed out: still timed out", p.TIMED_OUT, session.state(p.C_POLL))
        session.expect_port("timed out: the owner allocates it again", "0A4B0301020A", "0ACB00")
        report.equal("again: allocation", "030A", session.get(3, 1, 5))
        report.equal("again: configuring", p.CONFIGURING, session.state(p.C_POLL))
        report.equal("again: no answer before the rate", None, session.poll(timeout=0.1))
        session.rate(p.C_POLL, 100)
        report.equal("again: poll", True, session.poll() is not None)
        session.sleep(0.6)
        report.equal("timed out again", p.TIMED_OUT, session.state(p.C_POLL))
        session.expect_port("timed out: release", "0A4C030102", "0ACC")
        report.equal("released", "?94" + p.NO_OBJECT, session.get(p.CONNECTION, p.C_POLL, 1))
        session.release(1)
        session.connect(3, poll=100)
        session.poll()
        session.sleep(0.2)
        session.rate(p.C_POLL, 0)
        session.sleep(1.0)
        report.equal("rate 0: established", p.ESTABLISHED, session.state(p.C_POLL))
        report.equal("rate 0: poll", True, session.poll() is not None)


def deferred_and_released(context: Context) -> None:
    """Releases of the last established connection: everything is released, also what is deferred or timed out."""
    with context.session() as session:
        for name, choice, release in (("poll", 0x03, 0x02), ("COS", 0x51, 0x10), ("both", 0x53, 0x52)):
            rates = {key: 0 for key, bits in (("poll", 0x02), ("cos", 0x30)) if choice & bits}
            session.connect(choice, **rates)
            session.put(p.CONNECTION, 1, 12, "03")
            session.rate(p.C_EXPLICIT, 50)
            session.sleep(0.5)
            session.expect_port(f"deferred beside {name}: release", f"0A4C0301{release:02X}", "0ACC")
            session.expect_port(f"deferred beside {name}: all is free", "0B4B0301030B", "0BCB00")
            session.release(3, p.OTHER)
        session.connect(3, poll=20)
        session.poll()
        session.sleep(0.3)
        session.expect_port("poll timed out: release of both", "0A4C030103", "0ACC")
        session.expect_port("free", "0B4B0301010B", "0BCB00")
        session.release(1, p.OTHER)
        session.connect(0x13, poll=20, cos=0)
        session.poll()
        session.sleep(0.3)
        session.report.equal("poll timed out beside COS: allocation", "110A", session.get(3, 1, 5))
        session.report.equal("poll timed out beside COS: COS is established", p.ESTABLISHED, session.state(p.C_COS))


def short_rates(context: Context) -> None:
    """Poll rates of 1 and 2 ms: 4 and 8 ms after the first poll it is timed out."""
    with context.session() as session:
        for rate in (1, 2, 10):
            session.connect(3, poll=rate)
            session.report.equal(f"rate {rate}: established", p.ESTABLISHED, session.state(p.C_POLL))
            session.report.equal(f"rate {rate}: first poll", True, session.poll() is not None)
            session.sleep(0.1)
            session.report.equal(f"rate {rate}: timed out", p.TIMED_OUT, session.state(p.C_POLL))
            session.report.equal(f"rate {rate}: no answer", None, session.poll(timeout=0.1))
            session.release(1)


def fragments_end(context: Context) -> None:
    """A time-out of the explicit connection ends a fragmented answer and a fragmented request."""
    with context.session() as session:
        session.allocate(1)
        session.rate(p.C_EXPLICIT, 100)
        session.ask("0A0E010107")
        session.quiet("no second fragment 0 after the time-out", 1.5)
        session.connect()
        session.send(p.EXPLICIT, "8AC000")
        session.quiet("an acknowledge in the new connection", 0.1)
        session.rate(p.C_EXPLICIT, 100)
        session.expect("first fragment of a request", "8A00106501", "8AC000")
        session.sleep(0.6)
        session.connect()
        session.send(p.EXPLICIT, "8A81850900")
        session.quiet("the rest in the new connection", 0.1)
        session.report.equal("nothing has changed", 0, session.angle(0x85))


def poll_with_data(context: Context) -> None:
    """A poll command with data is not consumed (T26): no answer, no restart of the watchdog."""
    with context.session() as session:
        session.connect(3, poll=250)
        for data in ("00", "0000", "0A0E010101", "FFFFFFFFFFFFFFFF"):
            session.report.equal(f"poll with data {data}", None, session.poll(data, timeout=0.08))
        session.poll()
        last = session.now()
        while session.now() < last + 0.8:
            session.send(p.POLL, "00")
            session.sleep(0.05)
        timed(session, "poll times out", 1.0, last, until(session, p.TIMED_OUT, p.C_POLL, 2))


def first_poll(context: Context) -> None:
    """Before the first consumption the watchdog waits 10 s, or 4 x the rate if that is longer."""
    with context.session() as session:
        session.connect(3, poll=50)
        timed(session, "rate 50: never polled", LONG, session.now(), until(session, p.TIMED_OUT, p.C_POLL, 12, 0.03))
        session.report.equal("timed out: allocation", "010A", session.get(3, 1, 5))


def first_poll_slow(context: Context) -> None:
    """The same with a rate of 3 s."""
    with context.session() as session:
        session.connect(3, poll=3000)
        timed(session, "rate 3000: never polled", 12.0, session.now(), until(session, p.TIMED_OUT, p.C_POLL, 14, 0.03))


def first_poll_late(context: Context) -> None:
    """A first poll within the 10 s, then 4 x the rate."""
    with context.session() as session:
        session.connect(3, poll=100)
        session.sleep(8)
        session.report.equal("first poll after 8 s", True, session.poll() is not None)
        timed(session, "then 4 x the rate", 0.4, session.now(), until(session, p.TIMED_OUT, p.C_POLL, 3))


def cos_times_out(context: Context) -> None:
    """A COS connection without acknowledges: 10 s at first, then 4 x the rate after the last acknowledge."""
    with context.session() as session:
        session.connect(0x11, cos=100)
        since = session.now()
        while session.now() < since + 3:
            if session.wait(lambda frame: frame.id == p.change_of_state(session.mac), 0.3):
                session.send(p.ACKNOWLEDGE)
        last = session.now()
        session.report.equal("acknowledged for 3 s", p.ESTABLISHED, session.state(p.C_COS))
        at = until(session, p.TIMED_OUT, p.C_COS, 3)
        session.report.within("times out after the last acknowledge", 0.2, 0.55, (at or 99) - last)
        session.others.clear()
        session.report.equal("no production", [], [str(frame) for frame in session.produced(0.5)])
        session.report.equal("allocation", "010A", session.get(3, 1, 5))
        session.allocate(0x20)
        session.rate(p.C_COS, 100)
        since = session.now()
        timed(session, "cyclic, never acknowledged", LONG, since, until(session, p.TIMED_OUT, p.C_COS, 12, 0.03))


def acknowledge_with_data(context: Context) -> None:
    """An acknowledge with data is not consumed."""
    with context.session() as session:
        session.connect(0x21, cos=250)
        session.send(p.ACKNOWLEDGE)
        last = session.now()
        while session.now() < last + 0.8:
            session.send(p.ACKNOWLEDGE, "00")
            session.sleep(0.05)
        timed(session, "times out", 1.0, last, until(session, p.TIMED_OUT, p.C_COS, 2))


def suppressed_never_times_out(context: Context) -> None:
    """A connection that only produces never times out."""
    with context.session() as session:
        session.connect(0x51, cos=100)
        frames = session.produced(12.0)
        session.report.within("messages in 12 s", 112, 128, len(frames))
        session.report.equal("established", p.ESTABLISHED, session.state(p.C_COS))


GROUPS = (
    explicit_default,
    explicit_rates,
    explicit_for_ever,
    action_delete,
    action_defer,
    defer_ends,
    poll_times_out,
    deferred_and_released,
    short_rates,
    fragments_end,
    poll_with_data,
    first_poll,
    first_poll_slow,
    first_poll_late,
    cos_times_out,
    acknowledge_with_data,
    suppressed_never_times_out,
)
