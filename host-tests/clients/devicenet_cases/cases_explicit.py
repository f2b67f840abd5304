"""Explicit messages: each error code, the order of the checks, XID, malformed requests, services."""

from . import protocol as p
from .runner import Context
from .session import text

# Class and instance pairs that exist without a connection of their own.
EXISTING = (
    (1, 0),
    (1, 1),
    (2, 0),
    (2, 1),
    (3, 0),
    (3, 1),
    (4, 0),
    (4, 0x65),
    (4, 0x66),
    (4, 0x67),
    (5, 0),
    (5, 1),
    (0x65, 0),
    (0x65, 1),
)
MISSING_INSTANCES = (
    (1, 2),
    (1, 255),
    (2, 2),
    (3, 2),
    (3, 255),
    (4, 1),
    (4, 0x64),
    (4, 0x68),
    (5, 2),
    (5, 3),
    (5, 4),
    (5, 5),
    (5, 255),
    (0x2B, 2),
    (0x65, 2),
    (0x65, 255),
)
MISSING_CLASSES = (0, 6, 7, 8, 0x0F, 0x10, 0x2A, 0x2C, 0x64, 0x66, 0x99, 0xFF)


def unknown_objects(context: Context) -> None:
    """A class or an instance that does not exist: 16h, before everything else."""
    with context.session() as session:
        session.connect()
        for kind in MISSING_CLASSES:
            for service, rest in ((p.GET, "01"), (p.SET, "0100"), (p.RESET, "00"), (0x55, ""), (0x0E, "")):
                for instance in (0, 1):
                    data = session.body(service, kind, instance, rest)
                    session.expect("no such class", data, session.error(p.NO_OBJECT))
        for kind, instance in MISSING_INSTANCES:
            for service, rest in ((p.GET, "01"), (p.SET, "0100"), (p.RESET, "00"), (0x55, ""), (0x0E, "")):
                data = session.body(service, kind, instance, rest)
                session.expect("no such instance", data, session.error(p.NO_OBJECT))


def check_order(context: Context) -> None:
    """Class, instance, service, attribute, settable, length, range, state."""
    cases = (
        ("attribute before settable", "10650199", p.NO_ATTRIBUTE),
        ("settable before length", "10650172", p.NOT_SETTABLE),
        ("settable before length", "1065017200", p.NOT_SETTABLE),
        ("settable before length", "106501720000", p.NOT_SETTABLE),
        ("settable before length", "10650172000000", p.NOT_SETTABLE),
        ("settable", "1065010100", p.NOT_SETTABLE),
        ("class before service", "559901", p.NO_OBJECT),
        ("instance before service", "556502", p.NO_OBJECT),
        ("service before attribute", "55650199", p.NO_SERVICE),
        ("service before length", "556501", p.NO_SERVICE),
        ("length before range", "10650184FFFF", p.TOO_LONG),
        ("length before range", "10650184", p.TOO_SHORT),
        ("length before range", "10650171FF", p.TOO_SHORT),
        ("length before range", "10650171FFFFFF", p.TOO_LONG),
        ("length", "106501710A", p.TOO_SHORT),
        ("length", "10650185", p.TOO_SHORT),
        ("length", "1065018501", p.TOO_SHORT),
        ("length", "106501850100FF", p.TOO_LONG),
        ("range", "10650184FB", p.INVALID_VALUE),
        ("attribute byte missing", "0E6501", p.TOO_SHORT),
        ("attribute byte missing", "106501", p.TOO_SHORT),
        ("attribute byte missing", "0E0101", p.TOO_SHORT),
        ("attribute byte missing", "0E0301", p.TOO_SHORT),
        ("attribute byte missing", "0E0465", p.TOO_SHORT),
        ("attribute byte missing", "0E0501", p.TOO_SHORT),
        ("attribute", "0E650100", p.NO_ATTRIBUTE),
        ("attribute", "0E650163", p.NO_ATTRIBUTE),
        ("get with too much data", "0E65017200", p.TOO_LONG),
        ("get with too much data", "0E0301013F00", p.TOO_LONG),
        ("attribute before too much data", "0E65016300", p.NO_ATTRIBUTE),
        ("range of the MAC ID", "1003010140", p.INVALID_VALUE),
        ("range of the MAC ID", "10030101FF", p.INVALID_VALUE),
        ("MAC ID has one byte (T1)", "1003010105 00", p.TOO_LONG),
        ("MAC ID without value", "10030101", p.TOO_SHORT),
        ("range of the baud rate", "1003010203", p.INVALID_VALUE),
        ("range of the baud rate", "10030102FF", p.INVALID_VALUE),
        ("length of the baud rate", "100301020000", p.TOO_LONG),
        ("range of the bus-off interrupt", "1003010302", p.INVALID_VALUE),
        ("range of the bus-off interrupt", "10030103FF", p.INVALID_VALUE),
        ("allocation information", "10030105", p.NOT_SETTABLE),
        ("allocation information", "10030105010A", p.NOT_SETTABLE),
        ("no switches", "0E030106", p.NO_ATTRIBUTE),
        ("no switches", "1003010601", p.NO_ATTRIBUTE),
        ("assembly data", "1004650300", p.NOT_SETTABLE),
        ("assembly data", "10046703", p.NOT_SETTABLE),
        ("assembly data", "10046703000000", p.NOT_SETTABLE),
        ("reset type", "05010102", p.INVALID_PARAMETER),
        ("reset type", "05010103", p.INVALID_PARAMETER),
        ("reset type", "050101FF", p.INVALID_PARAMETER),
        ("reset with too much data", "0501010000", p.TOO_LONG),
        ("reset with too much data", "0501010200", p.TOO_LONG),
        ("reset of another object", "05030100", p.NO_SERVICE),
        ("reset of another object", "05650100", p.NO_SERVICE),
        ("reset of the class", "05010000", p.NO_SERVICE),
        ("get of a connection that is not allocated", "0E050201", p.NO_OBJECT),
        ("set of a connection that is not allocated", "100502090000", p.NO_OBJECT),
        ("set of a connection that is not allocated", "100504090000", p.NO_OBJECT),
    )
    with context.session() as session:
        session.connect()
        before = session.angles()
        for name, request, code in cases:
            request = request.replace(" ", "")
            session.expect(name, f"0A{request}", session.error(code))
            session.expect(f"{name}, XID", f"4A{request}", p.error(code, 0x4A))
        session.report.equal("nothing has changed", before, session.angles())
        session.report.equal("MAC ID, baud rate, interrupt", ("3F", "00", "00"), tuple(session.get(3, 1, n) for n in (1, 2, 3)))
        session.report.equal("allocation information", "010A", session.get(3, 1, 5))


def examples(context: Context) -> None:
    """The messages of the manual (6.1, 6.2) with MAC ID 3, and others."""
    store = context.store()
    with context.session(store=store) as session:
        session.connect()
        session.expect("MAC ID 3", "0A1003010103", "0A90")
        session.sleep(1.0)
    with context.session(store=store, mac=3, scene="tilt=12.34,-5.67") as session:
        report, long = session.report, session.subject
        report.equal(
            "identifiers",
            (0x41C, 0x41D, 0x41E, 0x41B, 0x3C3, 0x343),
            (*map(session.id, (4, 5, 6, 3)), p.poll_response(3), p.change_of_state(3)),
        )
        words = "D204C9FD" if not long.circular else "D2040000"
        session.expect_port("6.1: allocate", "0A4B0301030A", "0ACB00")
        session.expect("6.1: rate of explicit", "0A100501090000", "0A900000")
        session.expect("6.1: rate of poll", "0A100502090000", "0A900000")
        report.equal("6.1: poll", words, session.poll())
        session.expect_port("6.1: release", "0A4C030103", "0ACC")
        report.equal("6.1: poll after release", None, session.poll(timeout=0.1))
        session.expect_port("6.2: allocate", "0A4B0301510A", "0ACB00")
        session.expect("6.2: rate of explicit", "0A100501090000", "0A900000")
        session.expect("6.2: rate of COS", "0A100504090000", "0A900000")
        report.equal("6.2: COS message, once", [f"343#{words}"], [str(frame) for frame in session.produced(0.5)])
        session.expect_port("6.2: release", "0A4C030151", "0ACC")
        session.expect_port("owner", "0A4B0301030A", "0ACB00")
        session.expect("rate of poll", "0A10050209E803", "0A90E803")
        session.expect("slope, XID", "4A0E650172", f"4A8E{words[:4]}")
        session.expect("resolution", "0A0E650171", "0A8E0A00")
        session.expect("filter", "0A10650184FB", "0A9409FF")
        session.expect("no such attribute", "0A0E650163", "0A9414FF")
        session.expect_port("another master", "0B4B0301010B", "0B940C01")


def headers(context: Context) -> None:
    """XID is echoed, in successes and errors; each request is answered once; responses are not requests."""
    with context.session() as session:
        session.connect()
        for header in ("0A", "4A"):
            session.expect("get", f"{header}0E030101", f"{header}8E3F")
            session.expect("set", f"{header}1065018701", f"{header}90")
            session.expect("error", f"{header}0E030109", f"{header}94{p.NO_ATTRIBUTE}")
            session.expect("timer", f"{header}100501090000", f"{header}900000")
        session.quiet("each request is answered once")
        for service in (*range(0x80, 0x100, 7), 0x8E, 0x90, 0x94, 0xCB, 0xCC):
            session.ignored("response", (session.id(p.EXPLICIT), f"0A{service:02X}650187"))
        session.ignored("response without class", (session.id(p.EXPLICIT), "0A8E"))
        session.ignored("own response", (session.id(p.RESPONSE), "0A8E3F"))
        session.ignored("set as a response", (session.id(p.EXPLICIT), "0A9065018700"))
        session.report.equal("nothing has changed", 1, session.angle(0x87))
        for data in ("", "0A", "4A", "0A0E", "0A0E65", "0A10", "0A1065", "0A05", "0A0501", "0A7F", "0A4B03"):
            shown = f"{data[:2]}94{p.TOO_SHORT}"
            session.expect("too short for class and instance", data, "", shown)
        session.quiet("nothing follows")
        session.expect("still there", "0A0E030101", "0A8E3F")


def bursts(context: Context) -> None:
    """Requests one after the other without waiting: each is answered once, in order."""
    with context.session() as session:
        session.connect(3, poll=0)
        values = ("3F", "00", "00", "00")
        expected = []
        for number in range(300):
            header = 0x0A | (number & 1) << 6
            session.send(p.EXPLICIT, f"{header:02X}0E0301{1 + number % 4:02X}")
            expected.append(f"{header:02X}8E{values[number % 4]}")
        got = [text(frame) for frame in session.tester.collect_until_quiet(0.3)]
        session.report.equal("300 requests", expected, got)
        for _ in range(100):
            session.send(p.EXPLICIT, "0A0E030101")
            session.send(p.POLL)
            session.send(p.DUPLICATE, "00341201000000")
            session.send(p.PORT, "0B4B0301010B")
        frames = [frame.id for frame in session.tester.collect_until_quiet(0.3)]
        counts = {
            name: frames.count(number)
            for name, number in (
                ("response", session.id(p.RESPONSE)),
                ("check", session.id(p.DUPLICATE)),
                ("poll", p.poll_response(session.mac)),
            )
        }
        session.report.equal("100 of each request", {"response": 200, "check": 100, "poll": 100}, counts)


def services(context: Context) -> None:
    """Services 0..127 on each class and instance: 08h, but those that exist."""
    with context.session() as session:
        session.connect(0x13, poll=0, cos=0)
        session.produced(0.1)
        for kind, instance in (*EXISTING, (5, 2), (5, 4), (0x2B, 0), (0x2B, 1)):
            wrong = {}
            for service in range(128):
                if allowed := service_answers(kind, instance, service):
                    answer = session.ask(session.body(service, kind, instance))[2:]
                    if answer not in allowed:
                        wrong[f"{service:02X}h"] = answer
                if service % 16 == 15:
                    session.report.equal(
                        f"class {kind:02X}h instance {instance}: services {service - 15:02X}h..{service:02X}h", {}, wrong
                    )
                    wrong = {}


def service_answers(kind: int, instance: int, service: int) -> tuple[str, ...]:
    """What may answer a service without data; nothing for those that must not be tried."""
    if (kind, instance, service) == (p.IDENTITY, 1, p.RESET):
        return ()
    if (kind, instance) == (p.DEVICENET, 1) and service in (p.ALLOCATE, p.RELEASE):
        return ("94" + p.TOO_SHORT,)
    if service == p.GET:
        # A class without class attributes, and the message router, need not have the service.
        optional = instance == 0 or kind == p.ROUTER
        return ("94" + p.TOO_SHORT, "94" + p.NO_SERVICE) if optional else ("94" + p.TOO_SHORT,)
    if service == p.SET and instance:
        optional = kind in (p.IDENTITY, p.ROUTER)
        return ("94" + p.TOO_SHORT, "94" + p.NO_SERVICE) if optional else ("94" + p.TOO_SHORT,)
    return ("94" + p.NO_SERVICE,)


GROUPS = (unknown_objects, check_order, examples, headers, bursts, services)
