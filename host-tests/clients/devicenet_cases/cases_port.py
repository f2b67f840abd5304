"""The unconnected port: allocate and release with every refusal in its order, and the rules of the owner."""

from . import protocol as p
from .runner import Context
from .session import Session

OK = "0ACB00"
RELEASED = "0ACC"


def allocation(session: Session) -> str:
    """The allocation information."""
    return session.get(p.DEVICENET, 1, 5)


def choices_when_free(context: Context) -> None:
    """Each of the 256 choices while nothing is allocated."""
    with context.session() as session:
        for choice in range(256):
            expected = free_choice(choice)
            session.expect_port(f"choice {choice:02X}h", f"0A4B0301{choice:02X}0A", expected)
            if expected == OK:
                session.report.equal(f"choice {choice:02X}h: allocation", f"{choice:02X}0A", allocation(session))
                session.expect_port(f"choice {choice:02X}h: release", f"0A4C0301{choice:02X}", RELEASED)
                session.expect_port(f"choice {choice:02X}h: nothing is left", "0A4C030101", p.error(p.CHOICE_STATE))


def free_choice(choice: int) -> str:
    """The answer to an allocation while nothing is allocated."""
    if choice == 0:
        return p.error(p.CHOICE_INVALID)
    if choice & 0x40 and not choice & 0x30:
        return p.error(p.CHOICE_INVALID)
    if choice & 0x8C:
        return p.error(p.CHOICE_UNSUPPORTED)
    if choice & 0x30 == 0x30 or not choice & 1:
        return p.error(p.CHOICE_INVALID)
    return OK


def choices_when_allocated(context: Context) -> None:
    """Each choice of the owner while one connection set is allocated; a refused request allocates nothing."""
    with context.session() as session:
        for held in (0x01, 0x03, 0x11, 0x23, 0x51):
            for choice in (0x00, 0x01, 0x02, 0x03, 0x04, 0x06, 0x08, 0x10, 0x12, 0x20, 0x22, 0x30, 0x40, 0x50, 0x52, 0x60, 0x82):
                session.connect(held)
                expected = held_choice(choice, held)
                session.expect_port(f"{held:02X}h held, choice {choice:02X}h", f"0A4B0301{choice:02X}0A", expected)
                after = held | choice if expected == OK else held
                session.report.equal(f"{held:02X}h held, after choice {choice:02X}h", f"{after:02X}0A", allocation(session))
                session.release(after)


def held_choice(choice: int, held: int) -> str:
    """The answer to an allocation by the owner."""
    refused = free_choice(choice | 1 if choice else 0)
    if refused != OK:
        return refused
    # COS and cyclic are one connection.
    instances = lambda bits: bits & 3 | (0x30 if bits & 0x30 else 0)  # noqa: E731
    return p.error(p.CHOICE_STATE) if instances(choice) & instances(held) else OK


def allocate_order(context: Context) -> None:
    """The owner rule comes before every other refusal; it compares the allocator byte."""
    with context.session() as session:
        session.connect(3)
        for choice in (0x00, 0x01, 0x02, 0x04, 0x08, 0x0A, 0x10, 0x30, 0x40, 0x80, 0xFF):
            session.expect_port("another master", f"0B4B0301{choice:02X}0B", p.error(p.PORT_BUSY, 0x0B))
        session.expect_port("another master in the allocator byte", "0A4B0301100B", p.error(p.PORT_BUSY))
        session.expect_port("the owner in the allocator byte", "0B4B0301010A", p.error(p.CHOICE_STATE, 0x0B))
        session.report.equal("nothing has changed", "030A", allocation(session))
        session.expect("allocate on the explicit connection", "0A4B0301100A", OK)
        session.report.equal("allocated on the explicit connection", "130A", allocation(session))
        session.expect("release on the explicit connection", "0A4C030110", RELEASED)
        session.report.equal("released on the explicit connection", "030A", allocation(session))
        session.expect("refused on the explicit connection", "0A4B0301040A", p.error(p.CHOICE_UNSUPPORTED))
        session.ignored("allocate on 4 by another master", (session.id(p.EXPLICIT), "0B4B0301100B"))
        session.ignored("release on 4 by another master", (session.id(p.EXPLICIT), "0B4C030103"))
        session.expect("release of all on the explicit connection", "0A4C030103", RELEASED)
        session.ignored("explicit connection is gone", (session.id(p.EXPLICIT), "0A0E010101"))


def releases(context: Context) -> None:
    """Each choice of a release, and what it releases."""
    with context.session() as session:
        port = session.expect_port
        for choice in range(256):
            # Bit 40 is masked; what then remains of 40 alone is not told.
            expected = p.CHOICE_INVALID if choice == 0 else p.CHOICE_UNSUPPORTED if choice & 0x8C else p.CHOICE_STATE
            others = (p.error(p.CHOICE_INVALID),) if choice == 0x40 else ()
            port(f"free, release {choice:02X}h", f"0A4C0301{choice:02X}", p.error(expected), *others)
        for held in (0x03, 0x13, 0x21, 0x51):
            session.connect(held)
            for choice in (0x00, 0x04, 0x05, 0x08, 0x80, 0x81):
                code = p.CHOICE_UNSUPPORTED if choice else p.CHOICE_INVALID
                port(f"{held:02X}h held, release {choice:02X}h", f"0A4C0301{choice:02X}", p.error(code))
            for choice in (0x01, 0x03, held, 0x51):
                port(f"{held:02X}h held, not the owner", f"0B4C0301{choice:02X}", p.error(p.PORT_BUSY, 0x0B))
            missing = ~held & 0x02 or ~held & 0x10
            if missing:
                port(f"{held:02X}h held, not allocated", f"0A4C0301{missing:02X}", p.error(p.CHOICE_STATE))
                port(f"{held:02X}h held, one not allocated", f"0A4C0301{missing | 1:02X}", p.error(p.CHOICE_STATE))
            session.report.equal(f"{held:02X}h held, after the refusals", f"{held:02X}0A", allocation(session))
            port(f"{held:02X}h: release", f"0A4C0301{held:02X}", RELEASED)


def released_one_by_one(context: Context) -> None:
    """Releasing part of the set; when nothing is established, everything is released."""
    with context.session() as session:
        report, port = session.report, session.expect_port
        session.connect(0x13, poll=0, cos=0)
        port("release of poll", "0A4C030102", RELEASED)
        report.equal("poll released: allocation", "110A", allocation(session))
        report.equal("poll released: poll", None, session.poll(timeout=0.1))
        report.equal("poll released: state", "?9416FF", session.get(p.CONNECTION, p.C_POLL, 1))
        port("poll again", "0A4B0301020A", OK)
        report.equal("poll again: allocation", "130A", allocation(session))
        report.equal("poll again: configuring", p.CONFIGURING, session.state(p.C_POLL))
        session.rate(p.C_POLL, 0)
        port("release of explicit", "0A4C030101", RELEASED)
        session.ignored("explicit released", (session.id(p.EXPLICIT), "0A0E010101"))
        report.equal("explicit released: poll goes on", True, session.poll() is not None)
        port("explicit released: another master", "0B4B0301010B", p.error(p.PORT_BUSY, 0x0B))
        port("explicit neither requested nor held", "0A4B0301200A", p.error(p.CHOICE_INVALID))
        port("explicit again", "0A4B0301010A", OK)
        report.equal("explicit again: allocation", "130A", allocation(session))
        report.equal("explicit again: new connection", "C409", session.get(p.CONNECTION, 1, 9))
        session.release(0x13)
        session.connect(3)
        port("release of explicit, poll is only configuring", "0A4C030101", RELEASED)
        port("all is released: another master", "0B4B0301030B", "0BCB00")
        port("release by the new owner", "0B4C030103", "0BCC")
        session.connect(0x51, cos=0)
        port("release of COS with the choice of the manual", "0A4C030151", RELEASED)
        session.connect(0x51, cos=0)
        port("release of COS without bit 40", "0A4C030111", RELEASED)
        port("nothing is left", "0A4C030101", p.error(p.CHOICE_STATE))


def owners(context: Context) -> None:
    """Requests, fragments and acknowledges of a MAC ID that is not the owner are dropped."""
    with context.session() as session:
        explicit = session.id(p.EXPLICIT)
        session.ignored("no allocation: explicit", (explicit, "0A0E010101"))
        session.ignored("no allocation: poll", (session.id(p.POLL), ""))
        session.connect()
        for master in (0, 9, 0x0B, 0x2A, 0x3F):
            session.ignored("not the owner", (explicit, f"{master:02X}0E010101"))
            session.ignored("not the owner, with XID", (explicit, f"{master | 0x40:02X}0E010101"))
            session.ignored("not the owner sets", (explicit, f"{master:02X}1065018700"))
        session.report.equal("nothing has changed", 0, session.angle(0x87))
        session.release(1)
        for master in (0, 1, 0x20, 0x3E, 0x3F):
            session.master = master
            session.expect_port(f"master {master}: allocate", f"{master:02X}4B030101{master:02X}", f"{master:02X}CB00")
            session.report.equal(f"master {master}: allocation", f"01{master:02X}", allocation(session))
            session.expect(f"master {master}: header", f"{master:02X}0E010101", f"{master:02X}8E6201")
            session.expect_port(f"master {master}: XID", f"{master | 0x40:02X}4C030101", f"{master | 0x40:02X}CC")


def other_requests(context: Context) -> None:
    """The port serves allocate and release of 3/1 only; frames of a wrong length."""
    with context.session() as session:
        for service in range(128):
            if service not in (p.ALLOCATE, p.RELEASE):
                session.expect_port("service", f"0A{service:02X}030101", p.error(p.PORT_UNSUPPORTED_SERVICE))
        for data in ("0A0E010101", "0A05010100", "0A10030101", "0A0E650172", "4A0E010101"):
            header = data[:2]
            session.expect_port("explicit request", data, f"{header}94{p.PORT_UNSUPPORTED_SERVICE}")
        for kind, instance in ((1, 1), (3, 0), (3, 2), (5, 1), (0x65, 1)):
            for service, rest in ((p.ALLOCATE, "010A"), (p.RELEASE, "01")):
                data = f"0A{service:02X}{kind:02X}{instance:02X}{rest}"
                session.expect_port(
                    "not object 3/1", data, p.error(p.PORT_UNSUPPORTED_SERVICE), p.error(p.NO_OBJECT), p.error(p.NO_SERVICE)
                )
        for data in ("0ACB00", "0ACC", "0A940B02", "0A8E03013F"):
            session.ignored("response", (session.id(p.PORT), data))
        session.expect_port("nothing is allocated", "0A4C030101", p.error(p.CHOICE_STATE))
        for data in ("", "0A", "0A4B", "0A4B03", "0A4C03"):
            session.expect_port(
                "too short for class and instance", data, "", p.error(p.TOO_SHORT), p.error(p.PORT_UNSUPPORTED_SERVICE)
            )
        for data in ("0A4B0301", "0A4B030101", "0A4C0301"):
            session.expect_port("too short", data, p.error(p.TOO_SHORT))
        for data in ("0A4B0301010A00", "0A4C03010100"):
            session.expect_port("too long", data, p.error(p.TOO_LONG))
        session.expect_port("nothing is allocated now", "0A4C030101", p.error(p.CHOICE_STATE))
        session.expect_port("XID is echoed", "4A4B0301030A", "4ACB00")
        session.expect_port("XID is echoed in an error", "4A4B0301030A", "4A940B02")


GROUPS = (
    choices_when_free,
    choices_when_allocated,
    allocate_order,
    releases,
    released_one_by_one,
    owners,
    other_requests,
)
