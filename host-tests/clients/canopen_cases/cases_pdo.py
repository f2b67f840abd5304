"""The two transmit PDOs and SYNC (sections 7.4, 7.5 and 7.6, J3; CiA 301, 7.2.2 and 7.2.5)."""

from gemac.harness import EXTENDED, Frame

from . import protocol as p
from . import scenes
from .runner import Context
from .session import Session

PDOS = ((p.TPDO0, 0x1800, 2), (p.TPDO1, 0x1801, 4))
OTHER = {p.TPDO0: 0x1801, p.TPDO1: 0x1800}


def silence(session: Session, index: int) -> None:
    """Sets a PDO so that it is only sent on a remote frame."""
    session.put(index, 2, 253)


def syncs(session: Session, base: int, count: int, identifier: int = p.SYNC, data: bytes = b"") -> list[Frame]:
    """Sends SYNC and returns the PDOs that follow."""
    for _ in range(count):
        session.send(identifier, data)
    return [frame for frame in session.tester.collect_until_quiet(0.15, 3.0) if frame.id == base + session.node]


def content(context: Context) -> None:
    """The content of the PDOs, and the fixed mapping."""
    with context.session(scene="tilt=-23.70,12.34") as session:
        session.settle()
        session.report.equal("6010h and 6020h", (-2370, 1234), session.slopes())
        session.report.equal("6110h and 6120h", (-2370, 1234), session.slopes(wide=True))
        session.nmt(p.START)
        session.send(p.SYNC)
        frames = {frame.id: frame.data for frame in session.collect(0.2)}
        for base, _, size in PDOS:
            wanted = p.encode(-2370, size) + p.encode(1234, size)
            session.report.equal(f"{base + session.node:03X}h at SYNC", wanted, frames.get(base + session.node))
        session.report.equal("no other frame follows a SYNC", sorted([0x18A, 0x28A]), sorted(frames))
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        for index, first, second in ((0x1A00, 0x60100010, 0x60200010), (0x1A01, 0x61100020, 0x61200020)):
            for sub, value in ((0, 1), (0, 3), (1, second), (1, 0), (2, first)):
                name = f"{index:04X}h:{sub:02X}h = {value:X}h: the mapping is fixed"
                session.refused(name, p.READ_ONLY, session.put, index, sub, value)
            for sub, value in ((0, 2), (1, first), (2, second)):
                session.accepted(f"{index:04X}h:{sub:02X}h as it is", index, sub, value)
        for index in (0x1800, 0x1801):
            own = session.get(index, 1)
            for name, value in (("another", 0x1F0), ("disabled another", own ^ 1 | p.INVALID), ("29 bit", own | 1 << 29)):
                session.refused(f"{index:04X}h:01h {name}", p.INVALID_VALUE, session.put, index, 1, value)
            session.reads(f"{index:04X}h:01h unchanged", index, 1, own)


def switched_off(context: Context) -> None:
    """Bit 31 of the COB-ID and an empty mapping keep a PDO silent, bit 30 only its answers to remote frames (J25, J26)."""
    with context.session() as session:
        for base, index, size in PDOS:
            own = session.get(index, 1)
            silence(session, OTHER[base])
            session.nmt(p.START)
            for name, sub, off, on in (("bit 31", 1, own | p.INVALID, own), ("no object", 0, 0, 2)):
                at = index if sub else index + 0x200
                session.accepted(f"{index:04X}h {name}", at, sub, off)
                session.report.equal(f"{index:04X}h {name}: no PDO at SYNC", 0, len(syncs(session, base, 3)))
                session.send(base + session.node, remote=True, dlc=2 * size)
                session.quiet(f"{index:04X}h {name}: no answer to a remote frame")
                session.accepted(f"{index:04X}h {name} ends", at, sub, on)
                session.report.equal(f"{index:04X}h {name} ends: PDOs at SYNC", 3, len(syncs(session, base, 3)))
            session.accepted(f"{index:04X}h bit 30", index, 1, own | p.NO_RTR)
            session.send(base + session.node, remote=True, dlc=2 * size)
            session.quiet(f"{index:04X}h bit 30: no answer to a remote frame")
            session.report.equal(f"{index:04X}h bit 30: PDOs at SYNC", 3, len(syncs(session, base, 3)))
            session.put(index, 1, own | p.INVALID | p.NO_RTR)
            session.put(index + 0x200, 0, 0)
            session.report.equal("reset communication: boot-up", True, session.reset(p.RESET_COMMUNICATION))
            session.reads(f"{index:04X}h:01h after reset communication", index, 1, own)
            session.reads(f"{index + 0x200:04X}h:00h after reset communication", index + 0x200, 0, 2)


def synchronous(context: Context) -> None:
    """Types 1 to 240: the PDO follows every n-th SYNC."""
    with context.session() as session:
        for base, index, _ in PDOS:
            silence(session, OTHER[base])
            for kind, count, wanted in ((1, 7, 7), (2, 8, 4), (3, 9, 3), (10, 30, 3), (100, 200, 2), (240, 480, 2)):
                session.put(index, 2, kind)
                session.nmt(p.START)
                got = len(syncs(session, base, count))
                session.report.equal(f"{index:04X}h type {kind}: PDOs for {count} SYNCs", wanted, got)
                session.nmt(p.ENTER_PRE_OPERATIONAL)
        session.put(0x1800, 2, 1)
        session.nmt(p.START)
        session.quiet("type 1: the event timer of 10 ms has no effect", 0.2)
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        session.put(0x1800, 2, 3)
        silence(session, 0x1801)
        session.nmt(p.START)
        counts = [len(syncs(session, p.TPDO0, 1)) for _ in range(6)]
        session.report.equal("type 3: PDOs after the third and the sixth SYNC", [0, 0, 1, 0, 0, 1], counts)


def sync_forms(context: Context) -> None:
    """SYNC with a counter, with another identifier, and frames that are not SYNC."""
    with context.session() as session:
        silence(session, 0x1801)
        session.nmt(p.START)
        for counter in (0, 1, 5, 240):
            got = len(syncs(session, p.TPDO0, 1, data=bytes([counter])))
            session.report.equal(f"SYNC with the counter {counter}", 1, got)
        session.send(p.SYNC | EXTENDED)
        session.send(p.SYNC, remote=True, dlc=0)
        session.send(p.SYNC | EXTENDED, remote=True, dlc=0)
        session.quiet("29-bit and remote frames are not SYNC")
        session.put(0x1005, 0, 0x85)
        session.report.equal("1005h = 85h: 80h is no longer SYNC", 0, len(syncs(session, p.TPDO0, 3)))
        session.report.equal("1005h = 85h: 85h is SYNC", 3, len(syncs(session, p.TPDO0, 3, 0x85)))
        session.put(0x1005, 0, 0x80)
        session.report.equal("1005h = 80h again", 2, len(syncs(session, p.TPDO0, 2)))
        start = session.now()
        session.send(p.SYNC)
        answer = session.wait_id(p.TPDO0)
        session.report.within("the PDO follows the SYNC within, s", 0, 0.05, answer.at - start if answer else 1)


def acyclic(context: Context) -> None:
    """Type 0: a PDO after a SYNC if a value has changed."""
    for name, scene, low, high in (
        ("a sensor at rest", "tilt=5,5", 0, 1),
        ("a sensor that turns", scenes.write(context.folder / "turn.csv", turn()), 9, 10),
    ):
        with context.session(scene=scene) as session:
            session.sleep(1.5)
            silence(session, 0x1801)
            session.put(0x1800, 2, 0)
            session.put(0x1800, 5, 0)
            session.nmt(p.START)
            session.report.equal(f"type 0, {name}: no PDO without SYNC", [], session.collect(0.2, p.TPDO0))
            got = sum(len(syncs(session, p.TPDO0, 1)) for _ in range(10))
            session.report.within(f"type 0, {name}: PDOs for 10 SYNCs", low, high, got)


def turn() -> list[tuple[float, tuple[float, float, float]]]:
    """A steady turn from -40 to 40 deg within 20 s."""
    return [(0.5 * step, scenes.up(-40.0 + 2.0 * step, 0.0)) for step in range(41)]


def remote(context: Context) -> None:
    """Remote frames: answered in every type, with the current values or those of the last SYNC."""
    with context.session() as session:
        session.nmt(p.START)
        for base, index, size in PDOS:
            session.put(index, 5, 0)
            for kind in (0, 1, 240, 252, 253, 254, 255):
                session.put(index, 2, kind)
                session.send(p.SYNC)
                session.collect(0.1)
                session.send(base + session.node, remote=True, dlc=2 * size)
                wanted = [str(Frame(base + session.node, bytes(2 * size)))]
                got = [str(frame) for frame in session.collect(0.12)]
                session.report.equal(f"{index:04X}h type {kind}: one answer to a remote frame", wanted, got)
            for kind in (252, 253):
                session.put(index, 2, kind)
                session.report.equal(f"{index:04X}h type {kind}: no PDO after SYNC", 0, len(syncs(session, base, 3)))
            for dlc in range(9):
                session.send(base + session.node, remote=True, dlc=dlc)
            session.report.equal(f"{index:04X}h: any length of the remote frame", 9, len(session.collect(0.2, base)))
            session.send(base + session.node | EXTENDED, remote=True, dlc=8)
            session.send(base + session.node + 1, remote=True, dlc=8)
            session.send(base + session.node, bytes(8))
            session.quiet(f"{index:04X}h: 29 bit, another node, a data frame")
    for way in (p.ENTER_PRE_OPERATIONAL, p.STOP):
        with context.session() as session:
            session.nmt(way)
            for base, *_ in PDOS:
                session.send(base + session.node, remote=True, dlc=8)
            session.quiet(f"NMT command {way}: no answer in this state")


def sampling(context: Context) -> None:
    """Type 252 answers with the values of the last SYNC, type 253 with the current values."""
    scene = scenes.steps(context.folder / "step.csv", [(0.0, 10.0), (4.0, 20.0)])
    with context.session(scene=scene) as session:
        started = session.sensor.started
        session.put(0x2043, 0, 0)
        session.put(0x1800, 2, 252)
        session.put(0x1801, 2, 253)
        session.nmt(p.START)
        session.sleep(max(0.0, started + 3.0 - session.now()))
        session.send(p.SYNC)
        session.sleep(max(0.0, started + 5.5 - session.now()))
        session.report.equal("type 252: value of the SYNC", 1000, longitudinal(session, p.TPDO0, 2))
        session.report.equal("type 253: current value", 2000, longitudinal(session, p.TPDO1, 4))
        session.send(p.SYNC)
        session.collect(0.1)
        session.report.equal("type 252: after the next SYNC", 2000, longitudinal(session, p.TPDO0, 2))


def longitudinal(session: Session, base: int, size: int) -> int | None:
    """Requests a PDO and returns its first slope."""
    session.send(base + session.node, remote=True, dlc=2 * size)
    frame = session.wait_id(base)
    return p.decode(frame.data[:size], True) if frame else None


def rates(session: Session, name: str, base: int, seconds: float, period: float) -> None:
    """Checks the mean and the shortest interval of the PDOs."""
    session.collect(0.05)
    frames = session.collect(seconds, base)
    if len(frames) < 3:
        session.report.verdict(False, name, f"a PDO every {period} s", f"{len(frames)} PDOs in {seconds} s")
        return
    mean = (frames[-1].at - frames[0].at) / (len(frames) - 1)
    session.report.within(f"{name}: mean period in s", 0.98 * period - 0.0005, 1.02 * period + 0.0005, mean)


def event_timer(context: Context) -> None:
    """Types 254 and 255 with the event timer (section 7.5)."""
    with context.session() as session:
        for base, index, _ in PDOS:
            silence(session, OTHER[base])
            for kind in (254, 255):
                for milliseconds in (10, 50):
                    session.put(index, 5, milliseconds)
                    session.put(index, 2, kind)
                    session.nmt(p.START)
                    rates(session, f"{index:04X}h type {kind}, {milliseconds} ms", base, 0.8, milliseconds / 1000)
                    session.nmt(p.ENTER_PRE_OPERATIONAL)
                    session.collect(0.03)
                    session.quiet(f"{index:04X}h type {kind}: none in pre-operational", 0.15)
            session.put(index, 5, 0)
            session.nmt(p.START)
            session.collect(0.1)
            session.report.equal(f"{index:04X}h: 0 ms switches it off", [], session.collect(0.3, base))
            session.report.equal(f"{index:04X}h type 255: no PDO after SYNC", 0, len(syncs(session, base, 5)))
            session.put(index, 5, 20)
            rates(session, f"{index:04X}h: 20 ms, set in operational", base, 0.6, 0.020)
            session.put(index, 5, 40)
            rates(session, f"{index:04X}h: changed to 40 ms", base, 0.8, 0.040)
            session.nmt(p.ENTER_PRE_OPERATIONAL)


def busy(context: Context) -> None:
    """A PDO every millisecond on a bus at 1 Mbit/s, and SDO transfers at the same time."""
    store = context.store()
    with context.session(store=store) as session:
        session.put(0x2001, 0, 1000)
        session.put(0x1800, 5, 1)
        session.put(0x1800, 2, 254)
        session.put(0x1801, 2, 253)
        session.download(0x1010, 1, p.SAVE)
        session.power_cycle()
        session.nmt(p.START)
        rates(session, "1 ms", p.TPDO0, 1.0, 0.001)
        right = sum(session.get(0x1000) == 0x4019A for _ in range(100))
        session.report.equal("100 SDO transfers at the same time", 100, right)
        session.report.equal("a segmented transfer", b"JN2101", session.upload(0x1008))


def inhibit(context: Context) -> None:
    """The inhibit time limits the rate of PDOs, in units of 100 us (J3)."""
    with context.session() as session:
        for base, index, _ in PDOS:
            silence(session, OTHER[base])
            session.put(index, 5, 10)
            session.put(index, 3, 500)
            session.put(index, 2, 254)
            session.nmt(p.START)
            session.collect(0.1)
            frames = session.collect(1.0, base)
            gaps = [later.at - sooner.at for sooner, later in zip(frames, frames[1:], strict=False)]
            session.report.within(f"{index:04X}h: 50 ms for a timer of 10 ms: PDOs in 1 s", 15, 21, len(frames))
            session.report.within(f"{index:04X}h: shortest interval in s", 0.040, 0.070, min(gaps, default=0))
            session.nmt(p.ENTER_PRE_OPERATIONAL)
            session.put(index, 3, 0)
            session.put(index, 2, 253)


GROUPS = (content, switched_off, synchronous, sync_forms, acyclic, remote, sampling, event_timer, inhibit, busy)
