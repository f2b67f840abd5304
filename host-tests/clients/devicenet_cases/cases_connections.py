"""The connection object: its attributes in each kind of allocation, rates, watchdog action, inhibit time. The acknowledge handler
object."""

from . import protocol as p
from .runner import Context
from .session import Session

PATH = {101: "200424653003", 102: "200424663003", 103: "200424673003"}


def values(session: Session, choice: int, instance: int, assembly: int = 103) -> dict[int, tuple[str, ...]]:
    """The attributes of a connection after the allocation; several values where each is right."""
    word = lambda message: p.encode(session.id(message), 2)  # noqa: E731
    if instance == p.C_EXPLICIT:
        return {
            1: ("03",), 2: ("00",), 3: ("83",), 4: (word(p.RESPONSE),), 5: (word(p.EXPLICIT),), 6: ("21",), 9: ("C409",),
            12: ("01",), 13: ("0000",), 14: ("",), 15: ("0000",), 16: ("",), 17: ("0000", "?9414FF"),
        }  # fmt: skip
    size = 4 if assembly == 103 else 2
    suppressed, cyclic = choice & p.CHOICE_SUPPRESS, choice & p.CHOICE_CYCLIC
    found = {
        1: ("01",), 2: ("01",), 7: (p.encode(size, 2),), 8: ("0000",), 9: ("0000",), 12: ("00",),
        13: ("0600",), 14: (PATH[assembly],),
    }  # fmt: skip
    if instance == p.C_POLL:
        return found | {
            3: ("82",), 4: (p.encode(p.poll_response(session.mac), 2),), 5: (word(p.POLL),), 6: ("01",), 15: ("0000",), 16: ("",),
            17: ("0000", "?9414FF"),
        }  # fmt: skip
    return found | {
        3: (("00" if cyclic else "10") if suppressed else ("03" if cyclic else "13"),),
        4: (p.encode(p.change_of_state(session.mac), 2),),
        5: ("FFFF" if suppressed else word(p.ACKNOWLEDGE),),
        6: ("0F" if suppressed else "01",),
        15: ("0000" if suppressed else "0400",),
        16: ("" if suppressed else "202B2401",),
        17: ("0000",),
    }


def check_values(
    session: Session, name: str, choice: int, instance: int, assembly: int = 103, skip: tuple[int, ...] = ()
) -> None:
    """Checks the attributes of one connection."""
    for attribute, expected in values(session, choice, instance, assembly).items():
        if attribute not in skip:
            got = session.get(p.CONNECTION, instance, attribute)
            what = f"{name}: connection {instance} attribute {attribute}"
            session.report.verdict(got in expected, what, " or ".join(expected) or "empty", got)


def attributes(context: Context) -> None:
    """All attributes for each choice; only the instances that are allocated exist."""
    with context.session() as session:
        for choice in (0x01, 0x03, 0x11, 0x21, 0x51, 0x61, 0x13, 0x63):
            session.allocate(choice)
            name = f"choice {choice:02X}h"
            check_values(session, name, choice, p.C_EXPLICIT)
            for instance, bits in ((p.C_POLL, 0x02), (p.C_COS, 0x30)):
                if choice & bits:
                    check_values(session, name, choice, instance)
                else:
                    session.report.equal(
                        f"{name}: connection {instance}", "?94" + p.NO_OBJECT, session.get(p.CONNECTION, instance, 1)
                    )
            for attribute in (7, 8):
                session.report.within(
                    f"{name}: connection 1 attribute {attribute}", 8, 65535, session.number(p.CONNECTION, 1, attribute)
                )
            session.release(choice)


def attributes_of_assemblies(context: Context) -> None:
    """Produced size and path name the selected assembly (T30); so does the data."""
    with context.session() as session:
        long, lateral = p.encode(session.subject.long, 2), p.encode(session.subject.lateral, 2)
        session.connect()
        for assembly, data in ((101, long), (102, lateral), (103, long + lateral)):
            session.put_angle(0x81, assembly)
            session.put_angle(0x82, 204 - assembly if assembly != 103 else 103)
            other = session.angle(0x82)
            session.allocate(0x52)
            check_values(session, f"poll of assembly {assembly}", 0x53, p.C_POLL, assembly)
            check_values(session, f"COS of assembly {other}", 0x53, p.C_COS, other)
            session.rate(p.C_POLL, 0)
            session.report.equal(f"poll of assembly {assembly}", data, session.poll())
            session.others.clear()
            session.rate(p.C_COS, 0)
            produced = [frame.data.hex().upper() for frame in session.produced(0.2)]
            session.report.equal(f"COS of assembly {other}", [{101: long, 102: lateral, 103: long + lateral}[other]], produced)
            session.release(0x52)


def state_conflict(context: Context) -> None:
    """81h and 82h while their connection exists (T2, T17)."""
    with context.session() as session:
        for choice, conflicts in (
            (0x03, (0x81,)),
            (0x11, (0x82,)),
            (0x21, (0x82,)),
            (0x61, (0x82,)),
            (0x13, (0x81, 0x82)),
            (0x01, ()),
        ):
            for established in (False, True):
                session.connect(choice)
                if established:
                    for instance, bits in ((p.C_POLL, 0x02), (p.C_COS, 0x30)):
                        if choice & bits:
                            session.rate(instance, 0)
                for attribute in (0x81, 0x82):
                    name = f"choice {choice:02X}h, {'established' if established else 'configuring'}: {attribute:02X}h"
                    expected = "94" + p.STATE_CONFLICT if attribute in conflicts else "90"
                    session.report.equal(f"{name} = 101", expected, session.set_angle(attribute, 101))
                    session.report.equal(f"{name}: read back", 103 if attribute in conflicts else 101, session.angle(attribute))
                    for value in (0, 100, 104, 255):
                        session.report.equal(f"{name} = {value}", "94" + p.INVALID_VALUE, session.set_angle(attribute, value))
                    for data, code in (("", p.TOO_SHORT), ("6500", p.TOO_LONG)):
                        session.report.equal(f"{name}, data '{data}'", "94" + code, session.set(p.ANGLE, 1, attribute, data))
                if choice & 0x02 and established:
                    session.report.equal(
                        f"choice {choice:02X}h: poll goes on", session.words(session.subject.long), session.poll()
                    )
                session.release(choice)
                session.connect()
                for attribute in (0x81, 0x82):
                    session.report.equal(
                        f"after choice {choice:02X}h: {attribute:02X}h = 103", "90", session.set_angle(attribute, 103)
                    )
                session.release(1)
                session.others.clear()


def not_settable(context: Context) -> None:
    """Attributes 1..8 and 13..16, and 12 of the I/O connections: 0Eh with any data."""
    with context.session() as session:
        session.connect(0x13)
        for instance in (p.C_EXPLICIT, p.C_POLL, p.C_COS):
            for attribute in (*range(1, 9), *range(13, 17), *((12,) if instance != p.C_EXPLICIT else ())):
                for data in ("", "00", "0000", "000000"):
                    answer = session.set(p.CONNECTION, instance, attribute, data)
                    name = f"connection {instance} attribute {attribute} = '{data}'"
                    session.report.equal(name, "94" + p.NOT_SETTABLE, answer)
            skip = (9,) if instance == p.C_EXPLICIT else ()
            check_values(session, "after the refusals", 0x13, instance, skip=skip)


def rates(context: Context) -> None:
    """The rate is taken exactly; 1 becomes 2 on the COS/cyclic connection (T18). The answer is the actual value."""
    with context.session() as session:
        for choice in (0x13, 0x63):
            session.connect(choice)
            for instance in (p.C_POLL, p.C_COS, p.C_EXPLICIT):
                for value in (65535, 10000, 2500, 5001, 3000, 65534, 32768, 4097):
                    rate(session, f"choice {choice:02X}h", instance, value, value)
                small = {p.C_COS: {1: 2, 2: 2, 3: 3, 7: 7}, p.C_POLL: {1: 1, 2: 2, 3: 3}, p.C_EXPLICIT: {}}[instance]
                for value, actual in small.items():
                    rate(session, f"choice {choice:02X}h", instance, value, actual)
                rate(session, f"choice {choice:02X}h", instance, 0, 0)
                for data, code in (("", p.TOO_SHORT), ("64", p.TOO_SHORT), ("640000", p.TOO_LONG)):
                    answer = session.set(p.CONNECTION, instance, 9, data)
                    session.report.equal(f"connection {instance}: rate '{data}'", "94" + code, answer)
                session.report.equal(
                    f"connection {instance}: rate after the refusals", "0000", session.get(p.CONNECTION, instance, 9)
                )
                session.report.equal(f"connection {instance}: established", p.ESTABLISHED, session.state(instance))
            session.release(choice)
            session.collect(0.05)
            session.others.clear()


def rate(session: Session, name: str, instance: int, value: int, actual: int) -> None:
    """Sets a rate and checks the answer and the value read back."""
    answer = session.set(p.CONNECTION, instance, 9, p.encode(value, 2))
    session.report.equal(f"{name}, connection {instance}: rate {value}", "90" + p.encode(actual, 2), answer)
    session.report.equal(
        f"{name}, connection {instance}: rate {value} read back", p.encode(actual, 2), session.get(p.CONNECTION, instance, 9)
    )


def watchdog_action(context: Context) -> None:
    """Watchdog action of the explicit connection: 1 and 3."""
    with context.session() as session:
        session.connect(3)
        for value in range(256):
            if value in (1, 3) or value < 8 or value % 37 == 0:
                expected = "90" if value in (1, 3) else "94" + p.INVALID_VALUE
                session.report.equal(f"action {value}", expected, session.set(p.CONNECTION, 1, 12, f"{value:02X}"))
        session.report.equal("action after the refusals", "03", session.get(p.CONNECTION, 1, 12))
        session.report.equal("too long", "94" + p.TOO_LONG, session.set(p.CONNECTION, 1, 12, "0100"))
        session.report.equal("too short", "94" + p.TOO_SHORT, session.set(p.CONNECTION, 1, 12, ""))
        session.release(3)
        session.connect()
        session.report.equal("action of a new connection", "01", session.get(p.CONNECTION, 1, 12))


def inhibit_time(context: Context) -> None:
    """The production inhibit time of the COS/cyclic connection: exact, returned, not above a rate other than 0."""
    with context.session() as session:
        for choice in (0x11, 0x61):
            session.connect(choice)
            for value in (0, 1, 2, 3, 100, 999, 10000, 65535):
                answer = session.set(p.CONNECTION, p.C_COS, 17, p.encode(value, 2))
                session.report.equal(f"choice {choice:02X}h: inhibit time {value}", "90" + p.encode(value, 2), answer)
                session.report.equal(f"choice {choice:02X}h: {value} read back", value, session.number(p.CONNECTION, p.C_COS, 17))
            for data, code in (("", p.TOO_SHORT), ("64", p.TOO_SHORT), ("640000", p.TOO_LONG)):
                session.report.equal(f"inhibit time '{data}'", "94" + code, session.set(p.CONNECTION, p.C_COS, 17, data))
            session.put(p.CONNECTION, p.C_COS, 17, "C800")
            above = "94" + p.INHIBIT_ABOVE_RATE
            session.report.equal("inhibit time 200, then rate 100", above, session.set(p.CONNECTION, p.C_COS, 9, "6400"))
            session.report.equal("still configuring", p.CONFIGURING, session.state(p.C_COS))
            session.report.equal("inhibit time 200, then rate 200", "90C800", session.set(p.CONNECTION, p.C_COS, 9, "C800"))
            session.report.equal("rate 200, then inhibit time 201", above, session.set(p.CONNECTION, p.C_COS, 17, "C900"))
            session.report.equal("inhibit time is kept", 200, session.number(p.CONNECTION, p.C_COS, 17))
            session.report.equal("rate 200, then inhibit time 100", "906400", session.set(p.CONNECTION, p.C_COS, 17, "6400"))
            session.report.equal("inhibit time 100, then rate 0", "900000", session.set(p.CONNECTION, p.C_COS, 9, "0000"))
            session.report.equal("rate 0, then inhibit time 500", "90F401", session.set(p.CONNECTION, p.C_COS, 17, "F401"))
            session.release(choice)
            session.collect(0.05)
            session.others.clear()


def handler(context: Context) -> None:
    """The acknowledge handler object."""
    with context.session() as session:
        session.connect(0x11)
        report, number = session.report, lambda attribute: session.number(p.HANDLER, 1, attribute)
        report.equal("timer", "1000", session.get(p.HANDLER, 1, 1))
        report.equal("retries", "01", session.get(p.HANDLER, 1, 2))
        report.equal("connection instance", p.C_COS, number(3))
        for value in (1, 16, 17, 100, 1000, 65535):
            report.equal(f"timer {value}", "90" + p.encode(value, 2), session.set(p.HANDLER, 1, 1, p.encode(value, 2)))
            report.equal(f"timer {value} read back", value, number(1))
        report.equal("timer 0", "94" + p.INVALID_VALUE, session.set(p.HANDLER, 1, 1, "0000"))
        report.equal("timer after 0", 65535, number(1))
        for value in (0, 1, 3, 255):
            report.equal(f"retries {value}", "90", session.set(p.HANDLER, 1, 2, f"{value:02X}"))
            report.equal(f"retries {value} read back", value, number(2))
        for attribute, data, code in (
            (1, "", p.TOO_SHORT),
            (1, "10", p.TOO_SHORT),
            (1, "100000", p.TOO_LONG),
            (2, "", p.TOO_SHORT),
            (2, "0100", p.TOO_LONG),
        ):
            report.equal(f"attribute {attribute} = '{data}'", "94" + code, session.set(p.HANDLER, 1, attribute, data))
        for data in ("", "04", "0400", "05"):
            report.equal(f"connection instance = '{data}'", "94" + p.NOT_SETTABLE, session.set(p.HANDLER, 1, 3, data))
        for instance in (2, 3, 255):
            report.equal(f"instance {instance}", "?94" + p.NO_OBJECT, session.get(p.HANDLER, instance, 1))


GROUPS = (attributes, attributes_of_assemblies, state_conflict, not_settable, rates, watchdog_action, inhibit_time, handler)
