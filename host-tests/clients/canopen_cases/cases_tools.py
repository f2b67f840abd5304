"""Configuration tools: `tpdo.save()` of python-canopen, and the configuration that dcfgen writes (J25, J26, J30)."""

import canopen

from . import protocol as p
from .cases_master import mean_period, network
from .cases_pdo import PDOS, syncs
from .runner import Context

# Objects whose write does more than to change their value (J30).
COMMANDS = {(0x1003, 0), (0x1010, 1), (0x1011, 1), (0x2002, 0), (0x2042, 0), (0x2046, 0), (0x207F, 0), (0x3000, 0), (0x4004, 1)}


def tools(context: Context) -> None:
    """A TPDO as read is saved in each state; a changed one is in force; what dcfgen writes is accepted."""
    with context.session(real_time=True) as session, network(session.sensor.port) as (net, node):
        report = session.report
        for state in ("PRE-OPERATIONAL", "OPERATIONAL"):
            node.nmt.state = state
            for what in ("as delivered", "again"):
                report.equal(f"{state}: tpdo.read(), tpdo.save(), {what}", "saved", saved(node))
        for number in (1, 2):
            net.sync.transmit()
            report.verdict(node.tpdo[number].wait_for_reception(2) is not None, f"TPDO {number} at SYNC", "a PDO", "see left")
        changed(report, net, node)
    with context.session() as session:
        for state in (p.ENTER_PRE_OPERATIONAL, p.START):
            session.nmt(state)
            for index, sub, value in p.PDO_CONFIGURATION:
                code = session.abort_code(session.put, index, sub, value)
                session.report.equal(f"NMT command {state}, dcfgen: {index:04X}h:{sub:02X}h = {value:X}h", 0, code)
            got = {(index, sub): session.get(index, sub) for index, sub, _ in p.PDO_CONFIGURATION}
            wanted = {(index, sub): value for index, sub, value in p.PDO_CONFIGURATION}
            session.report.equal("the configuration is in force", wanted, got)
        session.report.equal("1801h type 2: PDOs for 6 SYNCs", 3, len(syncs(session, PDOS[1][0], 6)))


def saved(node: canopen.RemoteNode) -> str:
    """Reads and saves the parameters of all TPDOs."""
    try:
        node.tpdo.read()
        node.tpdo.save()
    except canopen.SdoAbortedError as error:
        return str(error)
    return "saved"


def changed(report, net: canopen.Network, node: canopen.RemoteNode) -> None:
    """The first TPDO with a timer and without remote frames, then disabled, then enabled."""
    first = node.tpdo[1]
    first.trans_type, first.event_timer, first.inhibit_time, first.rtr_allowed = 254, 20, 0, False
    first.save()
    report.within("changed TPDO: period in s", 0.015, 0.025, mean_period(first))
    report.equal("changed TPDO: COB-ID", p.NO_RTR | 0x18A, node.sdo[0x1800][1].raw)
    first.enabled = False
    first.save()
    report.equal("disabled TPDO: COB-ID", p.INVALID | p.NO_RTR | 0x18A, node.sdo[0x1800][1].raw)
    report.equal("disabled TPDO", None, first.wait_for_reception(0.3))
    first.enabled = True
    first.save()
    report.verdict(first.wait_for_reception(1) is not None, "enabled TPDO", "a PDO", "see left")
    first.trans_type = 1
    first.save()
    node.tpdo.read()
    report.equal("all as saved", (1, True, False, 2), (first.trans_type, first.enabled, first.rtr_allowed, len(first)))


def written_back(context: Context) -> None:
    """Every object that can be written accepts what is read from it, unless it is a command."""
    with context.session() as session:
        before = session.snapshot()
        for entry in p.OBJECTS:
            if entry.writable and (entry.index, entry.sub) not in COMMANDS:
                value = session.upload(entry.index, entry.sub)
                code = session.abort_code(session.download, entry.index, entry.sub, value)
                session.report.equal(f"{entry} written back", 0, code)
        session.report.equal("nothing has changed", before, session.snapshot())


GROUPS = (tools, written_back)
