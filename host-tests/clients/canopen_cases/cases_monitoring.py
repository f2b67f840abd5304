"""Node guarding, life guarding, heartbeat, and the state after an error (sections 11.1 and 7.6, 1029h)."""

from gemac.harness import EXTENDED, Frame

from . import protocol as p
from .monitoring import lose_master
from .runner import Context


def guarding(context: Context) -> None:
    """Answers to remote frames: the state, and a toggle bit that starts with 0."""
    with context.session() as session:
        def answers(count: int) -> list[str]:
            frames = [session.guard() for _ in range(count)]
            return [frame.data.hex() if frame else "none" for frame in frames]

        session.report.equal("after power-up", ["7f", "ff", "7f", "ff", "7f"], answers(5))
        session.nmt(p.START)
        session.report.equal("operational: the toggle bit continues", ["85", "05"], answers(2))
        session.nmt(p.STOP)
        session.report.equal("stopped", ["84", "04"], answers(2))
        # After these answers the next toggle bit would be 1.
        for command, more in ((p.RESET_COMMUNICATION, 0), (p.RESET_NODE, 1)):
            answers(more)
            session.reset(command)
            session.report.equal(f"after command {command}: the toggle bit is 0 again", ["7f", "ff"], answers(2))
        for dlc in (0, 1, 8):
            session.send(p.ERROR_CONTROL + session.node, remote=True, dlc=dlc)
            frame = session.wait_id(p.ERROR_CONTROL)
            session.report.equal(f"remote frame of length {dlc}: 1 byte", 1, len(frame.data) if frame else None)
        for identifier in (0x70A | EXTENDED, 0x70B, 0x700):
            session.send(identifier, remote=True, dlc=1)
        session.send(0x70A, b"\x00")
        session.quiet("29 bit, other nodes, a data frame")


def life_guarding(context: Context) -> None:
    """The master stops guarding: an emergency message, and pre-operational."""
    with context.session() as session:
        session.put(0x100C, 0, 50)
        session.put(0x100D, 0, 3)
        session.nmt(p.START)
        session.put(0x1800, 2, 253)
        session.quiet("not before the first guarding", 0.5)
        for _ in range(10):
            session.guard()
            session.sleep(0.05)
        session.report.equal("guarding in time: no message", [], [f for f in session.others if f.id == 0x8A])
        last = session.guard()
        frame = session.wait_id(p.EMCY, 2.0)
        session.report.equal("guarding ended: code 8130h", "3081", frame.data[:2].hex() if frame else None)
        if frame and last:
            session.report.within("life time of 150 ms in s", 0.14, 0.25, frame.at - last.at)
            session.report.equal("the communication bit", 0x11, frame.data[2] & 0x11)
        session.report.equal("1003h:01h", p.LIFE_GUARD, session.get(0x1003, 1) & 0xFFFF)
        session.check_state("pre-operational", p.PRE_OPERATIONAL)
        reset = session.wait(lambda frame: frame.id == 0x8A and not any(frame.data[:2]), 1.0) or next(
            (frame for frame in session.others if frame.id == 0x8A and not any(frame.data[:2])), None
        )
        session.report.verdict(reset is not None, "guarded again: error reset", "code 0", str(reset))
        for index in (0x100C, 0x100D):
            with context.session() as other:
                other.put(0x100C, 0, 20)
                other.put(0x100D, 0, 2)
                other.put(index, 0, 0)
                other.guard()
                other.quiet(f"{index:04X}h = 0: no life guarding", 0.4)


def shortest_overflow() -> tuple[int, int]:
    """The guard time (ms) and factor whose product in us is the lowest above 2^32."""
    pairs = [((1 << 32) // 1000 // factor + 1, factor) for factor in range(66, 256)]
    return min(pairs, key=lambda pair: pair[0] * pair[1])


def long_life(context: Context) -> None:
    """A life time of more than 2^32 us; its lowest 32 bits would be a short time."""
    guard_time, factor = shortest_overflow()
    with context.session() as session:
        session.put(0x100C, 0, guard_time)
        session.put(0x100D, 0, factor)
        session.guard()
        session.quiet(f"guard time {guard_time} ms, factor {factor}: life guarding does not time out", 1.0)


def error_behaviour(context: Context) -> None:
    """1029h: the state after a life guarding time-out."""
    for way, before in ((p.START, p.OPERATIONAL), (p.STOP, p.STOPPED), (p.ENTER_PRE_OPERATIONAL, p.PRE_OPERATIONAL)):
        for value, after in ((0, p.PRE_OPERATIONAL if before == p.OPERATIONAL else before), (1, before), (2, p.STOPPED)):
            with context.session() as session:
                session.put(0x1029, 1, value)
                session.put(0x100C, 0, 20)
                session.put(0x100D, 0, 2)
                session.nmt(way)
                session.guard()
                session.collect(0.3)
                session.check_state(f"1029h:01h = {value} in state {before}", after)


def heartbeat(context: Context) -> None:
    """1017h: period, state, change, off."""
    with context.session() as session:
        for milliseconds in (10, 50, 100):
            session.put(0x1017, 0, milliseconds)
            frames = session.collect(1.05, p.ERROR_CONTROL)
            period = milliseconds / 1000
            count = len(frames)
            mean = (frames[-1].at - frames[0].at) / (count - 1) if count > 1 else 0
            session.report.within(f"{milliseconds} ms: mean period in s", 0.98 * period, 1.02 * period, mean)
            states = {frame.data.hex() for frame in frames}
            session.report.equal(f"{milliseconds} ms: the state, without a toggle bit", {"7f"}, states)
        for way, state in ((p.START, "05"), (p.STOP, "04"), (p.ENTER_PRE_OPERATIONAL, "7f")):
            session.nmt(way)
            session.collect(0.05)
            got = {frame.data.hex() for frame in session.collect(0.35, p.ERROR_CONTROL)}
            session.report.equal(f"command {way}: the state in the heartbeat", {state}, got)
        session.put(0x1017, 0, 0)
        session.quiet("0 ms switches it off", 0.4)
        session.put(0x1017, 0, 50)
        session.reset(p.RESET_COMMUNICATION)
        session.quiet("off after a reset without a save", 0.3)


def heartbeat_and_guarding(context: Context) -> None:
    """Heartbeat overrides node guarding (section 11.1, J24; CiA 301, 7.2.8.2.2)."""
    with context.session() as session:
        session.put(0x1017, 0, 100)
        for _ in range(5):
            session.send(p.ERROR_CONTROL + session.node, remote=True, dlc=1)
        frames = session.collect(1.0, p.ERROR_CONTROL)
        session.report.within("heartbeat on: remote frames are not answered, frames in 1 s", 9, 11, len(frames))
        session.report.equal("heartbeat on: no toggle bit", {"7f"}, {frame.data.hex() for frame in frames})
        session.put(0x100C, 0, 20)
        session.put(0x100D, 0, 2)
        session.send(p.ERROR_CONTROL + session.node, remote=True, dlc=1)
        session.report.equal("both on: no life guarding", [], session.collect(0.5, p.EMCY))
        session.report.within("both on: heartbeats in 1 s", 9, 11, len(session.collect(1.0, p.ERROR_CONTROL)))
        session.put(0x1017, 0, 0)
        session.collect(0.15)
        got = [session.state(), session.state()]
        session.report.equal("heartbeat off: guarding is answered", [p.PRE_OPERATIONAL] * 2, got)
        frame = session.wait_id(p.EMCY, 1.0)
        session.report.equal("heartbeat off: life guarding works", "3081", frame.data[:2].hex() if frame else None)


def reported_once(context: Context) -> None:
    """A life guarding time-out is reported reported_once, and the next time-out again."""
    with context.session() as session:
        first = lose_master(session)
        session.report.verdict(first is not None, "time-out: reported", "a message", str(first))
        session.report.equal("no second report", [], [str(f) for f in session.collect(0.4)])
        again = lose_master(session, False)
        session.report.verdict(again is not None, "time-out after new guarding: reported", "a message", str(again))


def resets_guarding(context: Context) -> None:
    """A reset ends life guarding until the next guarding of the master."""
    with context.session() as session:
        session.put(0x100C, 0, 200)
        session.put(0x100D, 0, 2)
        session.guard()
        session.nmt(p.RESET_COMMUNICATION)
        frames = [str(frame) for frame in session.collect(0.8)]
        session.report.equal("only the boot-up message", [str(Frame(0x70A, b"\x00"))], frames)
        for command in (p.RESET_COMMUNICATION, p.RESET_NODE):
            lose_master(session)
            session.nmt(command)
            frames = [str(frame) for frame in session.collect(0.5)]
            # After reset communication the sensor may send the error reset of an error in its list, after the boot-up message.
            wanted = ["70A#00", "08A#0000000000000000"][: 2 if command == p.RESET_COMMUNICATION else 1]
            name = f"after a time-out, command {command}"
            session.report.verdict(frames in (wanted, wanted[:1]), f"{name}: boot-up, no error", wanted, frames)
            session.reads(f"{name}: 1001h", 0x1001, 0, 0)
            session.report.equal(f"{name}: the toggle bit is 0 again", p.PRE_OPERATIONAL, session.guard().data[0])


GROUPS = (guarding, life_guarding, long_life, error_behaviour, heartbeat, heartbeat_and_guarding, reported_once, resets_guarding)
