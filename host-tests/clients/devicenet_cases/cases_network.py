"""Network access: the duplicate MAC ID check with its times, the faulted state, and frames that mean nothing."""

import random

from gemac.harness import EXTENDED, Frame

from . import protocol as p
from .runner import Context
from .session import PROBE, Session, text

CHECK_PAUSE = 1.0
# The vendor and serial number of another node.
FOREIGN = "34126F0E0A0D"


def own(session: Session) -> str:
    """Vendor and serial number as they stand in the duplicate MAC ID check."""
    vendor = session.get(p.IDENTITY, 1, 1)
    return vendor + session.get(p.IDENTITY, 1, 6)


def duplicates(session: Session, seconds: float, count: int = 99) -> list[Frame]:
    """The duplicate MAC ID check frames within this time, or the first `count` of them; other frames go to `others`."""
    end = session.now() + seconds
    frames: list[Frame] = []
    while len(frames) < count and (left := end - session.now()) > 0:
        if frame := session.wait_message(p.DUPLICATE, left):
            frames.append(frame)
    return frames


def power_up(context: Context) -> None:
    """Two requests, 1 s apart, and 1 s after the second the sensor is on-line."""
    with context.session(online=False) as session:
        report = session.report
        first, second = duplicates(session, 4, 2)
        report.equal("first request: length", 7, len(first.data))
        report.equal("first request: request on port 0", "00", text(first)[:2])
        report.equal("first request: vendor", p.VENDOR, p.decode(text(first)[2:6]))
        report.equal("second request: as the first", text(first), text(second))
        report.within("first request after the adapter is opened", 0, 0.3, first.at - session.opened)
        report.within("time between the requests", 0.97, 1.06, second.at - first.at)
        report.equal("nothing else is sent", [], [str(frame) for frame in session.others])
        online = session.wait_online(3, 0.02)
        report.within("time from the second request until on-line", 0.97, 1.1, online - second.at)
        session.connect()
        report.equal("vendor and serial as in the identity object", text(first)[2:], own(session))
        report.equal("no third request", [], [str(frame) for frame in duplicates(session, 0.5)])


def lone_node(context: Context) -> None:
    """Nobody acknowledges: the first request stays pending, and the second counts from its acknowledgement (T25)."""
    with context.session(online=False, alone=3.5) as session:
        first, second = duplicates(session, 4, 2)
        session.report.within("first request after the adapter is opened", 0, 0.3, first.at - session.opened)
        # A simulated microcontroller that has sent in vain may be late and catch up.
        session.report.within("time between the requests", 0.85, 1.06, second.at - first.at)
        online = session.wait_online(3, 0.02)
        session.report.within("time from the second request until on-line", 0.97, 1.1, online - second.at)


def silent_before_online(context: Context) -> None:
    """Nothing is answered before the sensor is on-line; frames for other MAC IDs do not matter."""
    with context.session(online=False) as session:
        first = duplicates(session, 3, 1)[0]
        end = first.at + 1.9
        while session.now() < end:
            session.send(p.PORT, "0A4B0301030A")
            session.send(p.EXPLICIT, "0A0E010101")
            session.send(p.POLL)
            session.send(p.ACKNOWLEDGE)
            for mac in (0, 62):
                session.tester.send(p.group2(p.DUPLICATE, mac), bytes.fromhex("00" + FOREIGN))
                session.tester.send(p.group2(p.DUPLICATE, mac), bytes.fromhex("80" + FOREIGN))
            session.collect(0) if len(duplicates(session, 0.1)) else None
        session.report.equal("requests before on-line", [], [str(frame) for frame in session.others])
        session.collect(0.3)
        session.others.clear()
        session.report.equal("on-line after the frames for other MAC IDs", True, session.wait_online(2) is not None)
        session.expect_port("nothing was allocated", "0A4C030101", p.error(p.CHOICE_STATE))


def faulted_at_start(context: Context) -> None:
    """A request or response for its MAC ID while it waits: communication faulted, in both waits, until power is cycled."""
    store = context.store()
    for kind, first_byte in (("request", "00"), ("response", "80")):
        for wait in (1, 2):
            with context.session(online=False, store=store) as session:
                requests = duplicates(session, 4, wait)
                session.sleep(0.4)
                session.send(p.DUPLICATE, first_byte + FOREIGN)
                name = f"{kind} in wait {wait}"
                session.report.equal(f"{name}: requests before", wait, len(requests))
                session.report.equal(f"{name}: not answered, no request follows", [], session.collect(1.0))
                is_faulted(session, name)
    with context.session(store=store) as session:
        session.report.equal("power cycle: on-line again", True, session.allocate(1) == "0ACB00")


def is_faulted(session: Session, name: str, seconds: float = 1.0) -> None:
    """Checks that nothing at all is sent."""
    end = session.now() + seconds
    while session.now() < end:
        session.send(p.PORT, PROBE)
        session.send(p.PORT, "0A4B0301030A")
        session.send(p.EXPLICIT, "0A0E010101")
        session.send(p.POLL)
        session.send(p.DUPLICATE, "00" + FOREIGN)
        session.sleep(0.1)
    session.quiet(f"{name}: faulted, silent")


def online(context: Context) -> None:
    """On-line: a request is answered at once and changes nothing; a response is a fault."""
    with context.session() as session:
        report = session.report
        session.connect(3, poll=0)
        identity = own(session)
        for first_byte in ("00", "01", "7F"):
            session.send(p.DUPLICATE, first_byte + FOREIGN)
            started = session.now()
            frame = session.wait_message(p.DUPLICATE)
            report.equal(f"request with byte 0 = {first_byte}h", "80" + identity, text(frame) if frame else None)
            report.within(f"request with byte 0 = {first_byte}h: time", 0, 0.05, frame.at - started)
        report.equal("connections go on: poll", True, session.poll() is not None)
        report.equal("connections go on: explicit", "01", session.get(p.IDENTITY, 1, 1)[2:])
        for number in range(20):
            session.send(p.DUPLICATE, "00" + FOREIGN)
            frame = session.wait_message(p.DUPLICATE)
            report.equal(f"request {number + 2}", "80" + identity, text(frame) if frame else None)
        for mac in (0, 3, 62):
            for first_byte in ("00", "80"):
                session.ignored("for another MAC ID", (p.group2(p.DUPLICATE, mac), first_byte + FOREIGN))
        report.equal("still on-line", True, session.poll() is not None)
        session.send(p.DUPLICATE, "80" + FOREIGN)
        report.equal("response: not answered", [], session.collect(0.2))
        is_faulted(session, "response while on-line", 2.0)


def cos_ends_with_fault(context: Context) -> None:
    """A fault ends the production of a cyclic connection."""
    with context.session() as session:
        session.connect(0x61, cos=20)
        session.report.within("cyclic messages before", 8, 30, len(session.produced(0.4)))
        session.send(p.DUPLICATE, "80" + FOREIGN)
        session.collect(0.1)
        session.others.clear()
        session.report.equal("cyclic messages after the fault", [], session.collect(0.5))


def meaningless_frames(context: Context) -> None:
    """29-bit frames, remote frames, groups 1, 3 and 4, other messages and other MAC IDs of group 2 are ignored in every state."""
    with context.session() as session:
        for state in ("on-line", "allocated", "poll established"):
            if state == "allocated":
                session.connect(3)
            if state == "poll established":
                session.rate(p.C_POLL, 0)
            ignored_frames(session, state)
        session.report.equal("poll", session.words(session.subject.long), session.poll())


def ignored_frames(session: Session, state: str) -> None:
    """The frames of `meaningless_frames`."""
    requests = (
        (p.POLL, ""),
        (p.PORT, "0B4B0301030B"),
        (p.PORT, "0A4C030103"),
        (p.EXPLICIT, "0A0E010101"),
        (p.DUPLICATE, "00" + FOREIGN),
        (p.DUPLICATE, "80" + FOREIGN),
        (p.ACKNOWLEDGE, ""),
    )
    for message, data in requests:
        identifier = session.id(message)
        session.ignored(f"{state}: 29-bit", (EXTENDED | identifier, data))
        session.ignored(f"{state}: 29-bit, id in the upper bits", (EXTENDED | identifier << 18, data))
        session.ignored(f"{state}: remote frame, length {len(data) // 2}", (identifier, ""), remote=True, dlc=len(data) // 2)
        for mac in (0, session.mac ^ 1, session.mac ^ 32):
            session.ignored(f"{state}: MAC ID {mac}", (p.group2(message, mac), data))
    for message in (p.STROBE, p.MULTICAST_POLL, p.RESPONSE):
        for data in ("", "0A0E010101", "0A4B0301030A", "FFFFFFFFFFFFFFFF"):
            session.ignored(f"{state}: message {message}", (session.id(message), data))
    generator = random.Random(session.mac)
    for name, low, high in (
        ("group 1", 0, 0x3FF),
        ("group 3", 0x600, 0x7BF),
        ("group 4", 0x7C0, 0x7EF),
        ("invalid", 0x7F0, 0x7FF),
    ):
        numbers = [low, high, *(generator.randrange(low, high + 1) for _ in range(20))]
        if name == "group 3":
            numbers += [0x600 | message << 6 | mac for message in range(7) for mac in (session.master, session.mac)]
        for identifiers in (numbers[at : at + 6] for at in range(0, len(numbers), 6)):
            frames = [(one, generator.choice(["", "0A0E010101", "0A4B030103", "0A4B0301030A"])) for one in identifiers]
            session.ignored(f"{state}: {name}", *frames)


GROUPS = (power_up, lone_node, silent_before_online, faulted_at_start, online, cos_ends_with_fault, meaningless_frames)
