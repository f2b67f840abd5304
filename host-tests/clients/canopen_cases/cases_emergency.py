"""Emergency messages, the error register 1001h and the error list 1003h (section 7.6.1, chapter 11, J10)."""

from pathlib import Path

from gemac.harness import Frame

from . import protocol as p
from . import scenes
from .monitoring import lose_master
from .runner import Context
from .session import Session

HISTORY = 50


def emergency(session: Session, timeout: float = 3.0) -> Frame | None:
    """The next emergency message."""
    return session.wait_id(p.EMCY, timeout)


def code(frame: Frame | None) -> int | None:
    """The emergency error code."""
    return p.decode(frame.data[:2]) if frame else None


def history(session: Session) -> list[int]:
    """The error codes of 1003h, the newest first."""
    return [session.get(0x1003, sub) & 0xFFFF for sub in range(1, session.get(0x1003) + 1)]


def out_of_range(context: Context) -> None:
    """Beyond +-45 deg: an emergency message; within the range again: error reset."""
    scene = scenes.steps(context.folder / "range.csv", [(0.0, 0.0), (2.0, 60.0), (4.5, 0.0)])
    with context.session(scene=scene) as session:
        report = session.report
        report.equal("before: 1001h and 1003h", (0, 0), (session.get(0x1001), session.get(0x1003)))
        frame = emergency(session, 4.0)
        check_set(session, "60 deg", frame, 0x00)
        before = code(frame)
        frame = emergency(session, 5.0)
        report.equal("within the range: error reset, and the register is 0", b"\x00\x00\x00", frame.data[:3] if frame else None)
        report.equal("within the range: 1001h", 0, session.get(0x1001))
        report.equal("within the range: the list keeps the error", before, history(session)[-1] if session.get(0x1003) else None)
        report.equal("the state has not changed", p.PRE_OPERATIONAL, session.state())
        for value in (1, 2, 50, 255):
            session.refused(f"1003h:00h = {value}", p.INVALID_VALUE, session.put, 0x1003, 0, value)
        session.put(0x1003, 0, 0)
        session.reads("1003h:00h = 0 clears", 0x1003, 0, 0)
        for sub in (1, HISTORY):
            session.refused(f"1003h:{sub:02X}h: write", p.READ_ONLY, session.download, 0x1003, sub, bytes(4))


def check_set(session: Session, name: str, frame: Frame | None, bits: int) -> None:
    """Checks an emergency message and its entries in 1001h and 1003h."""
    report = session.report
    report.equal(f"{name}: 8 bytes", 8, len(frame.data) if frame else None)
    if frame is None:
        return
    report.verdict(code(frame) != 0, f"{name}: an error code", "not 0", f"{code(frame):04X}h")
    register = session.get(0x1001)
    report.equal(f"{name}: generic bit and its group in 1001h", 1 | bits, register & (1 | bits))
    report.equal(f"{name}: the message contains 1001h", register, frame.data[2])
    report.equal(f"{name}: one entry", 1, session.get(0x1003))
    report.equal(f"{name}: 1003h:01h contains the code", code(frame), session.get(0x1003, 1) & 0xFFFF)


def temperature(context: Context) -> None:
    """Device temperature too high: error 42xxh with the temperature bit."""
    level = scenes.up(0, 0)
    rows = [(0.0, level), (1.5, level), (1.6, level), (5.0, level), (5.1, level)]
    scene = scenes.write(context.folder / "hot.csv", rows, [25.0, 25.0, 150.0, 150.0, 25.0])
    with context.session(scene=scene) as session:
        frame = emergency(session, 5.0)
        check_set(session, "150 degC", frame, 0x08)
        got = f"{code(frame) >> 8:02X}xxh" if frame else None
        session.report.equal("150 degC: device temperature", "42xxh", got)
        frame = emergency(session, 6.0)
        session.report.equal("cooled down: error reset", 0, code(frame))
        session.reads("cooled down: 1001h", 0x1001, 0, 0)


def error_passive(context: Context) -> None:
    """A sensor without acknowledge becomes error passive. It reports the error as soon as a node acknowledges."""
    with context.session() as session:
        session.power_down()
        session.power_up(alone=0.5)
        session.report.equal("error passive: the boot-up message comes first", [], [str(frame) for frame in session.others])
        frame = next((one for one in session.others if one.id == p.EMCY + session.node), None) or emergency(session)
        # The frames are acknowledged now, so the error is only in the list.
        session.report.equal("error passive: code", p.ERROR_PASSIVE, code(frame))
        session.report.equal("error passive: generic and communication bit", 0x11, frame.data[2] if frame else None)
        session.report.equal("error passive: 1003h", [p.ERROR_PASSIVE], history(session))
        frames = [one for one in session.others + session.collect(0.3) if one.id == p.EMCY + session.node and one != frame]
        session.report.equal("acknowledged: error reset", [p.NO_ERROR], [code(one) for one in frames])
        session.reads("acknowledged: 1001h", 0x1001, 0, 0)


def states(context: Context) -> None:
    """Emergency messages in operational, none in stopped."""
    swing = swinging(context.folder / "swing.csv", 0.5, 20)
    with context.session(scene=swing) as session:
        session.put(0x2043, 0, 0)
        session.put(0x1800, 2, 253)
        session.put(0x1801, 2, 253)
        session.nmt(p.START)
        frames = session.collect(4.0, p.EMCY)
        session.report.within("operational: messages in 4 s", 4, 8, len(frames))
        codes = {code(frame) for frame in frames}
        session.report.equal("operational: error and error reset in turn", True, 0 in codes and len(codes) == 2)
        session.nmt(p.STOP)
        session.collect(0.05)
        session.report.equal("stopped: none", [], session.collect(2.0))
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        session.collect(0.05)
        count = session.get(0x1003)
        session.report.within("stopped: errors are still recorded, entries in 1003h", 4, 8, count)


def swinging(path: Path, half: float, count: int) -> Path:
    """A scene that leaves the range or returns to it every `half` s."""
    return scenes.steps(path, [(1.0 + half * step if step else 0.0, 60.0 * (step % 2)) for step in range(count)])


def limit(context: Context) -> None:
    """The range of +-45 deg of both axes, also with an error at the start."""
    within, outside = ((44, 0), (-44, 0), (0, 44), (0, -44)), ((47, 0), (-47, 0), (0, 47), (0, -47))
    for x, y in within + outside:
        beyond = (x, y) in outside
        with context.session(scene=f"tilt={x},{y}") as session:
            session.collect(1.0)
            register = session.get(0x1001)
            session.report.equal(f"tilt {x},{y}: error", beyond, bool(register & 1))
            session.report.equal(f"tilt {x},{y}: entries", int(beyond), session.get(0x1003))
            if beyond:
                session.nmt(p.RESET_NODE)
                frames = [frame.id for frame in session.collect(1.0)]
                wanted = [p.ERROR_CONTROL + session.node, p.EMCY + session.node]
                session.report.equal(f"tilt {x},{y}: boot-up comes before the error", wanted, frames)


def two_errors(context: Context) -> None:
    """One of two errors ends: error reset, and the register still contains the other error."""
    level, tilted = scenes.up(0, 0), scenes.up(60, 0)
    rows = [(0.0, level), (2.0, level), (2.01, tilted), (4.5, tilted), (4.6, tilted), (9.0, tilted), (9.1, level)]
    degrees = [25.0, 25.0, 150.0, 150.0, 25.0, 25.0, 25.0]
    with context.session(scene=scenes.write(context.folder / "both.csv", rows, degrees)) as session:
        frames = session.collect(4.0, p.EMCY)
        session.report.equal("two messages", 2, len(frames))
        session.report.equal("both in 1001h", 0x09, session.get(0x1001) & 0x09)
        frame = emergency(session, 5.0)
        session.report.equal("cooled down: error reset", p.NO_ERROR, code(frame))
        session.report.equal("cooled down: one error is still active", 0x01, frame.data[2] & 0x09 if frame else None)
        session.reads("cooled down: the entries are kept", 0x1003, 0, 2)
        frame = emergency(session, 6.0)
        session.report.equal("level: error reset, no active error", b"\x00\x00\x00", frame.data[:3] if frame else None)


def inhibited(context: Context) -> None:
    """1015h: the minimum interval of emergency messages, in units of 100 us."""
    with context.session(scene=swinging(context.folder / "swing.csv", 0.15, 60)) as session:
        session.put(0x2043, 0, 0)
        session.put(0x1015, 0, 10000)
        session.collect(1.2)
        frames = session.collect(5.0, p.EMCY)
        gaps = [later.at - sooner.at for sooner, later in zip(frames, frames[1:], strict=False)]
        session.report.within("1 s: messages in 5 s", 3, 6, len(frames))
        session.report.within("1 s: shortest interval in s", 0.95, 3.0, min(gaps, default=0))


def identifier(context: Context) -> None:
    """1014h: the identifier of the messages, which is read-only."""
    with context.session() as session:
        session.reads("1014h", 0x1014, 0, p.EMCY + session.node)
        session.refused("1014h: write", p.READ_ONLY, session.download, 0x1014, 0, p.encode(0x8B, 4))
        frame = lose_master(session)
        session.report.equal("life guarding uses this identifier", p.EMCY + session.node, frame.id if frame else None)


def error_list(context: Context) -> None:
    """1003h keeps the 50 newest errors; the oldest one is dropped."""
    scene = scenes.steps(context.folder / "range.csv", [(0.0, 0.0), (1.5, 60.0)])
    with context.session(scene=scene) as session:
        first = code(emergency(session, 4.0))
        session.sleep(0.5)
        for number in range(HISTORY - 1):
            lose_master(session, number == 0)
        codes = history(session)
        session.report.equal("50 entries: number", HISTORY, len(codes))
        session.report.equal("50 entries: the newest is first", p.LIFE_GUARD, codes[0] if codes else None)
        session.report.equal("50 entries: the oldest is last", first, codes[-1] if codes else None)
        lose_master(session, False)
        codes = history(session)
        session.report.equal("51 errors: number", HISTORY, len(codes))
        session.report.equal("51 errors: the oldest is dropped", p.LIFE_GUARD, codes[-1] if codes else None)
        session.refused("1003h:33h is missing", p.NO_SUB_INDEX, session.upload, 0x1003, HISTORY + 1)
        session.put(0x1003, 0, 0)
        session.report.equal("cleared", [], history(session))


GROUPS = (out_of_range, limit, temperature, two_errors, error_passive, states, inhibited, identifier, error_list)
