"""IMS360: layer setting services (section 6.3, CiA 305, S9, S13, S40..S43)."""

from . import protocol as p
from .ims360_objects import NODE
from .runner import Context
from .session import Session

REQUEST, ANSWER = 0x7E5, 0x7E4
WAITING, CONFIGURATION = 0, 1


def identity(session: Session) -> list[int]:
    """The identity: the numbers of 6.3, and the serial number of the device."""
    return [0x195, 0x1869F, 0, session.get(0x1018, 4)]


def lss(session: Session, *data: int) -> None:
    """Sends a request."""
    session.send(REQUEST, bytes(data).ljust(8, b"\x00"))


def number(command: int, value: int) -> tuple[int, ...]:
    """A request with a number of 32 bits."""
    return (command, *p.encode(value, 4))


def answer(session: Session) -> str | None:
    """The next answer."""
    frame = session.wait(lambda frame: frame.id == ANSWER)
    return frame.data.hex() if frame else None


def check(session: Session, name: str, request: tuple[int, ...], expected: tuple[int, ...]) -> None:
    """Checks the answer to a request."""
    lss(session, *request)
    session.report.equal(name, bytes(expected).ljust(8, b"\x00").hex(), answer(session))


def silent(session: Session, name: str, *requests: tuple[int, ...]) -> None:
    """Checks that requests are not answered."""
    for request in requests:
        lss(session, *request)
    session.quiet(name)


def services(context: Context) -> None:
    """Each service in the states of 6.3."""
    with context.session() as session:
        own = identity(session)
        only = [(0x11, 60), (0x13, 0, 2), (0x15,), (0x17,), (0x5A,), (0x5B,), (0x5C,), (0x5D,), (0x5E,)]
        silent(session, "waiting: no service of the configuration", *only)
        session.reads("waiting: 2002h is unchanged", 0x2002, 0, NODE)
        session.reads("waiting: 2001h is unchanged", 0x2001, 0, 125_000)
        for state in (p.ENTER_PRE_OPERATIONAL, p.START, p.STOP):
            session.nmt(state)
            lss(session, 0x04, CONFIGURATION)
            check(session, f"NMT command {state}: node-ID", (0x5E,), (0x5E, NODE))
            for command, part in zip((0x5A, 0x5B, 0x5C, 0x5D), own, strict=True):
                check(session, f"NMT command {state}: {command:02X}h", (command,), number(command, part))
            lss(session, 0x04, WAITING)
            silent(session, f"NMT command {state}: waiting again", (0x5E,))
        session.nmt(p.ENTER_PRE_OPERATIONAL)
        selective(session, own)
        identify(session, own)
        lss(session, 0x04, CONFIGURATION)
        for node in (0, 127, 128, 254):
            check(session, f"node-ID {node}", (0x11, node), (0x11, 1))
        for table, index in ((0, 5), (0, 6), (0, 7), (0, 8), (0, 9), (1, 0), (0x80, 0)):
            check(session, f"bit timing {table}, {index}", (0x13, table, index), (0x13, 1))
        for index, rate in enumerate((1_000_000, 800_000, 500_000, 250_000, 125_000)):
            check(session, f"bit timing 0, {index}", (0x13, 0, index), (0x13, 0))
            session.reads(f"bit timing 0, {index}: 2001h", 0x2001, 0, rate)
        silent(session, "configuration: no fastscan", (*number(0x51, 0), 128))
        silent(session, "unknown services", (0x00,), (0x05,), (0x12,), (0x44,), (0x52,), (0xFF,))
        session.send(REQUEST, b"\x5e")
        session.quiet("less than 8 bytes")
        check(session, "still in the configuration", (0x5E,), (0x5E, NODE))


def selective(session: Session, own: list[int]) -> None:
    """Switch state selective: all four numbers must match."""
    for wrong in range(4):
        for place, part in enumerate(own):
            lss(session, *number(0x40 + place, part ^ (place == wrong)))
        session.quiet(f"selective: number {wrong} is another one")
    for place, part in enumerate(own):
        lss(session, *number(0x40 + place, part))
    session.report.equal("selective: answer", "4400000000000000", answer(session))
    check(session, "selective: configuration", (0x5E,), (0x5E, NODE))
    lss(session, 0x04, WAITING)


def identify(session: Session, own: list[int]) -> None:
    """Identify remote slave: the ranges of revision and serial number."""
    serial = own[3]
    ranges = ((0, 0xFFFFFFFF, True), (serial, serial, True), (serial + 1, 0xFFFFFFFF, False), (0, serial - 1, False))
    for low, high, expected in ranges:
        for command, part in zip(range(0x46, 0x4C), (*own[:2], 0, 0, low, high), strict=True):
            lss(session, *number(command, part))
        got = answer(session)
        session.report.equal(f"identify {low:X}h..{high:X}h", "4f00000000000000" if expected else None, got)
    silent(session, "identify non-configured: the node has a node-ID", (0x4C,))
    silent(session, "fastscan: the node has a node-ID", (*number(0x51, 0), 128))


def node_id(context: Context) -> None:
    """A node-ID by LSS: in force after a reset, stored by 17h."""
    with context.session(store=context.store()) as session:
        lss(session, 0x04, CONFIGURATION)
        check(session, "node-ID 60", (0x11, 60), (0x11, 0))
        check(session, "the active node-ID is still 50", (0x5E,), (0x5E, NODE))
        session.reads("2002h reads the pending one", 0x2002, 0, 60)
        session.put(0x3111, 0, 3000)
        check(session, "store", (0x17,), (0x17, 0))
        lss(session, 0x04, WAITING)
        session.nmt(p.RESET_COMMUNICATION)
        session.node = 60
        session.report.equal("boot-up of node 60", True, session.wait_boot_up())
        session.reads("COB-ID EMCY follows", 0x1014, 0, 0x80 + 60)
        session.reads("COB-ID of TPDO 2 follows", 0x1801, 1, 0x80000280 + 60)
        session.power_cycle()
        session.reads("2002h after power-up", 0x2002, 0, 60)
        session.reads("17h keeps nothing else", 0x3111, 0, 2000)


def bit_rate(context: Context) -> None:
    """A bit rate by LSS, stored by 17h."""
    with context.session(store=context.store()) as session:
        lss(session, 0x04, CONFIGURATION)
        check(session, "500 kbit/s", (0x13, 0, 2), (0x13, 0))
        check(session, "store", (0x17,), (0x17, 0))
        lss(session, 0x04, WAITING)
        session.power_cycle()
        session.reads("2001h after power-up", 0x2001, 0, 500_000)
        lss(session, 0x04, CONFIGURATION)
        check(session, "250 kbit/s", (0x13, 0, 3), (0x13, 0))
        lss(session, 0x15, *p.encode(200, 2))
        session.quiet("activate: no answer, silent for twice the delay", 0.35)
        session.report.equal("activate: boot-up at the new bit rate", True, session.wait_boot_up(2.0))
        session.reads("2001h", 0x2001, 0, 250_000)


def scan(session: Session) -> list[int] | None:
    """Finds an unconfigured node by fastscan as CiA 305 describes it."""
    found = [0] * 4

    def asks(value: int, bit: int, sub: int, then: int) -> bool:
        lss(session, *number(0x51, value), bit, sub, then)
        return session.wait(lambda frame: frame.id == ANSWER and frame.data[0] == 0x4F, 0.05) is not None

    if not asks(0, 128, 0, 0):
        return None
    for sub in range(4):
        for bit in range(31, -1, -1):
            if not asks(found[sub], bit, sub, sub):
                found[sub] |= 1 << bit
        if not asks(found[sub], 0, sub, (sub + 1) % 4):
            return None
    return found


def unconfigured(context: Context) -> None:
    """Node-ID 255: silent but for LSS; found by fastscan; with a new node-ID it boots by itself (S40)."""
    with context.session(store=context.store()) as session:
        own = identity(session)
        lss(session, 0x04, CONFIGURATION)
        check(session, "node-ID 255", (0x11, 255), (0x11, 0))
        session.reads("2002h reads 255", 0x2002, 0, 255)
        lss(session, 0x04, WAITING)
        session.nmt(p.RESET_COMMUNICATION)
        session.quiet("no boot-up", 0.3)
        session.send(p.SDO_REQUEST + NODE, bytes([0x40, 0, 0x10, 0, 0, 0, 0, 0]))
        session.quiet("no SDO")
        check(session, "identify non-configured", (0x4C,), (0x50,))
        session.report.equal("fastscan", own, scan(session))
        check(session, "fastscan ends in the configuration", (0x5E,), (0x5E, 255))
        check(session, "store 255", (0x17,), (0x17, 0))
        session.power_down()
        session.power_up(boot=False)
        session.quiet("power-up with the stored 255: no boot-up", 0.5)
        session.report.equal("fastscan again", own, scan(session))
        check(session, "node-ID 51", (0x11, 51), (0x11, 0))
        check(session, "store 51", (0x17,), (0x17, 0))
        lss(session, 0x04, WAITING)
        session.node = 51
        session.report.equal("boot-up by leaving the configuration", True, session.wait_boot_up(2.0))
        session.reads("SDO with the new node-ID", 0x2002, 0, 51)


GROUPS = (services, node_id, bit_rate, unconfigured)
