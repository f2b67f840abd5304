"""Transmission rates and priorities of the process data, latency, clipping (S20, S30, S35, S36)."""

from canopen_cases import scenes
from canopen_cases.runner import Context
from gemac.harness import Frame

from . import protocol as p
from . import values as v
from .session import Node


ALONE, TOGETHER = 0.0015, 0.004  # the greatest delay in s by a frame on the bus, and by the frames of other groups and nodes


def intervals(session: Node, name: str, frames: list[Frame], period: float, delay: float = ALONE) -> None:
    """Checks the times between frames."""
    steps = [later.at - earlier.at for earlier, later in zip(frames, frames[1:], strict=False)]
    if not steps:
        session.report.verdict(False, name, f"every {period} s", "no two frames")
        return
    mean, error = sum(steps) / len(steps), delay / len(steps)
    session.report.within(f"{name}: mean in s", period - error, period + error, mean)
    session.report.within(f"{name}: shortest in s", period - delay, period + delay, min(steps))
    session.report.within(f"{name}: longest in s", period - delay, period + delay, max(steps))


def delivered(context: Context) -> None:
    """S30: as delivered, SSI2 every 10 ms with priority 3, and DM1; nothing else."""
    with Node(context, {(0x2104, 1): 10}) as session:
        frames = session.tester.collect(3.0)
        heads = {f"{frame.id & 0x1FFFFFFF:08X}" for frame in frames}
        session.report.equal("S30 S31 groups as delivered", {"0CF02980", "18FECA80"}, heads)
        intervals(session, "S31 SSI2 every 10 ms", [frame for frame in frames if p.split(frame).pgn == p.SSI2], 0.01)


def rates(context: Context) -> None:
    """S20: the rate of each group; 0 is off; a change acts at once."""
    with Node(context) as session:
        for sub, pgn in enumerate(p.PROCESS, 1):
            for milliseconds in (10, 11, 25, 50, 100, 333):
                session.put(0x2104, sub, milliseconds)
                session.wait(lambda frame: False, 0.05)
                frames = session.all_of(pgn, max(0.6, milliseconds / 1000 * 4))
                intervals(session, f"S20 2104h:{sub:02X} = {milliseconds}", frames, milliseconds / 1000)
            session.put(0x2104, sub, 0)
            session.wait(lambda frame: False, 0.05)
            session.report.equal(f"S20 2104h:{sub:02X} = 0: off", 0, len(session.all_of(pgn, 0.4)))
            session.report.equal(f"S26 2104h:{sub:02X} = 0: on request", True, session.ask(pgn) is not None)
        periods = (20, 30, 50, 70)
        for sub, milliseconds in enumerate(periods, 1):
            session.put(0x2104, sub, milliseconds)
        frames = session.tester.collect(3.0)
        for pgn, milliseconds in zip(p.PROCESS, periods, strict=True):
            mine = [frame for frame in frames if p.split(frame).pgn == pgn]
            count = 3000 / milliseconds
            session.report.within(f"S20 all four at once: {pgn}, number in 3 s", count - 1, count + 1, len(mine))
            intervals(session, f"S20 all four at once: {pgn}", mine, milliseconds / 1000, TOGETHER)


def loaded(context: Context) -> None:
    """S31: SSI2 keeps its rate while other nodes send claims, engine data, requests and parameters."""
    with Node(context, {(0x2104, 1): 10}) as session:
        frames = []
        for number in range(100):
            session.tx(
                "18EF8021#4000100000000000",
                session.request(65262),
                p.claim(0x40 + number % 30, p.other_name(number)),
                f"0CF004{number % 64:02X}#0102030405060708",
                session.request(p.CLAIMED, p.GLOBAL),
            )
            frames += session.tester.collect(0.012)
        intervals(session, "S31 SSI2 on a busy bus", [frame for frame in frames if p.split(frame).pgn == p.SSI2], 0.01, TOGETHER)


def slow(context: Context) -> None:
    """S20: long periods: the first frame after one period or at once, then each period."""
    with Node(context) as session:
        session.put(0x2104, 2, 2000)
        frames = session.all_of(p.SSI, 7.0)
        intervals(session, "S20 2104h:02 = 2000", frames, 2.0)
        session.put(0x2104, 2, 65535)
        session.wait(lambda frame: False, 0.05)
        session.report.within("S20 2104h:02 = 65535: number in 3 s", 0, 1, len(session.all_of(p.SSI, 3.0)))


def priorities(context: Context) -> None:
    """S20: the priority of each group, cyclic and requested; a change acts at once."""
    with Node(context) as session:
        for sub, pgn in enumerate(p.PROCESS, 1):
            for priority in range(8):
                session.put(0x2105, sub, priority)
                session.others.clear()
                session.tx(session.request(pgn))
                frame = session.wait_pgn(pgn)
                session.report.equal(
                    f"S20 2105h:{sub:02X} = {priority}, requested", priority, p.split(frame).priority if frame else None
                )
            session.put(0x2104, sub, 20)
            frame = session.wait_pgn(pgn)
            session.report.equal(f"S20 2105h:{sub:02X} = 7, cyclic", 7, p.split(frame).priority if frame else None)
            session.put(0x2104, sub, 0)
            session.put(0x2105, sub, 3)


def latency(context: Context) -> None:
    """S35: byte 8 of SSI2 and SSI is the delay at DC of the filter in force."""
    with Node(context) as session:
        for kind, frequencies in (
            (0, (2000,)),
            (1, (100, 1000, 6520, 6530, 7000, 8000, 10000, 12500, 15000, 20000, 25000)),
            (2, (100, 1000, 2000, 3050, 3060, 3100, 4000, 5000, 6000, 7000, 7777, 8000)),
        ):
            session.put(0x3111, 0, 2000)
            session.put(0x3110, 1, kind)
            for frequency in frequencies:
                session.put(0x3111, 0, frequency)
                expected = v.latency(kind, frequency)
                name = f"S35 filter {kind}, {frequency} mHz: latency"
                session.becomes(f"{name} of SSI2", p.SSI2, v.ssi2(0.0, 0.0, last=expected))
                session.becomes(f"{name} of SSI", p.SSI, v.ssi(0.0, 0.0, last=expected))
                session.report.equal(
                    f"{name} of ARI, ACCS: none", (0xFF, 0xFF), (session.ask(p.ARI)[7], session.ask(p.ACCS)[7])
                )
        session.put(0x3110, 2, 1)
        session.becomes("S35 fusion: latency 0", p.SSI2, v.ssi2(0.0, 0.0, last=frozenset({0})))
        session.put(0x3110, 2, 0)
        session.becomes("S35 fusion off: as the filter", p.SSI2, v.ssi2(0.0, 0.0, last=v.latency(2, 8000)))


def clipping(context: Context) -> None:
    """S36: while an accelerometer axis clips, both are degraded; the angle is still sent."""
    level, shock = (0.0, 0.0, 1.0), (0.0, 0.0, 3.0)
    rows = [(0.0, level), (3.0, level), (3.001, shock), (6.0, shock), (6.001, level)]
    for variant, roll in ((1, 0.0), (0, None)):
        settings = {(0x3120, 1): variant, (0x3110, 1): 0}
        with Node(context, settings, scene=scenes.write(context.folder / "shock.csv", rows), name=f"clip{variant}") as session:
            pitch = 0.0 if variant else None
            if variant:
                session.becomes("S35 before: good", p.SSI2, v.ssi2(pitch, roll))
                session.becomes("S36 clipping: degraded", p.SSI2, v.ssi2(pitch, roll, states=(1, 1)), timeout=8.0)
                session.report.equal("S36 clipping: SSI", "007D007D007DC500", session.ask(p.SSI).hex().upper())
                session.becomes("S36 afterwards: good", p.SSI2, v.ssi2(pitch, roll), timeout=8.0)
            else:
                quality = [session.ask(p.SSI2)[6]]
                while len(quality) < 400 and (quality[-1] == 0xF3 or len(set(quality)) < 2):
                    quality.append(session.ask(p.SSI2)[6])
                    session.wait(lambda frame: False, 0.02)
                session.report.equal(
                    "S36 one axis: good, then degraded while it clips; roll not available",
                    [0xF3, 0xF7],
                    [quality[0], quality[-1]],
                )


GROUPS = (delivered, rates, loaded, slow, priorities, latency, clipping)
