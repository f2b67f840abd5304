"""IMS360: emergency messages, 1001h and 1003h (section 6.2, S36, S53, S66..S71), heartbeat.

The virtual sensor cannot cause a defective axis (FF01h, FF02h), bus-off (FF14h) and an overrun (8110h):
core/tests/wire/canopen_ims360_faults.rs has the checks of their messages.
"""

from pathlib import Path

from gemac import record
from gemac.harness import Frame

from . import protocol as p
from . import scenes
from .ims360_objects import NODE
from .runner import Context
from .session import Session

SUPPLY, LONGITUDINAL, LATERAL, MEMORY = 0x3100, 0x5010, 0x5020, 0xFF00


def supply_scene(path: Path, volts: list[tuple[float, float]]) -> Path:
    """A level sensor whose supply has each voltage from its time on."""
    lines = ["t_s,ax_g,ay_g,az_g,supply_v"]
    for place, (at, value) in enumerate(volts):
        if place:
            lines.append(f"{at},0,0,1,{volts[place - 1][1]}")
            at += 0.001
        lines.append(f"{at},0,0,1,{value}")
    path.write_text("\n".join(lines) + "\n")
    return path


def check(session: Session, name: str, code: int, register: int, frame: Frame | None) -> None:
    """Checks a message: code, register, and five bytes 0."""
    expected = p.encode(code, 2) + bytes([register]) + bytes(5)
    session.report.equal(name, expected.hex(), frame.data.hex() if frame else None)


def supply(context: Context) -> None:
    """Supply voltage below 8.0 V and above 36.0 V: 3100h with bit 0 alone (S66, S69)."""
    volts = [(0.0, 24.0), (2.0, 7.5), (3.5, 8.2), (5.0, 24.0), (6.5, 37.0), (8.0, 30.0)]
    with context.session(scene=supply_scene(context.folder / "supply.csv", volts)) as session:
        session.report.within("2020h:01h in mV", 23_500, 24_500, session.get(0x2020, 1))
        check(session, "7.5 V", SUPPLY, 0x01, session.wait_id(p.EMCY, 4.0))
        session.reads("7.5 V: 1001h", 0x1001, 0, 0x01)
        check(session, "24 V", 0, 0x00, session.wait_id(p.EMCY, 5.0))
        check(session, "37 V", SUPPLY, 0x01, session.wait_id(p.EMCY, 5.0))
        check(session, "30 V", 0, 0x00, session.wait_id(p.EMCY, 5.0))
        session.reads("1003h", 0x1003, 0, 2)
        session.reads("1003h:01h", 0x1003, 1, SUPPLY)
        for value in (1, 2, 255):
            session.refused(f"1003h:00h = {value}", p.INVALID_VALUE, session.put, 0x1003, 0, value)
        session.put(0x1003, 0, 0)
        session.reads("1003h:00h = 0 clears", 0x1003, 0, 0)
        session.refused("1003h:01h after that", p.NO_DATA, session.upload, 0x1003, 1)


def out_of_range(context: Context) -> None:
    """The angle with its offset beyond +-90 deg: 5010h, 5020h with bits 0 and 7 (S36)."""
    with context.session(scene="tilt=10,0") as session:
        session.settle()
        session.put(0x3210, 0, 8500)
        check(session, "longitudinal 95 deg", LONGITUDINAL, 0x81, session.wait_id(p.EMCY, 2.0))
        session.reads("longitudinal: the angle is sent", 0x6110, 0, 9500)
        session.put(0x3220, 0, -9100)
        check(session, "lateral too", LATERAL, 0x81, session.wait_id(p.EMCY, 2.0))
        session.put(0x3210, 0, 0)
        check(session, "longitudinal within the range", 0, 0x81, session.wait_id(p.EMCY, 2.0))
        session.nmt(p.RESET_COMMUNICATION)
        session.wait_boot_up()
        check(session, "announced again behind the boot-up", LATERAL, 0x81, session.wait_id(p.EMCY, 2.0))
        session.put(0x1014, 0, p.INVALID | 0x80 + NODE)
        session.put(0x3220, 0, 0)
        session.quiet("1014h bit 31: no message")
        session.put(0x1014, 0, 0x80 + NODE)
        session.nmt(p.STOP)
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        session.quiet("without an active error: no message")
        session.put(0x3220, 0, 9100)
        check(session, "again", LATERAL, 0x81, session.wait_id(p.EMCY, 2.0))
        session.nmt(p.STOP)
        session.quiet("stopped: no message")
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        check(session, "announced on leaving stopped", LATERAL, 0x81, session.wait_id(p.EMCY, 2.0))


def clipping(context: Context) -> None:
    """The accelerometer at the limit of its range: 5010h and 5020h, and the angle is still sent (S36)."""
    level, shock = (0.0, 0.0, 1.0), (0.0, 0.0, 3.0)
    rows = [(0.0, level), (2.0, level), (2.001, shock), (3.5, shock), (3.501, level)]
    with context.session(scene=scenes.write(context.folder / "shock.csv", rows)) as session:
        check(session, "clipping: longitudinal", LONGITUDINAL, 0x81, session.wait_id(p.EMCY, 4.0))
        check(session, "clipping: lateral", LATERAL, 0x81, session.wait_id(p.EMCY, 1.0))
        session.reads("clipping: the angle is sent", 0x6110, 0, 0)
        check(session, "afterwards: one", 0, 0x81, session.wait_id(p.EMCY, 4.0))
        check(session, "afterwards: none", 0, 0x00, session.wait_id(p.EMCY, 1.0))
        session.reads("afterwards: 1001h", 0x1001, 0, 0)


def memory(context: Context) -> None:
    """Damaged parameter memory: the older values or factory values, and FF00h until the next good save (S70, J29)."""

    def newest(store: Path) -> None:
        record.flip(store, record.find(store)[-1].offset + record.HEADER + 20)

    def everything(store: Path) -> None:
        store.write_bytes(bytes(store.stat().st_size))

    for damage, kept in ((newest, 111), (everything, 0)):
        name, store = damage.__name__, context.store(damage.__name__)
        with context.session(store=store) as session:
            for value in (111, 222):
                session.put(0x3210, 0, value)
                session.download(0x1010, 1, p.SAVE)
            session.power_down()
            damage(store)
            session.power_up(boot=False)
            session.report.equal(f"{name}: boot-up", True, session.wait_boot_up())
            check(session, f"{name}: behind the boot-up", MEMORY, 0x81, session.wait_id(p.EMCY, 2.0))
            session.reads(f"{name}: 1001h", 0x1001, 0, 0x81)
            codes = [session.get(0x1003, sub) for sub in range(1, session.get(0x1003) + 1)]
            session.report.verdict(MEMORY in codes, f"{name}: 1003h", f"has {MEMORY:04X}h", codes)
            session.reads(f"{name}: 3210h", 0x3210, 0, kept)
            session.nmt(p.RESET_COMMUNICATION)
            session.report.equal(f"{name}: boot-up after the reset", True, session.wait_boot_up())
            check(session, f"{name}: announced again", MEMORY, 0x81, session.wait_id(p.EMCY, 2.0))
            session.download(0x1010, 1, p.SAVE)
            check(session, f"{name}: saved", 0, 0x00, session.wait_id(p.EMCY, 2.0))
            session.power_cycle()
            session.quiet(f"{name}: saved, after a power cycle")
            session.reads(f"{name}: saved: 1001h", 0x1001, 0, 0)


def history(context: Context) -> None:
    """1003h: eight entries, the newest first."""
    with context.session(scene="tilt=10,0") as session:
        session.settle()
        for number in range(10):
            index = 0x3210 + 0x10 * (number % 2)
            session.put(index, 0, 9500)
            session.wait_id(p.EMCY, 2.0)
            session.put(index, 0, 0)
            session.wait_id(p.EMCY, 2.0)
        entries = [session.get(0x1003, sub) for sub in range(1, session.get(0x1003) + 1)]
        session.report.equal("entries", [LATERAL, LONGITUDINAL] * 4, entries)


def identifier(context: Context) -> None:
    """1014h: another identifier of 11 bits, and one of 29 bits (S46)."""
    with context.session(scene="tilt=10,0") as session:
        session.settle()
        for cob_id in (0x0C5, 1 << 29 | 0x12345):
            session.put(0x1014, 0, p.INVALID | cob_id)
            session.put(0x1014, 0, cob_id)
            session.put(0x3210, 0, 9000)
            wanted = cob_id if cob_id < 0x800 else p.encode(cob_id & 0x1FFFFFFF, 4)
            found = session.wait(lambda frame: frame.id & 0x1FFFFFFF in (0x0C5, 0x12345), 2.0)
            got = None if found is None else found.id if cob_id < 0x800 else p.encode(found.id & 0x1FFFFFFF, 4)
            session.report.equal(f"EMCY with 1014h = {cob_id:X}h", wanted, got)
            session.put(0x3210, 0, 0)
            session.collect(0.2)


def heartbeat(context: Context) -> None:
    """1017h: the state cyclically; never a remote frame."""
    with context.session() as session:
        session.put(0x1017, 0, 50)
        for command, state in ((p.START, 5), (p.STOP, 4), (p.ENTER_PRE_OPERATIONAL, 127)):
            session.nmt(command)
            session.collect(0.1)
            frames = session.collect(1.0, p.ERROR_CONTROL)
            session.report.within(f"state {state}: heartbeats in 1 s", 18, 22, len(frames))
            session.report.equal(f"state {state}: contents", {bytes([state])}, {frame.data for frame in frames})
        session.put(0x1017, 0, 0)
        session.collect(0.1)
        session.quiet("1017h = 0: no heartbeat", 0.5)


GROUPS = (supply, out_of_range, clipping, memory, history, identifier, heartbeat)
