"""Saving, restoring, factory reset and device reset (sections 7.7.1, 7.7.2, 10.1 to 10.3, J11, J13)."""

from . import protocol as p
from .runner import Context
from .session import Session

# One changed value per setting that is saved by 1010h (1029h is not: column "Save" of section 7.6). The node-ID, the bit rate and
# 1F80h have other checks; zero point and teach-in are stored when they are written (J11).
CHANGED = {
    (0x1005, 0): 0x85,
    (0x100C, 0): 300,
    (0x100D, 0): 3,
    (0x1015, 0): 20,
    (0x1017, 0): 150,
    (0x1800, 2): 3,
    (0x1800, 3): 7,
    (0x1800, 5): 77,
    (0x1801, 2): 254,
    (0x1801, 3): 9,
    (0x1801, 5): 88,
    (0x2040, 0): 2,
    (0x2041, 0): 0,
    (0x2043, 0): 4,
    (0x2044, 0): 3,
    (0x2045, 0): 0,
    (0x6000, 0): 100,
}
COMMUNICATION = {key: value for key, value in CHANGED.items() if key[0] < 0x2000}
MANUFACTURER = {key: value for key, value in CHANGED.items() if 0x2000 <= key[0] < 0x6000}
DEFAULTS = {key: p.BY_KEY[key].default for key in CHANGED}


def change(session: Session) -> None:
    """Changes every setting."""
    for (index, sub), value in CHANGED.items():
        session.put(index, sub, value)


def values(session: Session, keys: dict) -> dict:
    """The values of the settings."""
    return {key: session.get(*key) for key in keys}


def check(session: Session, name: str, expected: dict) -> None:
    """Compares settings."""
    got = values(session, expected)
    differ = [f"{p.BY_KEY[key]} = {got[key]}, not {value}" for key, value in expected.items() if got[key] != value]
    session.report.verdict(not differ, name, f"{len(expected)} values", "; ".join(differ) or "all equal")


def signatures(context: Context) -> None:
    """1010h and 1011h accept only their own signature."""
    with context.session(store=context.store()) as session:
        change(session)
        wrong = {0x1010: (b"load", b"evas", b"SAVE", b"wron", b"\x00\x00\x00\x00"), 0x1011: (b"save", b"daol", b"LOAD", b"wron")}
        for index, signatures_ in wrong.items():
            for signature in signatures_:
                codes = {p.CANNOT_STORE, p.INVALID_VALUE} if not any(signature) else p.CANNOT_STORE
                session.refused(f"{index:04X}h:01h = {signature!r}", codes, session.download, index, 1, signature)
            session.refused(f"{index:04X}h:01h with 3 bytes", p.SHORT, session.download, index, 1, b"sav")
            session.refused(f"{index:04X}h:02h", p.NO_SUB_INDEX, session.download, index, 2, b"wron")
            session.refused(f"{index:04X}h:00h", p.READ_ONLY, session.put, index, 0, 1)
            low = session.get(index, 1)
            session.report.verdict(low in (0, 1), f"{index:04X}h:01h reads", "0 (manual) or 1 (CiA 301: on command)", low)
        check(session, "refused signatures change nothing", CHANGED)
        session.power_cycle()
        check(session, "refused signatures save nothing: factory values after power-up", DEFAULTS)


def saved(context: Context) -> None:
    """Values saved with 1010h survive a power cycle and both resets."""
    with context.session(store=context.store()) as session:
        change(session)
        session.put(0x1029, 1, 2)
        session.report.equal("save is accepted", 0, session.abort_code(session.download, 0x1010, 1, p.SAVE))
        check(session, "save changes nothing", CHANGED)
        session.power_cycle()
        check(session, "power cycle", CHANGED)
        session.reads("1029h is not saved", 0x1029, 1, 0)
        for (index, sub), value in DEFAULTS.items():
            session.put(index, sub, value)
        session.reset(p.RESET_COMMUNICATION)
        check(session, "reset communication: the communication profile as saved", COMMUNICATION)
        session.reset(p.RESET_NODE)
        check(session, "reset node: all values as saved", CHANGED)
        for (index, sub), value in DEFAULTS.items():
            session.put(index, sub, value)
        session.power_cycle()
        check(session, "changed without a save: as saved", CHANGED)
        for signature in (p.SAVE, p.SAVE):
            session.download(0x1010, 1, signature)
        session.power_cycle()
        check(session, "saved twice", CHANGED)


def restored(context: Context) -> None:
    """1011h: no change before the reset, then the factory values."""
    with context.session(store=context.store()) as session:
        change(session)
        session.download(0x1010, 1, p.SAVE)
        session.power_cycle()
        session.report.equal("load is accepted", 0, session.abort_code(session.download, 0x1011, 1, p.LOAD))
        check(session, "nothing is changed until the reset", CHANGED)
        session.reset(p.RESET_COMMUNICATION)
        check(session, "reset communication: the communication profile", {key: DEFAULTS[key] for key in COMMUNICATION})
        session.reset(p.RESET_NODE)
        check(session, "reset node: the communication profile", {key: DEFAULTS[key] for key in COMMUNICATION})
        session.power_cycle()
        check(session, "the same after a power cycle", {key: DEFAULTS[key] for key in COMMUNICATION})
    with context.session(store=context.store("other")) as session:
        change(session)
        session.download(0x1010, 1, p.SAVE)
        session.download(0x1011, 1, p.LOAD)
        session.power_cycle()
        check(session, "load, then a power cycle", {key: DEFAULTS[key] for key in COMMUNICATION})


def factory_reset(context: Context) -> None:
    """207Fh: the objects of the manufacturer at once, node-ID and bit rate with the next reset (J13)."""
    with context.session(store=context.store()) as session:
        change(session)
        session.put(0x2000, 0, 33)
        session.download(0x1010, 1, p.SAVE)
        session.node = 33
        session.power_cycle()
        session.reads("node-ID 33 is in force", 0x1200, 1, 0x600 + 33)
        session.report.equal("factory reset is accepted", 0, session.abort_code(session.put, 0x207F, 0, 1))
        session.reads("207Fh reads 1 after success", 0x207F, 0, 1)
        check(session, "the objects of the manufacturer", {key: DEFAULTS[key] for key in MANUFACTURER})
        session.node = p.FACTORY_NODE_ID
        session.power_cycle()
        session.reads("after power-up: node-ID 10", 0x2000, 0, 10)
        check(session, "after power-up: the objects of the manufacturer", {key: DEFAULTS[key] for key in MANUFACTURER})


def device_reset(context: Context) -> None:
    """2002h = 1 resets the sensor, except its unsaved node-ID (`unsaved_node_id`); 0 does not."""
    with context.session() as session:
        session.put(0x2043, 0, 4)
        session.put(0x1800, 2, 7)
        session.accepted("2002h = 0", 0x2002, 0, 0)
        session.check_state("2002h = 0: no reset", p.PRE_OPERATIONAL)
        session.nmt(p.START)
        session.send(p.SDO_REQUEST + session.node, bytes([0x2F, 0x02, 0x20, 0x00, 1, 0, 0, 0]))
        session.report.equal("2002h = 1: boot-up", True, session.wait_boot_up())
        session.check_state("2002h = 1: pre-operational", p.PRE_OPERATIONAL)
        session.reads("2002h reads 0 again", 0x2002, 0, 0)
        session.reads("2043h as saved", 0x2043, 0, 2)
        session.reads("1800h:02h as saved", 0x1800, 2, 1)


# Two complete sets of settings, which must not be mixed after an interrupted save.
FIRST = {(0x100C, 0): 111, (0x1800, 5): 111, (0x2043, 0): 1, (0x6000, 0): 1}
SECOND = {(0x100C, 0): 222, (0x1800, 5): 222, (0x2043, 0): 3, (0x6000, 0): 1000}
FACTORY = {key: p.BY_KEY[key].default for key in FIRST}

# The emergency code of the nonvolatile memory.
HARDWARE_FAULT = 0x1000


def save_set(session: Session, settings: dict) -> None:
    """Writes and saves settings."""
    for (index, sub), value in settings.items():
        session.put(index, sub, value)
    session.download(0x1010, 1, p.SAVE)


def power_fails(context: Context) -> None:
    """After a power cut during a save, the old or the new values are loaded, never a mixture."""
    with context.session(store=context.store()) as session:
        save_set(session, FIRST)
        for number in range(12):
            for (index, sub), value in SECOND.items():
                session.put(index, sub, value)
            session.send(p.SDO_REQUEST + session.node, bytes([0x23, 0x10, 0x10, 0x01]) + p.SAVE)
            session.sleep(0.0008 * number)
            session.power_cycle()
            got = values(session, FIRST)
            session.report.verdict(got in (FIRST, SECOND), f"cut {number}", "old or new values", got)
            save_set(session, FIRST)


def interrupted(context: Context) -> None:
    """After a power cut in a save the old values are in force, and the hardware fault is active until the next good save (J29)."""
    path = context.store()
    with context.session(store=path) as session:
        save_set(session, FIRST)
        old = path.read_bytes()
        save_set(session, SECOND)
        session.power_down()
        new = path.read_bytes()
        changed = [at for at in range(len(new)) if new[at] != old[at]]
        for number in range(1, 6):
            # The memory with a part of the bytes of the second save.
            end = changed[number * len(changed) // 6]
            path.write_bytes(new[:end] + old[end:])
            for start in ("first", "second"):
                session.power_up()
                name = f"cut at byte {end}, {start} power-up"
                session.report.equal(f"{name}: old values", FIRST, values(session, FIRST))
                session.report.equal(f"{name}: error register", 1, session.get(0x1001) & 1)
                codes = [p.decode(frame.data[:2]) for frame in session.others if frame.id == p.EMCY + session.node]
                session.report.verdict(HARDWARE_FAULT in codes, f"{name}: hardware fault", f"{HARDWARE_FAULT:X}h", codes)
                session.power_down()
            session.power_up()
            session.put(0x2042, 0, 2)
            session.reads(f"cut at byte {end}: the fault is active until a save", 0x1001, 0, 1)
            session.download(0x1010, 1, p.SAVE)
            session.reads(f"cut at byte {end}: no fault after a save", 0x1001, 0, 0)
            session.power_cycle()
            session.reads(f"cut at byte {end}: no fault after a power cycle", 0x1001, 0, 0)
            session.power_down()
        session.power_up()


def damaged(context: Context) -> None:
    """With one damaged byte in the memory, the newest, the older or the factory values are loaded, never a mixture."""
    path = context.store()
    with context.session(store=path) as session:
        save_set(session, FIRST)
        save_set(session, SECOND)
        session.power_down()
        original = path.read_bytes()
        used = [at for at, byte in enumerate(original) if byte != 0xFF]
        for number in range(16):
            at = used[number * (len(used) - 1) // 15]
            broken = bytearray(original)
            broken[at] ^= 0x10
            path.write_bytes(broken)
            session.power_up()
            got = values(session, FIRST)
            session.report.verdict(got in (FIRST, SECOND, FACTORY), f"byte {at} damaged", "one complete set", got)
            session.power_down()
        path.write_bytes(original)
        session.power_up()
        session.report.equal("without damage again", SECOND, values(session, FIRST))


def save_in_operation(context: Context) -> None:
    """Saves do not delay the heartbeat."""
    with context.session(store=context.store()) as session:
        session.put(0x1017, 0, 20)
        session.collect(0.1)
        for _ in range(10):
            session.download(0x1010, 1, p.SAVE)
        beats = [frame.at for frame in session.others + session.collect(0.2) if frame.id == p.ERROR_CONTROL + session.node]
        gaps = [later - sooner for sooner, later in zip(beats, beats[1:], strict=False)]
        session.report.within("longest interval of heartbeats of 20 ms during 10 saves, s", 0.01, 0.045, max(gaps, default=0))


def unchanged(context: Context) -> None:
    """Teach and zero point that change nothing are not written to the memory (J31)."""
    path = context.store()
    with context.session(store=path) as session:
        for index in (0x2042, 0x2046):
            session.put(index, 0, 1)
            session.put(index, 0, 2)
        before = path.read_bytes()
        for index in (0x2042, 0x2046):
            for value in (2, 0, 2):
                session.put(index, 0, value)
        session.report.equal("2042h and 2046h = 2 while they are 2: the memory", True, path.read_bytes() == before)
        session.put(0x2042, 0, 1)
        session.report.equal("2042h = 1: the memory changes", True, path.read_bytes() != before)


def no_memory(context: Context) -> None:
    """With an empty memory or one with invalid bytes, the sensor has its factory values."""
    for name, data in (("empty", b""), ("invalid", bytes(range(256)) * 16)):
        path = context.store(name)
        path.write_bytes(data)
        with context.session(store=path) as session:
            check(session, f"{name} memory: factory values", DEFAULTS)


GROUPS = (
    signatures, saved, restored, factory_reset, device_reset, power_fails, interrupted, damaged, save_in_operation, unchanged,
    no_memory,
)  # fmt: skip
