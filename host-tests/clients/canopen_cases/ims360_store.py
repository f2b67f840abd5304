"""IMS360: store and restore, the variants, node-ID and bit rate by SDO (S2, S12, S43, S44, S49, S53..S55, S61)."""

from . import protocol as p
from . import scenes
from .ims360_objects import LATERAL, LONGITUDINAL, NODE, TABLE
from .ims360_pdo import remap
from .runner import Context
from .session import Session

# Changed values by their group; node-ID and bit rate have their own checks.
COMMUNICATION = {
    (0x1005, 0): 0x85,
    (0x1014, 0): 0xB9,
    (0x1017, 0): 60000,
    (0x1800, 2): 3,
    (0x1800, 3): 7,
    (0x1800, 5): 77,
    (0x1801, 1): 0x1C0,
    (0x1A01, 0): 1,
    (0x1A01, 1): 0x65110008,
    (0x1803, 5): 88,
}
MANUFACTURER = {
    (0x3100, 2): 0,
    (0x3110, 1): 1,
    (0x3110, 2): 1,
    (0x3111, 0): 12000,
    (0x3112, 1): 5,
    (0x3112, 2): -4,
    (0x3210, 0): -1000,
    (0x3220, 0): 77,
}
ALL = COMMUNICATION | MANUFACTURER


def defaults(keys: dict) -> dict:
    """The factory values of some objects."""
    return {key: TABLE[key].default + NODE * TABLE[key].relative for key in keys}


def change(session: Session) -> None:
    """Changes every setting."""
    session.put(0x1014, 0, p.INVALID | 0xB9)
    remap(session, 1, [0x65110008], 0x1C0)
    for key, value in ALL.items():
        if key[0] not in (0x1801, 0x1A01):
            session.put(*key, value)


def check(session: Session, name: str, expected: dict) -> None:
    """Compares settings."""
    differ = {f"{TABLE[key]}": f"{got}, not {value}" for key, value in expected.items() if (got := session.get(*key)) != value}
    session.report.equal(name, {}, differ)


def save(session: Session, sub: int = 1) -> None:
    """1010h."""
    session.download(0x1010, sub, p.SAVE)


def load(session: Session, sub: int) -> None:
    """1011h."""
    session.download(0x1011, sub, p.LOAD)


def stored(context: Context) -> None:
    """The groups of 1010h (S54)."""
    for sub, kept in ((1, ALL), (2, COMMUNICATION), (3, {}), (4, MANUFACTURER)):
        with context.session(store=context.store(f"group{sub}")) as session:
            change(session)
            session.report.equal(f"1010h:{sub:02X}h is accepted", 0, session.abort_code(save, session, sub))
            check(session, f"1010h:{sub:02X}h changes nothing", ALL)
            session.power_cycle()
            check(session, f"1010h:{sub:02X}h: after power-up", defaults(ALL) | kept)
            if sub == 1:
                session.reset(p.RESET_NODE)
                check(session, "after reset node", ALL)
    with context.session(store=context.store("wrong")) as session:
        for index in (0x1010, 0x1011):
            for sub in range(1, 5):
                right, other = (p.SAVE, p.LOAD) if index == 0x1010 else (p.LOAD, p.SAVE)
                for signature in (b"SAVE", b"LOAD", bytes(4), right[::-1], other):
                    session.refused(f"{TABLE[index, sub]} = {signature}", p.CANNOT_STORE, session.download, index, sub, signature)
        session.nmt(p.START)
        session.report.equal("1010h:01h in operational", 0, session.abort_code(save, session))


def restored(context: Context) -> None:
    """The groups of 1011h: nothing changes until a reset, and only a save keeps it (S55)."""
    groups = ((1, ALL), (2, COMMUNICATION), (3, {}), (4, MANUFACTURER), (5, ALL))
    for sub, gone in groups:
        with context.session(store=context.store(f"group{sub}")) as session:
            change(session)
            save(session)
            session.report.equal(f"1011h:{sub:02X}h is accepted", 0, session.abort_code(load, session, sub))
            check(session, f"1011h:{sub:02X}h changes nothing", ALL)
            session.power_cycle()
            check(session, f"1011h:{sub:02X}h: the first start", ALL | defaults(gone))
            session.power_cycle()
            check(session, f"1011h:{sub:02X}h: the second start, without a save", ALL)
            load(session, sub)
            session.reset(p.RESET_NODE)
            check(session, f"1011h:{sub:02X}h: after reset node", ALL | defaults(gone))
            save(session)
            session.power_cycle()
            check(session, f"1011h:{sub:02X}h: saved", ALL | defaults(gone))


def restored_addresses(context: Context) -> None:
    """Node-ID and bit rate stay at 1011h:01h and :02h, and go at :04h and :05h."""
    for sub, stays in ((1, True), (2, True), (4, False), (5, False)):
        with context.session(store=context.store(f"address{sub}")) as session:
            session.put(0x2002, 0, 60)
            session.put(0x2001, 0, 500_000)
            save(session)
            session.node = 60
            session.power_cycle()
            load(session, sub)
            session.node = 60 if stays else NODE
            session.power_cycle()
            expected = (60, 500_000) if stays else (NODE, 125_000)
            session.report.equal(f"1011h:{sub:02X}h: node-ID and bit rate", expected, (session.get(0x2002), session.get(0x2001)))


def addresses(context: Context) -> None:
    """2002h: in force after a reset; COB-IDs follow; 2010h:01h starts with the stored one (S43, S44)."""
    with context.session(store=context.store()) as session:
        session.put(0x1802, 1, p.INVALID | 0x1B2)
        session.put(0x2002, 0, 60)
        session.nmt(p.RESET_COMMUNICATION)
        session.node = 60
        session.report.equal("reset communication: boot-up of node 60", True, session.wait_boot_up())
        for key, value in {(0x1014, 0): 0xBC, (0x1800, 1): 0x1BC, (0x1801, 1): 0x800002BC}.items():
            session.reads(f"{TABLE[key]} follows", *key, value)
        session.put(0x2010, 1, 1)
        session.node = NODE
        session.report.equal("2010h:01h = 1: boot-up of node 50, as stored", True, session.wait_boot_up())
        session.put(0x1802, 1, p.INVALID | 0x1B2)
        session.put(0x2002, 0, 60)
        save(session)
        session.node = 60
        session.power_cycle()
        session.reads("an own COB-ID stays", 0x1802, 1, p.INVALID | 0x1B2)
        session.reads("a default COB-ID follows", 0x1800, 1, 0x1BC)


def variants(context: Context) -> None:
    """3120h:01h = 0: one axis after store and restart (S12, S61)."""
    with context.session(store=context.store(), scene="tilt=30,0") as session:
        session.put(0x3120, 1, 0)
        session.reads("3120h:01h reads what was written", 0x3120, 1, 0)
        session.reads("1000h is unchanged", 0x1000, 0, 0x0704019A)
        session.reset(p.RESET_COMMUNICATION)
        session.reads("1000h after reset communication", 0x1000, 0, 0x0704019A)
        session.put(0x3120, 1, 0)
        save(session)
        session.power_cycle()
        one_axis = {(0x1000, 0): 0x0703019A, (0x1A00, 0): 1, (0x1A00, 1): LONGITUDINAL, (0x1A00, 2): 0, (0x3120, 1): 0}
        check(session, "one axis", one_axis)
        session.reads("one axis: ST0 bit 0", 0x3000, 1, 0)
        session.sleep(0.5)
        session.reads("one axis: 6120h", 0x6120, 0, 0)
        for kind in (2, 3):
            session.refused(f"one axis: 3200h = {kind}", p.INVALID_VALUE, session.put, 0x3200, 0, kind)
        session.put(0x3200, 0, 1)
        session.sleep(0.1)
        session.report.verdict(session.get(0x6110) in (0, 1, 35999), "one axis: 3200h = 1", "0", session.get(0x6110))
        session.put(0x3210, 0, 0)
        session.accepted("one axis: 3220h is kept", 0x3220, 0, 500)
        session.sleep(0.1)
        session.reads("one axis: 3220h has no effect", 0x6120, 0, 0)
        remap(session, 1, [LATERAL])
        session.put(0x3120, 1, 1)
        session.put(0x3220, 0, 0)
        save(session)
        session.power_cycle()
        two_axes = {(0x1000, 0): 0x0704019A, (0x1A00, 0): 2, (0x1A00, 2): LATERAL, (0x1A01, 1): LATERAL}
        check(session, "two axes again", two_axes)


def stored_history(context: Context) -> None:
    """1003h is stored by 1010h:01h, and emptied by 1011h:01h (S1, S53)."""
    rows = [(0.0, scenes.up(0, 0)), (60.0, scenes.up(0, 0))]
    scene = scenes.write(context.folder / "supply.csv", rows)
    lines = scene.read_text().splitlines()
    lines = [lines[0] + ",supply_v"] + [f"{line},7" for line in lines[1:]]
    scene.write_text("\n".join(lines) + "\n")
    with context.session(store=context.store(), scene=scene) as session:
        session.sleep(0.5)
        session.reads("one error", 0x1003, 0, 1)
        session.reads("its code, high word 0", 0x1003, 1, 0x3100)
        session.refused("an entry above the number", p.NO_DATA, session.upload, 0x1003, 2)
        save(session)
        session.put(0x1003, 0, 0)
        session.power_cycle()
        session.sleep(0.3)
        session.report.verdict(session.get(0x1003) >= 1, "stored history", "at least 1", session.get(0x1003))
        session.report.equal("stored history: the oldest", 0x3100, session.get(0x1003, session.get(0x1003)))


GROUPS = (stored, restored, restored_addresses, addresses, variants, stored_history)
