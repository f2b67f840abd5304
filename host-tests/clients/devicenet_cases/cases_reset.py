"""Reset service, change of the MAC ID and of the baud rate (T23, T24)."""

from . import protocol as p
from .cases_network import CHECK_PAUSE, FOREIGN, duplicates, is_faulted
from .runner import Context
from .session import Session, text


def restarted(session: Session, name: str, since: float, limit: float = 3.0) -> None:
    """Checks the duplicate MAC ID check that follows, and that nothing is answered until the sensor is on-line."""
    report = session.report
    found = duplicates(session, limit + 1.5, 2)
    report.equal(f"{name}: number of requests", 2, len(found))
    if len(found) == 2:
        report.within(f"{name}: first request after s", 0, limit, found[0].at - since)
        report.within(f"{name}: second request after s", 0.97, 1.06, found[1].at - found[0].at)
        report.equal(f"{name}: is a request", ("00", "00"), (text(found[0])[:2], text(found[1])[:2]))
        online = session.wait_online(3, 0.02)
        report.within(f"{name}: on-line after s", 0.97, 1.1, (online or 0) - found[1].at)


def reset_types(context: Context) -> None:
    """Type 0 and no data: as power off and on. Other types are refused."""
    with context.session(store=context.store()) as session:
        report = session.report
        session.connect(0x13, poll=0, cos=0)
        session.put_angle(0x84, 33)
        for kind in (*range(2, 256, 23), 2, 255):
            session.expect("reset type", f"0A050101{kind:02X}", session.error(p.INVALID_PARAMETER))
        report.equal("refused types do nothing", True, session.poll() is not None)
        for name, data in (("type 0", "0A05010100"), ("no data", "0A050101"), ("type 0, XID", "4A05010100")):
            session.put_angle(0x75, 1)
            session.expect(name, data, f"{data[:2]}85")
            since = session.now()
            session.send(p.POLL)
            session.send(p.EXPLICIT, "0A0E010101")
            restarted(session, name, since)
            others = [str(frame) for frame in session.others if frame.id != p.change_of_state(session.mac)]
            report.equal(f"{name}: silent after the reply", [], others)
            report.equal(f"{name}: poll is gone", None, session.poll(timeout=0.1))
            session.expect_port(f"{name}: nothing is allocated", "0A4C030101", p.error(p.CHOICE_STATE))
            session.connect(3, poll=0)
            report.equal(f"{name}: parameters are kept", 33, session.angle(0x84))
            report.equal(f"{name}: preset enable", 0, session.angle(0x75))


def factory_reset(context: Context) -> None:
    """Type 1: MAC ID 63, 125 kbit/s, all parameters to their factory values, stored."""
    store = context.store()
    with context.session(store=store) as session:
        session.connect()
        session.put(p.DEVICENET, 1, 1, "07")
        session.mac = 7
        session.report.equal("MAC ID 7: on-line", True, session.wait_online() is not None)
        session.connect()
        session.put(p.DEVICENET, 1, 3, "01")
        values = {
            0x71: 100,
            0x73: 3,
            0x74: 11,
            0x77: 12,
            0x7B: 2,
            0x7C: 13,
            0x7F: 14,
            0x81: 101,
            0x82: 102,
            0x84: 9,
            0x85: 8,
            0x87: 1,
            0x88: 7,
        }
        for attribute, value in values.items():
            session.put_angle(attribute, value)
        session.put_angle(0x75, 1)
        session.put_angle(0x7D, 1)
        session.expect("type 1", "0A05010101", "0A85")
        since = session.now()
        session.mac = p.FACTORY_MAC
        restarted(session, "type 1", since)
        is_factory(session, "type 1")
        session.sleep(1.0)
        session.power_cycle()
        is_factory(session, "type 1, then a power cycle")


def is_factory(session: Session, name: str) -> None:
    """Checks that all parameters have their factory values."""
    session.connect()
    expected = {str(entry): entry.factory for entry in p.ATTRIBUTES if entry.factory is not None}
    session.report.equal(f"{name}: angle object", expected, session.angles())
    session.report.equal(
        f"{name}: MAC ID, baud rate, interrupt", ("3F", "00", "00"), tuple(session.get(3, 1, n) for n in (1, 2, 3))
    )


def mac_change(context: Context) -> None:
    """Answered on the old identifier, then the check with the new MAC ID; kept over a power cycle."""
    with context.session(store=context.store()) as session:
        report = session.report
        for mac in (5, 0, 62, 3):
            old = session.mac
            session.connect(0x13, poll=0, cos=0)
            session.expect(f"MAC ID {mac}", f"0A10030101{mac:02X}", "0A90")
            since = session.now()
            session.others.clear()
            session.tester.send(p.group2(p.EXPLICIT, old), bytes.fromhex("0A0E010101"))
            session.tester.send(p.group2(p.POLL, old))
            session.mac = mac
            restarted(session, f"MAC ID {mac}", since)
            report.equal(f"MAC ID {mac}: silent in between", [], [str(frame) for frame in session.others])
            session.ignored("old MAC ID", (p.group2(p.PORT, old), "0A4B0301030A"))
            session.ignored("old explicit connection", (session.id(p.EXPLICIT), "0A0E010101"))
            session.ignored("old poll connection", (session.id(p.POLL), ""))
            session.connect(3, poll=0)
            report.equal(f"MAC ID {mac}: read back", f"{mac:02X}", session.get(3, 1, 1))
            report.equal(f"MAC ID {mac}: poll", True, session.poll() is not None)
            ids = (p.encode(session.id(p.RESPONSE), 2), p.encode(session.id(p.EXPLICIT), 2))
            report.equal(f"MAC ID {mac}: identifiers of connection 1", ids, (session.get(5, 1, 4), session.get(5, 1, 5)))
            session.release(3)
        session.sleep(1.0)
        session.power_cycle()
        session.connect()
        report.equal("kept over a power cycle", "03", session.get(3, 1, 1))


def mac_change_fails(context: Context) -> None:
    """The check with the new MAC ID fails: faulted, with the new MAC ID stored."""
    for number, (wait, first_byte) in enumerate(((1, "80"), (2, "00"))):
        store = context.store(f"store{number}")
        with context.session(store=store) as session:
            session.connect()
            session.put(p.DEVICENET, 1, 1, "09")
            session.mac = 9
            found = duplicates(session, 4, wait)
            session.sleep(0.3)
            session.send(p.DUPLICATE, first_byte + FOREIGN)
            session.report.equal(f"conflict in wait {wait}: requests", wait, len(found))
            session.report.equal(f"conflict in wait {wait}: nothing follows", [], session.collect(CHECK_PAUSE + 0.2))
            is_faulted(session, f"conflict in wait {wait}")
            session.mac = p.FACTORY_MAC
            is_faulted(session, f"conflict in wait {wait}: the old MAC ID")
            session.mac = 9
            session.power_cycle()
            session.connect()
            session.report.equal(f"conflict in wait {wait}: new MAC ID after a power cycle", "09", session.get(3, 1, 1))


def baud_change(context: Context) -> None:
    """The baud rate acts after a power cycle or a reset, not before."""
    store = context.store()
    with context.session(store=store, bus_rate=125) as session:
        report = session.report
        session.connect(3, poll=0)
        session.expect("500 kbit/s", "0A1003010202", "0A90")
        report.equal("read back", "02", session.get(3, 1, 2))
        report.equal("not yet in force", True, session.poll() is not None)
        session.sleep(1.0)
        for rate in (500, 250):
            session.power_cycle(bus_rate=rate, online=False)
            online = session.wait_online(4) is not None
            report.equal(f"stored 500 kbit/s, bus at {rate} kbit/s: on-line", rate == 500, online)
        session.power_cycle(bus_rate=500)
        session.connect()
        session.expect("250 kbit/s", "0A1003010201", "0A90")
        session.expect("reset", "0A05010100", "0A85")
        session.sleep(0.05)
        report.equal("after the reset, the bus at 500 kbit/s", None, session.wait_online(4))
        session.power_cycle(bus_rate=250)
        session.connect()
        report.equal("250 kbit/s", "01", session.get(3, 1, 2))
        session.expect("factory reset", "0A05010101", "0A85")
        session.sleep(1.0)
        session.power_cycle(bus_rate=125)
        session.connect()
        report.equal("factory rate", "00", session.get(3, 1, 2))


def reset_when_timed_out(context: Context) -> None:
    """A reset over the explicit connection of a master that then has another node: no allocation is left."""
    with context.session() as session:
        session.connect(0x63, poll=100, cos=50)
        session.expect("reset", "0A05010100", "0A85")
        session.sleep(0.05)
        session.wait_online()
        session.others.clear()
        session.report.equal("no cyclic messages", [], [str(frame) for frame in session.produced(0.4)])
        session.expect_port("free for another master", "0B4B0301030B", "0BCB00")


GROUPS = (reset_types, factory_reset, mac_change, mac_change_fails, baud_change, reset_when_timed_out)
