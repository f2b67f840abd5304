"""What is kept over a power cycle: each accepted set, within 1 s of its answer (T4, T22); what is not kept."""

from . import protocol as p
from .runner import Context
from .session import Session

STORED = 1.0


def cycle(session: Session) -> None:
    """Cuts the power 1 s after the last answer, starts the sensor again and connects."""
    session.sleep(STORED)
    session.power_cycle()
    session.connect()


def kept(context: Context, changes: list[tuple[int, int]]) -> None:
    """Sets attributes of the angle object, each followed by a power cycle after which all must be as before it."""
    with context.session(store=context.store()) as session:
        session.connect()
        for attribute, value in changes:
            session.put_angle(attribute, value)
            before = session.angles()
            session.report.equal(f"{p.BY_ID[attribute]} = {value}: set", value, session.angle(attribute))
            cycle(session)
            session.report.equal(f"{p.BY_ID[attribute]} = {value}: kept with all others", before, session.angles())


def kept_long(context: Context) -> None:
    """The parameters of the long axis."""
    kept(context, [(0x73, 2), (0x74, 1500), (0x77, 321), (0x73, 3)])


def kept_lateral(context: Context) -> None:
    """The parameters of the lateral axis."""
    kept(context, [(0x7B, 3), (0x7C, 2500), (0x7F, 123), (0x7B, 1)])


def kept_others(context: Context) -> None:
    """Assemblies, terminal resistor, COS delta."""
    kept(context, [(0x81, 101), (0x82, 102), (0x87, 1), (0x88, 150)])


def kept_filters(context: Context) -> None:
    """Filters and resolution."""
    kept(context, [(0x84, 250), (0x85, 1000), (0x84, 0), (0x71, 1000)])


def kept_offsets(context: Context) -> None:
    """The offsets that presets make; preset enable is 0 after power-up (T13)."""
    with context.session(store=context.store()) as session:
        session.connect()
        report = session.report
        for mode, preset, enable, offset, slope in ((0x73, 0x74, 0x75, 0x76, 0x72), (0x7B, 0x7C, 0x7D, 0x7E, 0x7A)):
            session.put_angle(mode, 2)
            session.put_angle(preset, 4000)
            session.put_angle(enable, 1)
            before = (session.angle(offset), session.angle(slope))
            report.equal(f"{p.BY_ID[preset]}: slope", 4000, before[1])
            cycle(session)
            report.equal(f"{p.BY_ID[preset]}: offset and slope are kept", before, (session.angle(offset), session.angle(slope)))
            report.equal(f"{p.BY_ID[enable]}: 0 after power-up", 0, session.angle(enable))
            session.put_angle(preset, 2000)
            session.put_angle(enable, 1)
            report.equal(f"{p.BY_ID[enable]}: one write of 1 triggers", 2000, session.angle(slope))


def kept_resolution(context: Context) -> None:
    """A change of the resolution keeps the converted values too; a second change before the first is stored."""
    with context.session(store=context.store()) as session:
        session.connect()
        for attribute, value in ((0x74, 1235), (0x77, 1234), (0x88, 45), (0x71, 100)):
            session.put_angle(attribute, value)
        cycle(session)
        got = tuple(session.angle(attribute) for attribute in (0x71, 0x74, 0x77, 0x88))
        session.report.equal("all changes within 1 s are kept, converted", (100, 124, 123, 5), got)
        for size in range(0, 250, 5):
            session.put_angle(0x84, size)
        cycle(session)
        session.report.equal("the last of 50 quick changes is kept", 245, session.angle(0x84))


def kept_bus(context: Context) -> None:
    """Bus-off interrupt and baud rate are kept; connections and the acknowledge handler are not."""
    with context.session(store=context.store()) as session:
        session.connect(0x13, poll=0, cos=0)
        report = session.report
        session.put(p.DEVICENET, 1, 3, "01")
        session.put(p.HANDLER, 1, 1, "6400")
        session.put(p.HANDLER, 1, 2, "05")
        cycle(session)
        report.equal("bus-off interrupt is kept", "01", session.get(p.DEVICENET, 1, 3))
        report.equal("allocation is not kept", "010A", session.get(p.DEVICENET, 1, 5))
        report.equal("bus-off counter", "00", session.get(p.DEVICENET, 1, 4))
        session.ask(f"{session.master:02X}4B0301100A", p.PORT)
        report.equal("acknowledge handler is not kept", ("1000", "01"), tuple(session.get(p.HANDLER, 1, n) for n in (1, 2)))
        report.equal("rates are not kept", 0, session.number(p.CONNECTION, p.C_COS, 9))
        session.put(p.DEVICENET, 1, 3, "00")
        cycle(session)
        report.equal("bus-off interrupt 0 is kept", "00", session.get(p.DEVICENET, 1, 3))


def answers_while_storing(context: Context) -> None:
    """Polls and requests are answered at once while values are stored (T4)."""
    with context.session(store=context.store()) as session:
        session.connect(3, poll=0)
        slowest, missing = 0.0, 0
        end, size = session.now() + 4.0, 0
        while session.now() < end:
            if size % 40 == 0:
                session.put_angle(0x84, size % 250)
            started = session.now()
            missing += session.poll() is None
            slowest = max(slowest, session.now() - started)
            size += 1
        session.report.equal("polls without an answer", 0, missing)
        session.report.within("slowest answer in s", 0, 0.2, slowest)


def refusals_are_not_kept(context: Context) -> None:
    """A refused set changes nothing in the memory either; without a store, nothing is kept."""
    with context.session(store=context.store()) as session:
        session.connect()
        session.put_angle(0x84, 77)
        session.set_angle(0x84, 251)
        session.set_angle(0x71, 11)
        session.set(p.DEVICENET, 1, 1, "40")
        session.set(p.DEVICENET, 1, 2, "03")
        before = session.angles()
        cycle(session)
        session.report.equal("as before the refusals", before, session.angles())
        session.report.equal("MAC ID and baud rate", ("3F", "00"), (session.get(3, 1, 1), session.get(3, 1, 2)))
        session.power_cycle(store=context.store("other"))
        session.connect()
        session.report.equal("another memory: factory value", 100, session.angle(0x84))


GROUPS = (
    kept_long,
    kept_lateral,
    kept_others,
    kept_filters,
    kept_offsets,
    kept_resolution,
    kept_bus,
    answers_while_storing,
    refusals_are_not_kept,
)
