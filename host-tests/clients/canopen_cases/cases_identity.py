"""Node-ID, bit rate and programming key (sections 9.1, 9.11 and chapter 10, J9)."""

import base64

from . import protocol as p
from .runner import Context
from .session import SensorGone, Session

FACTORY_KEY = b"D0UfZEgRKHAI5Ag="
BIT_RATES = (10, 20, 50, 250, 500, 800, 1000)


def check_identifiers(session: Session, node: int) -> None:
    """The pre-defined connection set of a node-ID."""
    wanted = {
        (0x1014, 0): 0x080 + node,
        (0x1200, 1): 0x600 + node,
        (0x1200, 2): 0x580 + node,
        (0x1800, 1): 0x180 + node,
        (0x1801, 1): 0x280 + node,
    }
    got = {key: session.get(*key) for key in wanted}
    session.report.equal(f"node {node}: COB-IDs", wanted, got)
    session.put(0x1800, 2, 1)
    session.put(0x1801, 2, 1)
    session.nmt(p.START)
    session.send(p.SYNC)
    frames = sorted(frame.id for frame in session.collect(0.15))
    session.report.equal(f"node {node}: PDOs", [0x180 + node, 0x280 + node], frames)
    session.nmt(p.ENTER_PRE_OPERATIONAL)


def node_id(context: Context) -> None:
    """A node-ID takes effect with any reset; all identifiers follow it."""
    for name, action in (
        ("reset communication", lambda session: session.nmt(p.RESET_COMMUNICATION, 0)),
        ("reset node", lambda session: session.nmt(p.RESET_NODE, 0)),
        ("power cycle", None),
        ("2002h", lambda session: session.send(p.SDO_REQUEST + 10, bytes([0x2F, 0x02, 0x20, 0x00, 1, 0, 0, 0]))),
    ):
        with context.session(store=context.store(name.replace(" ", "-"))) as session:
            session.put(0x2000, 0, 42)
            session.reads(f"{name}: written node-ID before it", 0x2000, 0, 42)
            session.reads(f"{name}: identifiers of node 10 before it", 0x1200, 1, 0x60A)
            session.download(0x1010, 1, p.SAVE)
            session.node = 42
            if action is None:
                session.power_cycle()
                booted = True
            else:
                action(session)
                booted = session.wait_boot_up()
            session.report.equal(f"{name}: boot-up of node 42", True, booted)
            check_identifiers(session, 42)
            session.send(p.SDO_REQUEST + 10, bytes([0x40, 0, 0x10, 0, 0, 0, 0, 0]))
            session.send(p.NMT, bytes([p.STOP, 10]))
            session.quiet(f"{name}: no answer of node 10")
            session.check_state(f"{name}: commands for node 10 have no effect", p.PRE_OPERATIONAL)


def unsaved_node_id(context: Context) -> None:
    """Without a save, the node-ID takes effect with the NMT resets and with 2002h; only the power loses it (J14)."""
    with context.session(store=context.store()) as session:
        for node, command in ((1, p.RESET_COMMUNICATION), (127, p.RESET_NODE), (64, None)):
            session.put(0x2000, 0, node)
            if command:
                session.nmt(command)
            else:
                session.report.equal("2002h is answered", 0, session.abort_code(session.put, 0x2002, 0, 1))
            session.node = node
            session.report.equal(f"boot-up of node {node}", True, session.wait_boot_up())
            check_identifiers(session, node)
        session.node = p.FACTORY_NODE_ID
        session.power_cycle()
        check_identifiers(session, p.FACTORY_NODE_ID)


def saved_set(context: Context) -> None:
    """After a save of the connection set, a changed node-ID still sets all identifiers (chapter 10)."""
    with context.session(store=context.store()) as session:
        session.download(0x1010, 1, p.SAVE)
        session.put(0x2000, 0, 55)
        session.download(0x1010, 1, p.SAVE)
        session.node = 55
        session.power_cycle()
        check_identifiers(session, 55)


def bit_rate(context: Context) -> None:
    """Every bit rate takes effect with a reset."""
    for rate in BIT_RATES:
        with context.session(store=context.store(f"rate{rate}"), bus_rate="125") as session:
            session.put(0x2001, 0, rate)
            session.download(0x1010, 1, p.SAVE)
            session.reads(f"{rate} kbit/s: still at 125 kbit/s before the reset", 0x2001, 0, rate)
            session.power_down()
            session.options["bus_rate"] = str(rate)
            try:
                session.power_up()
                session.reads(f"{rate} kbit/s: boot-up on a bus at this rate", 0x2001, 0, rate)
            except SensorGone as error:
                session.report.verdict(False, f"{rate} kbit/s: boot-up on a bus at this rate", "boot-up", error)
    with context.session(store=context.store("rate10"), bus_rate="10") as session:
        session.power_down()
        session.options["bus_rate"] = "125"
        session.power_up(boot=False)
        session.quiet("10 kbit/s: nothing on a bus at 125 kbit/s", 0.5)
        session.report.equal("10 kbit/s: no answer at 125 kbit/s", None, session.sdo(bytes([0x40, 0, 0x10, 0])))
    with context.session(store=context.store("reset"), bus_rate="125") as session:
        session.put(0x2001, 0, 500)
        session.download(0x1010, 1, p.SAVE)
        session.nmt(p.RESET_COMMUNICATION)
        session.quiet("500 kbit/s after reset communication: no frame at 125 kbit/s", 0.5)


def programming_key(context: Context) -> None:
    """3000h: the key of a sensor with factory values, a copy of the parameters, refusal of invalid keys."""
    with context.session(store=context.store()) as session:
        session.report.equal("factory values", FACTORY_KEY, session.upload(0x3000))
        before = session.snapshot()
        for name, key in bad_keys().items():
            codes = {p.INVALID_VALUE} if len(key) == 16 else {p.INVALID_VALUE, *p.LONG, *p.SHORT}
            session.refused(f"{name} is refused", codes, session.download_segments, 0x3000, 0, key)
        session.report.equal("refused keys change nothing", before, session.snapshot())
        changes = {0x2000: 20, 0x2001: 250, 0x2040: 2, 0x2041: 0, 0x2043: 3, 0x2044: 2, 0x2045: 0, 0x6000: 1000}
        for index, value in changes.items():
            session.put(index, 0, value)
        key = session.upload(0x3000)
        session.report.verdict(key != FACTORY_KEY, "other parameters, another key", "another", key.decode())
        valid = len(base64.b64decode(key, validate=True)) > 0
        session.report.equal("the key is Base64", True, valid)
        for at in range(len(key) - 1):
            if key[at : at + 1] != b"=":
                wrong = key[:at] + (b"A" if key[at : at + 1] != b"A" else b"B") + key[at + 1 :]
                code = session.abort_code(session.download, 0x3000, 0, wrong)
                session.report.equal(f"key with a wrong character {at}", f"{p.INVALID_VALUE:08X}h", f"{code:08X}h")
        with context.session(store=context.store("copy")) as copy:
            copy.report.equal("written to another sensor", 0, copy.abort_code(copy.download, 0x3000, 0, key))
            copy.report.equal("the parameters are copied", changes, {index: copy.get(index) for index in changes})
            copy.report.equal("the other sensor has the same key", key, copy.upload(0x3000))
            copy.reads("the node-ID is not in force before a reset", 0x1200, 1, 0x60A)
            copy.report.equal("the factory key is accepted", 0, copy.abort_code(copy.download, 0x3000, 0, FACTORY_KEY))
            factory = {index: p.BY_KEY[index, 0].default for index in changes}
            copy.report.equal("the factory key restores the factory values", factory, {i: copy.get(i) for i in factory})


def bad_keys() -> dict[str, bytes]:
    """Invalid keys."""
    return {
        "a wrong checksum": b"D0UfZEgRKHAI5Ah=",
        "one wrong bit": b"D0UeZEgRKHAI5Ag=",
        "not Base64": b"D0UfZEgR*HAI5Ag=",
        "no padding": b"D0UfZEgRKHAI5Ag",
        "too short": b"D0UfZEgRKHA=",
        "too long": b"D0UfZEgRKHAI5Ag=D0UfZEgRKHAI5Ag=",
        "spaces": b" " * 16,
        "zeros": bytes(16),
    }


GROUPS = (node_id, unsaved_node_id, saved_set, bit_rate, programming_key)
