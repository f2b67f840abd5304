"""Get and Set of attributes 0..255 on each class and instance; the identity, DeviceNet and assembly objects."""

from . import protocol as p
from .runner import Context
from .session import Session

INSTANCES = (
    (1, 0), (1, 1), (2, 0), (2, 1), (3, 0), (3, 1), (4, 0), (4, 0x65), (4, 0x66), (4, 0x67),
    (5, 0), (5, 1), (5, 2), (5, 4), (0x2B, 0), (0x2B, 1), (0x65, 0), (0x65, 1),
)  # fmt: skip
CONNECTION_ATTRIBUTES = (*range(1, 10), *range(12, 18))
READABLE = {
    (1, 1): range(1, 8),
    (2, 1): (),
    (3, 1): range(1, 6),
    (4, 0x65): (3,),
    (4, 0x66): (3,),
    (4, 0x67): (3,),
    (5, 1): CONNECTION_ATTRIBUTES,
    (5, 2): CONNECTION_ATTRIBUTES,
    (5, 4): CONNECTION_ATTRIBUTES,
    (0x2B, 1): (1, 2, 3),
    (0x65, 1): (1,),
}
SETTABLE = {
    (3, 1): (1, 2, 3, 4),
    (5, 1): (9, 12, 17),
    (5, 2): (9, 17),
    (5, 4): (9, 17),
    (0x2B, 1): (1, 2),
}
# May be there or not: identity above 7 except the heartbeat (T27), the size of an assembly, attributes 18 and 19 of a
# connection, and 17 of those connections that have no production of their own.
OPTIONAL = {
    (1, 1): (8, 9, *range(11, 20)),
    (4, 0x65): (1, 2, 4),
    (4, 0x66): (1, 2, 4),
    (4, 0x67): (1, 2, 4),
    (5, 1): (17, 18, 19),
    (5, 2): (17, 18, 19),
    (5, 4): (18, 19),
}
# Revisions of the classes that are known.
REVISIONS = {3: "0200", 4: "0200", 5: "0100"}


def get_sweep(context: Context) -> None:
    """Get of attributes 0..255 on each class and instance."""
    with context.session() as session:
        session.connect(0x13, poll=0, cos=0)
        for kind, instance in INSTANCES:
            sweep(
                session, f"get class {kind:02X}h instance {instance}", lambda n, k=kind, i=instance: get_problem(session, k, i, n)
            )


def get_problem(session: Session, kind: int, instance: int, attribute: int) -> str | None:
    """What is wrong with the answer to Get."""
    answer = session.get_answer(kind, instance, attribute)
    missing = answer == "94" + p.NO_ATTRIBUTE
    if kind == p.ROUTER:
        missing = missing or answer == "94" + p.NO_SERVICE
    if instance == 0:
        # Attributes 1..7 of a class are optional, unless the revision is known.
        if attribute == 1 and kind in REVISIONS:
            return None if answer == "8E" + REVISIONS[kind] else answer
        if attribute == 1 and len(answer) == 6 and answer[:2] == "8E":
            return None
        good = missing or answer == "94" + p.NO_SERVICE or (2 <= attribute <= 7 and answer[:2] == "8E")
        return None if good else answer
    readable = attribute in p.BY_ID if kind == p.ANGLE else attribute in READABLE[kind, instance]
    if attribute in OPTIONAL.get((kind, instance), ()) and (missing or answer[:2] == "8E"):
        return None
    return None if (answer[:2] == "8E" if readable else missing) else answer


def set_sweep(context: Context) -> None:
    """Set of attributes 0..255 without data: 08h at the class, else 14h, 0Eh or, if it can be set, 13h."""
    with context.session() as session:
        session.connect(0x13, poll=0, cos=0)
        before = session.angles()
        for kind, instance in INSTANCES:
            for data in ("", "00"):
                name = f"set class {kind:02X}h instance {instance} {'without data' if not data else 'one byte'}"
                sweep(session, name, lambda n, k=kind, i=instance, d=data: set_problem(session, k, i, n, d))
        session.report.equal("nothing has changed", before, session.angles())


def set_problem(session: Session, kind: int, instance: int, attribute: int, data: str) -> str | None:
    """What is wrong with the answer to Set."""
    if kind == p.ANGLE and instance:
        settable = attribute in p.BY_ID and p.BY_ID[attribute].range is not None
        readable = attribute in p.BY_ID
    else:
        settable = attribute in SETTABLE.get((kind, instance), ())
        readable = attribute in READABLE.get((kind, instance), ())
    if data and settable:
        return None
    answer = session.set(kind, instance, attribute, data)
    if instance == 0:
        expected = {p.NO_SERVICE}
    elif settable:
        # The bus-off counter is cleared by any request; its value has no meaning.
        expected = {p.TOO_SHORT}
        if (kind, attribute) == (p.DEVICENET, 4) and answer == "90":
            return None
    elif readable:
        expected = {p.NOT_SETTABLE}
    else:
        expected = {p.NO_ATTRIBUTE}
    if attribute in OPTIONAL.get((kind, instance), ()):
        expected |= {p.NO_ATTRIBUTE, p.NOT_SETTABLE, p.TOO_SHORT}
    if kind in (p.IDENTITY, p.ROUTER):
        # Objects in which nothing can be set need not have the service.
        expected.add(p.NO_SERVICE)
    if kind == p.ROUTER:
        expected |= {p.NOT_SETTABLE}
    return None if answer in {"94" + code for code in expected} else answer


def sweep(session: Session, name: str, problem) -> None:
    """Runs a check for attributes 0..255, one line for ten of them."""
    for first in range(0, 256, 10):
        last = min(first + 9, 255)
        found = {f"{n:02X}h": wrong for n in range(first, last + 1) if (wrong := problem(n)) is not None}
        session.report.equal(f"{name}: attributes {first}..{last}", {}, found)


def identity(context: Context) -> None:
    """The identity object (T8)."""
    with context.session() as session:
        session.connect()
        report, get = session.report, lambda attribute: session.get(p.IDENTITY, 1, attribute)
        report.equal("vendor", p.encode(p.VENDOR, 2), get(1))
        report.equal("device type", "0000", get(2))
        report.verdict(len(get(3)) == 4 and p.decode(get(3)) >= 1, "product code", "1..65535", get(3))
        major, minor = bytes.fromhex(get(4))
        report.verdict(1 <= major <= 127 and minor >= 1, "revision", "1..127, 1..255", f"{major}.{minor}")
        # Bit 2 (configured) and the extended status may have any value.
        report.equal("status: owned, no fault, reserved bits 0", 0x0001, p.decode(get(5)) & 0xFF0B)
        report.equal("serial number: size", 4, len(get(6)) // 2)
        name = session.subject.name.encode()
        report.equal("product name", (bytes([len(name)]) + name).hex().upper(), get(7))
        session.report.equal("the same after other requests", get(6), get(6))


def devicenet_object(context: Context) -> None:
    """The DeviceNet object."""
    with context.session() as session:
        session.connect()
        report, get = session.report, lambda attribute: session.get(p.DEVICENET, 1, attribute)
        report.equal("MAC ID", "3F", get(1))
        report.equal("baud rate", "00", get(2))
        report.equal("bus-off interrupt", "00", get(3))
        report.equal("bus-off counter", "00", get(4))
        report.equal("allocation information", "010A", get(5))
        for value in ("00", "01", "FF", "7F"):
            session.expect("any value clears the bus-off counter", f"0A10030104{value}", "0A90")
            report.equal("bus-off counter", "00", get(4))
        for value in (1, 2, 0):
            session.expect("baud rate", f"0A10030102{value:02X}", "0A90")
            report.equal("baud rate reads back at once", f"{value:02X}", get(2))
        for value in (1, 0):
            session.expect("bus-off interrupt", f"0A10030103{value:02X}", "0A90")
            report.equal("bus-off interrupt reads back", f"{value:02X}", get(3))
        session.release(1)
        for choice in (0x01, 0x03, 0x11, 0x21, 0x51, 0x61, 0x53, 0x63, 0x13, 0x23):
            session.allocate(choice)
            report.equal(f"allocation information of {choice:02X}h", f"{choice:02X}0A", get(5))
            session.release(choice)


def assemblies(context: Context) -> None:
    """The data of the assemblies, which is that of the slopes."""
    with context.session() as session:
        session.connect(3, poll=0)
        long, lateral = p.encode(session.subject.long, 2), p.encode(session.subject.lateral, 2)
        for instance, expected in ((0x65, long), (0x66, lateral), (0x67, long + lateral)):
            session.report.equal(f"assembly {instance}", expected, session.get(p.ASSEMBLY, instance, 3))
        session.put_angle(0x71, 100)
        expected = p.encode(session.subject.rounded(session.subject.long, 100), 2)
        session.report.equal("assembly 101 at 0.1 deg", expected, session.get(p.ASSEMBLY, 0x65, 3))
        for instance in (0x64, 0x68, 1):
            session.report.equal(f"assembly {instance}", "?94" + p.NO_OBJECT, session.get(p.ASSEMBLY, instance, 3))


GROUPS = (get_sweep, set_sweep, identity, devicenet_object, assemblies)
