"""The angle object: type, size, factory value and range of its 22 attributes at each resolution; its filters."""

import statistics

from gemac import scenes

from . import protocol as p
from .runner import Context
from .session import Session

SETTABLE = [entry for entry in p.ATTRIBUTES if entry.range]
# Cycles of the filters per second (T5).
RATE = 1428.0


def factory(context: Context) -> None:
    """Size and factory value of each attribute; reading does not change them."""
    with context.session() as session:
        session.connect()
        report, subject = session.report, session.subject
        measured = {0x72: subject.long, 0x78: subject.long, 0x7A: subject.lateral, 0x80: subject.lateral}
        for _ in range(2):
            for entry in p.ATTRIBUTES:
                report.equal(f"{entry}: size", entry.size, len(session.get(p.ANGLE, 1, entry.id)) // 2)
                report.equal(f"{entry}: factory value", measured.get(entry.id, entry.factory), session.angle(entry.id))
        report.equal("number of attributes", len(p.ATTRIBUTES), session.angle(1))
        report.equal("poll", session.words(subject.long), poll_once(session))


def poll_once(session: Session) -> str | None:
    """The data of a poll, by an allocation for it."""
    session.allocate(2)
    session.rate(p.C_POLL, 0)
    data = session.poll()
    session.release(2)
    return data


def lengths(context: Context) -> None:
    """A value that is too short or too long."""
    with context.session() as session:
        session.connect()
        before = session.angles()
        for entry in p.ATTRIBUTES:
            for length in range(4):
                if entry.range and length == entry.size:
                    continue
                code = p.NOT_SETTABLE if not entry.range else p.TOO_SHORT if length < entry.size else p.TOO_LONG
                data = session.body(p.SET, p.ANGLE, 1, f"{entry.id:02X}" + "00" * length)
                session.expect(f"{entry}: {length} bytes", data, session.error(code))
        session.report.equal("nothing has changed", before, session.angles())


def ranges(context: Context) -> None:
    """The limits and the values beside them, at each resolution."""
    with context.session() as session:
        session.connect()
        for resolution in p.RESOLUTIONS:
            session.put_angle(0x71, resolution)
            for entry in SETTABLE:
                if entry.id != 0x71:
                    limits(session, entry, resolution)


def limits(session: Session, entry: p.Attribute, resolution: int) -> None:
    """The limits of one attribute."""
    low, high = entry.range(session.subject, resolution)
    signed, bits = low < 0, 8 * entry.size
    smallest, biggest = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    for value in sorted({low, low + 1, (low + high) // 2, high - 1, high, 0, 1}):
        if low <= value <= high:
            name = f"resolution {resolution}: {entry} = {value}"
            session.report.equal(f"{name}: accepted", "90", session.set_angle(entry.id, value))
            session.report.equal(f"{name}: read back", value, session.angle(entry.id))
    kept = session.angle(entry.id)
    for value in sorted({smallest, low - 1, high + 1, high + 2, (high + biggest) // 2, biggest}):
        if smallest <= value <= biggest and not low <= value <= high:
            name = f"resolution {resolution}: {entry} = {value}"
            session.report.equal(f"{name}: refused", "94" + p.INVALID_VALUE, session.set_angle(entry.id, value))
    session.report.equal(f"resolution {resolution}: {entry} after the refusals", kept, session.angle(entry.id))
    session.put_angle(entry.id, entry.factory)


def resolutions(context: Context) -> None:
    """The resolution takes 10, 100 and 1000 (T3) with two bytes (T9); the slopes follow, the diagnostic values do not."""
    with context.session() as session:
        session.connect()
        report, subject = session.report, session.subject
        for value in (100, 1000, 10, 1000, 100, 10):
            report.equal(f"resolution {value}: accepted", "90", session.set_angle(0x71, value))
            report.equal(f"resolution {value}: read back", value, session.angle(0x71))
            for other in (0, 1, 9, 11, 99, 101, 255, 256, 266, 999, 1001, 2560, 10000, 65535):
                report.equal(f"resolution {other}: refused", "94" + p.INVALID_VALUE, session.set_angle(0x71, other))
            report.equal(f"resolution {value}: after the refusals", value, session.angle(0x71))
            long, lateral = subject.rounded(subject.long, value), subject.rounded(subject.lateral, value)
            report.equal(f"resolution {value}: slopes", (long, lateral), (session.angle(0x72), session.angle(0x7A)))
            report.equal(f"resolution {value}: poll", session.words(long, lateral), poll_once(session))
            report.equal(
                f"resolution {value}: diagnostic", (subject.long, subject.lateral), (session.angle(0x78), session.angle(0x80))
            )


def attitudes(context: Context) -> None:
    """The slopes at several attitudes, and their signs (T28)."""
    if context.subject.circular:
        angles = [
            (x, y) for x in (0, 0.01, 45, 90, 180, 270, 327.68, 359.96, 359.99) for y in ((0, 20) if x in (45, 270) else (0,))
        ]
    else:
        angles = [(0, 0), (80, 0), (-80, 0), (0, 80), (0, -80), (30, 40), (-45, 20.01), (-0.01, -50)]
    for first in range(0, len(angles), 3):
        sessions = [(one, context.session(scene=f"tilt={one[0]},{one[1]}")) for one in angles[first : first + 3]]
        for (x, y), session in sessions:
            with session:
                session.connect()
                long, lateral = round(100 * x), 0 if context.subject.circular else round(100 * y)
                for resolution in p.RESOLUTIONS:
                    session.put_angle(0x71, resolution)
                    expected = tuple(context.subject.rounded(one, resolution) for one in (long, lateral))
                    got = (session.angle(0x72), session.angle(0x7A))
                    context.report.equal(f"{x}, {y} deg at resolution {resolution}", expected, got)
                context.report.equal(f"{x}, {y} deg: diagnostic", (long, lateral), (session.angle(0x78), session.angle(0x80)))


def step(context: Context, at: float) -> object:
    """A scene that steps by 40 deg `at` s after the start of the process."""
    up = scenes.one_axis_up if context.subject.circular else scenes.two_axis_up
    rows = scenes.plateaus([(0.0, up(10.0, 0.0)), (at, up(50.0, 0.0))])
    return scenes.write(context.folder / f"step{at}.csv", rows)


def rise_time(context: Context, average: int, weight: int) -> float:
    """The time in s from 10 % to 90 % of a step, by polling."""
    at = 6.0
    with context.session(scene=step(context, at)) as session:
        session.connect(3, poll=0)
        session.put_angle(0x84, average)
        session.put_angle(0x85, weight)
        session.sleep(max(0.0, session.sensor.started + at - 0.2 - session.now()))
        samples = []
        while (now := session.now()) < session.sensor.started + at + 1.5:
            data = session.poll()
            if data:
                samples.append(((now + session.now()) / 2, p.decode(data[:4], not session.subject.circular)))
            session.sleep(0.001)
        context.report.equal(
            f"average {average}, weight {weight}: before and after", (1000, 5000), (samples[0][1], samples[-1][1])
        )
        return crossing(samples, 4600) - crossing(samples, 1400)


def crossing(samples: list[tuple[float, int]], level: int) -> float:
    """The time at which the samples first reach a level."""
    for (before, low), (after, high) in zip(samples, samples[1:], strict=False):
        if low < level <= high:
            return before + (after - before) * (level - low) / (high - low)
    return float("nan")


def average_filter(context: Context) -> None:
    """The moving average."""
    for size, expected in ((250, 0.8 * 250 / RATE), (100, 0.8 * 100 / RATE)):
        found = rise_time(context, size, 0)
        context.report.within(f"moving average {size}: 10-90 % in s", 0.95 * expected - 0.003, 1.05 * expected + 0.003, found)


def recursive_filter(context: Context) -> None:
    """The recursive filter: 2.197 time constants."""
    found = rise_time(context, 0, 990)
    context.report.within("weight 990: 10-90 % in s", 0.95 * 0.153 - 0.003, 1.05 * 0.153 + 0.003, found)


def no_filter(context: Context) -> None:
    """Without filters, the step is there within a few ms."""
    context.report.within("no filter: 10-90 % in s", 0, 0.015, rise_time(context, 0, 0))


def held(context: Context) -> None:
    """Weight 1000 holds the output (T29)."""
    with context.session(scene=step(context, 4.5)) as session:
        session.connect()
        session.put_angle(0x85, 1000)
        session.sleep(max(0.0, session.sensor.started + 5.5 - session.now()))
        values = [session.angle(0x72) for _ in range(5)]
        context.report.equal("weight 1000: held over a step", 1000, statistics.median(values))
        session.put_angle(0x85, 0)
        session.sleep(0.3)
        context.report.equal("weight 0: the new angle", 5000, session.angle(0x72))


GROUPS = (factory, lengths, ranges, resolutions, attitudes, average_filter, recursive_filter, no_filter, held)
