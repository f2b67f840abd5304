"""IMS360: the four TPDOs and their dynamic mapping (section 6.1, S4, S5, S10, S45..S52)."""

import itertools

from . import protocol as p
from . import scenes
from .cases_pdo import syncs
from .ims360_objects import GYRO, LATERAL, LONGITUDINAL, MAPPABLE, NODE, OBJECTS, PDO_CONFIGURATION, entry
from .runner import Context
from .session import Session

BASES = (0x180, 0x280, 0x380, 0x480)


def remap(session: Session, number: int, entries: list[int], cob_id: int | None = None) -> None:
    """Maps objects into a TPDO by the steps of 6.1.3."""
    cob_id = BASES[number] + NODE if cob_id is None else cob_id
    session.put(0x1800 + number, 1, p.INVALID | cob_id)
    session.put(0x1A00 + number, 0, 0)
    for sub, value in enumerate(entries, 1):
        session.put(0x1A00 + number, sub, value)
    session.put(0x1A00 + number, 0, len(entries))
    session.put(0x1800 + number, 1, cob_id)


def example(context: Context) -> None:
    """The example of 6.1.3 with its identifier: TPDO 2 sends the angular rates every 100 ms."""
    with context.session() as session:
        session.put(0x1801, 1, 0x800001B2)
        session.put(0x1A01, 0, 0)
        for sub, value in enumerate(GYRO, 1):
            session.put(0x1A01, sub, value)
        session.put(0x1A01, 0, 3)
        session.put(0x1801, 1, 0x1B2)
        session.put(0x1801, 5, 100)
        session.nmt(p.START)
        frames = session.collect(1.05, 0x180)
        session.report.within("TPDOs in 1.05 s", 9, 11, len(frames))
        session.report.equal("length of the TPDO", {6}, {len(frame.data) for frame in frames})
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        session.quiet("none in pre-operational", 0.25)


def configuration(context: Context) -> None:
    """What dcfgen writes to the sensor, in both states."""
    with context.session(scene="tilt=12.34,-5.67") as session:
        session.settle()
        for state in (p.ENTER_PRE_OPERATIONAL, p.START):
            session.nmt(state)
            session.put(0x1801, 1, p.INVALID | 0x2B2)
            codes = [session.abort_code(session.put, *written) for written in PDO_CONFIGURATION]
            session.report.equal(f"NMT command {state}: aborts", [0] * len(PDO_CONFIGURATION), codes)
        frames = session.collect(0.5, 0x280)
        session.report.within("TPDOs in 0.5 s", 20, 27, len(frames))
        session.report.equal("contents", {p.encode(-567, 4) + b"\x01"}, {frame.data for frame in frames[1:]})


def steps(context: Context) -> None:
    """A wrong step is aborted and changes nothing; what is there already is accepted."""
    for state in (p.ENTER_PRE_OPERATIONAL, p.START):
        with context.session() as session:
            session.nmt(state)
            for sub, value in ((0, 0), (0, 1), (1, LATERAL), (3, LATERAL)):
                session.refused(f"1A00h:{sub:02X}h while valid", p.UNSUPPORTED_ACCESS, session.put, 0x1A00, sub, value)
            for sub, value in ((0, 2), (1, LONGITUDINAL), (8, 0)):
                session.accepted(f"1A00h:{sub:02X}h as it is while valid", 0x1A00, sub, value)
            session.put(0x1800, 1, p.INVALID | 0x1B2)
            session.refused("1A00h:01h while the number is 2", p.UNSUPPORTED_ACCESS, session.put, 0x1A00, 1, LATERAL)
            session.put(0x1A00, 0, 0)
            for value, code in (
                (0x60100010, p.NO_OBJECT),
                (0x00050008, p.NO_OBJECT),
                (0x30000808, p.NO_SUB_INDEX),
                (0x61100120, p.NO_SUB_INDEX),
                (0x61100010, p.NOT_MAPPABLE),
                (0x30100120, p.NOT_MAPPABLE),
                (0x10010008, p.NOT_MAPPABLE),
                (0x31000208, p.NOT_MAPPABLE),
            ):
                session.refused(f"1A00h:01h = {value:08X}h", code, session.put, 0x1A00, 1, value)
            session.reads("a refused entry changes nothing", 0x1A00, 1, LONGITUDINAL)
            session.accepted("an entry is emptied", 0x1A00, 2, 0)
            session.refused("1A00h:00h = 2 with an empty entry", p.NOT_MAPPABLE, session.put, 0x1A00, 0, 2)
            session.refused("1A00h:00h = 9", p.PDO_TOO_LONG, session.put, 0x1A00, 0, 9)
            for sub in (2, 3):
                session.put(0x1A00, sub, LATERAL)
            session.refused("96 bits", p.PDO_TOO_LONG, session.put, 0x1A00, 0, 3)
            session.reads("a refused number changes nothing", 0x1A00, 0, 0)
            session.accepted("64 bits", 0x1A00, 0, 2)
            session.accepted("valid again", 0x1800, 1, 0x1B2)
            for access in (session.upload, session.download):
                data = () if access == session.upload else (b"\x00",)
                session.refused("1800h:04h", p.NO_SUB_INDEX, access, 0x1800, 4, *data)


def mappable(context: Context) -> None:
    """Each of the 20 objects can be mapped and is sent as SDO reads it; no other object can be mapped."""
    with context.session(scene="tilt=12.34,-5.67") as session:
        session.settle()
        session.put(0x1800, 1, p.INVALID | 0x1B2)
        session.put(0x1801, 2, 253)
        session.nmt(p.START)
        for index, sub in MAPPABLE:
            remap(session, 1, [entry(index, sub)])
            session.send(0x2B2, remote=True, dlc=8)
            frame = session.wait_id(0x280)
            value = session.upload(index, sub)
            noisy = index in (*range(0x3010, 0x3014), *range(0x3020, 0x3024))
            got = frame.data if frame else None
            name = f"{index:04X}h:{sub:02X}h in a TPDO"
            if noisy:
                session.report.equal(f"{name}: length", len(value), len(got or b""))
            else:
                session.report.equal(name, value, got)
        session.put(0x1801, 1, p.INVALID | 0x2B2)
        session.put(0x1A01, 0, 0)
        for one in OBJECTS:
            if one.size and (one.index, one.sub) not in MAPPABLE:
                value = one.index << 16 | one.sub << 8 | 8 * one.size
                session.refused(f"{one} in a TPDO", p.NOT_MAPPABLE, session.put, 0x1A01, 1, value)


def triggers(context: Context) -> None:
    """Transmission types 1..240, 252, 253, 254 of all TPDOs."""
    with context.session(scene="tilt=12.34,-5.67") as session:
        session.settle()
        session.nmt(p.START)
        session.quiet("type 254 with an event timer of 0", 0.3)
        for number in range(1, 4):
            remap(session, number, [LONGITUDINAL])
        for number, base in enumerate(BASES):
            expected = p.encode(1234, 4) + (p.encode(-567, 4) if number == 0 else b"")
            for kind, count, wanted in ((1, 5, 5), (3, 9, 3), (240, 240, 1)):
                session.put(0x1800 + number, 2, kind)
                frames = syncs(session, base, count)
                name = f"TPDO {number + 1}, type {kind}: frames for {count} SYNCs"
                session.report.equal(name, [expected] * wanted, [frame.data for frame in frames])
            for kind in (252, 253):
                session.put(0x1800 + number, 2, kind)
                session.report.equal(f"TPDO {number + 1}, type {kind}: none after a SYNC", 0, len(syncs(session, base, 2)))
                session.send(base + NODE, remote=True, dlc=8)
                frame = session.wait_id(base)
                session.report.equal(f"TPDO {number + 1}, type {kind}: remote frame", expected, frame.data if frame else None)
            cob_id = session.get(0x1800 + number, 1)
            session.put(0x1800 + number, 1, cob_id | p.NO_RTR)
            session.send(base + NODE, remote=True, dlc=8)
            session.quiet(f"TPDO {number + 1}: no answer with bit 30")
            session.put(0x1800 + number, 2, 254)
            session.put(0x1800 + number, 5, 50)
            session.report.within(f"TPDO {number + 1}: timer of 50 ms in 1 s", 18, 21, len(session.collect(1.0, base)))
            session.put(0x1800 + number, 5, 0)
            session.collect(0.1)
            session.quiet(f"TPDO {number + 1}: timer off", 0.2)


def change_of_value(context: Context) -> None:
    """Type 255: once on entering operational, then with each change of a mapped bit, within the inhibit time (S51)."""
    turn = [(at, scenes.up(angle, 0.0)) for at, angle in ((0.0, 0.0), (4.0, 0.0), (7.0, 30.0))]
    with context.session(scene=scenes.write(context.folder / "turn.csv", turn)) as session:
        started = session.sensor.started
        session.put(0x1800, 2, 255)
        session.put(0x1800, 3, 1000)
        session.nmt(p.START)
        session.report.equal("at rest: once", 1, len(session.collect(0.8, 0x180)))
        session.collect(max(0.0, started + 4.3 - session.now()))
        frames = session.collect(2.0, 0x180)
        gaps = [later.at - sooner.at for sooner, later in itertools.pairwise(frames)]
        session.report.within("turning: TPDOs in 2 s with 100 ms of inhibit time", 15, 21, len(frames))
        session.report.within("turning: shortest interval in s", 0.08, 0.13, min(gaps, default=0))
        different = all(one.data != other.data for one, other in itertools.pairwise(frames))
        session.report.equal("each TPDO is different", True, different)
        session.put(0x1800, 2, 254)
        session.collect(0.15)
        session.report.equal("type 254: no TPDO by a change", [], session.collect(0.5, 0x180))


def inhibit(context: Context) -> None:
    """The inhibit time limits the timer."""
    with context.session() as session:
        session.put(0x1800, 5, 10)
        session.put(0x1800, 3, 500)
        session.nmt(p.START)
        session.collect(0.1)
        session.report.within("50 ms for a timer of 10 ms: TPDOs in 1 s", 15, 21, len(session.collect(1.0, 0x180)))


GROUPS = (example, configuration, steps, mappable, triggers, change_of_value, inhibit)
