"""IMS360: python-canopen as the master: LSS, SDO block transfer, `tpdo.save()` with another mapping, EMCY, heartbeat."""

import contextlib
import time

import canopen
from canopen import objectdictionary as od
from canopen.lss import LssError

from . import protocol as p
from .cases_master import TYPES, mean_period
from .ims360_objects import IMS360, LATERAL, LONGITUDINAL, MAPPABLE, NODE, OBJECTS
from .runner import Context

KINDS = TYPES | {(1, True): od.INTEGER8}


def dictionary(node: int) -> canopen.ObjectDictionary:
    """The objects of the manual in the form of python-canopen."""
    found = canopen.ObjectDictionary()
    found.node_id = node
    for index in sorted({one.index for one in OBJECTS}):
        entries = [variable(one) for one in OBJECTS if one.index == index]
        if len(entries) == 1 and entries[0].subindex == 0:
            found.add_object(entries[0])
            continue
        record = od.ODRecord(f"{index:04X}", index)
        for one in entries:
            record.add_member(one)
        found.add_object(record)
    return found


def variable(one: p.Object) -> od.ODVariable:
    """One entry."""
    made = od.ODVariable(str(one), one.index, one.sub)
    made.data_type = KINDS[one.size, one.signed]
    made.access_type = "wo" if not one.readable else "rw" if one.writable else "ro"
    made.pdo_mappable = (one.index, one.sub) in MAPPABLE
    return made


@contextlib.contextmanager
def network(port: int, node: int = NODE):
    """A network of python-canopen with the sensor as its node."""
    net = canopen.Network()
    net.connect(interface="slcan", channel=f"socket://127.0.0.1:{port}", sleep_after_open=0)
    try:
        yield net, net.add_node(node, dictionary(node))
    finally:
        with contextlib.suppress(OSError):
            net.disconnect()


def mapping_by_master(context: Context) -> None:
    """`tpdo.save()` with another mapping, in force in both states, and after store and restart."""
    store = context.store()
    with context.session(scene="tilt=12.34,-5.67", store=store, real_time=True) as session, network(session.sensor.port) as (net, node):
        report = session.report
        time.sleep(1.5)
        node.tpdo.read()
        report.equal("TPDO 1", (0x1B2, True, [LONGITUDINAL, LATERAL]), (node.tpdo[1].cob_id, node.tpdo[1].enabled, mapped(node, 1)))
        report.equal("TPDO 2", (0x2B2, False, []), (node.tpdo[2].cob_id, node.tpdo[2].enabled, mapped(node, 2)))
        node.tpdo.save()
        for state in ("PRE-OPERATIONAL", "OPERATIONAL"):
            node.nmt.state = state
            pdo = node.tpdo[2]
            pdo.clear()
            for index, sub in ((0x6120, 0), (0x3000, 1), (0x6511, 0)):
                pdo.add_variable(index, sub)
            pdo.enabled, pdo.trans_type, pdo.event_timer, pdo.inhibit_time = True, 254, 50, 0
            pdo.save()
            report.equal(f"{state}: mapped", [LATERAL, 0x30000108, 0x65110008], mapped(node, 2))
        arrived = pdo.wait_for_reception(2)
        report.equal("TPDO 2 arrives", -567, pdo[0].raw if arrived else None)
        report.within("TPDO 2: period in s", 0.045, 0.055, mean_period(pdo))
        node.sdo[0x1010][1].raw = p.decode(p.SAVE)
    with context.session(scene="tilt=12.34,-5.67", store=store, real_time=True) as session, network(session.sensor.port) as (net, node):
        node.tpdo.read()
        session.report.equal("stored: TPDO 2", (True, [LATERAL, 0x30000108, 0x65110008]), (node.tpdo[2].enabled, mapped(node, 2)))


def mapped(node: canopen.RemoteNode, number: int) -> list[int]:
    """The mapping entries of a TPDO as SDO reads them."""
    record = node.sdo[0x1A00 + number - 1]
    return [record[sub].raw for sub in range(1, record[0].raw + 1)]


def blocks_by_master(context: Context) -> None:
    """Block upload and block download."""
    with context.session(real_time=True) as session, network(session.sensor.port) as (_, node):
        report = session.report
        for index, sub in ((0x1008, 0), (0x100A, 0), (0x2000, 1), (0x2000, 3), (0x1018, 4)):
            with node.sdo.open(index, sub, "rb", block_transfer=True) as stream:
                value = stream.read()
            report.equal(f"{index:04X}h:{sub:02X}h: block upload", node.sdo.upload(index, sub), value)
        for index, sub, value in ((0x1017, 0, p.encode(3000, 2)), (0x3210, 0, p.encode(-5, 4))):
            with node.sdo.open(index, sub, "wb", size=len(value), block_transfer=True) as stream:
                stream.write(value)
            report.equal(f"{index:04X}h:{sub:02X}h: block download", value, node.sdo.upload(index, sub))


def lss_by_master(context: Context) -> None:
    """The services of `network.lss`, with fastscan, on a node that gets its node-ID by LSS."""
    with context.session(store=context.store(), real_time=True) as session, network(session.sensor.port) as (net, node):
        report, lss = session.report, net.lss
        own = [node.sdo[0x1018][sub].raw for sub in range(1, 5)]
        lss.send_switch_state_global(lss.CONFIGURATION_STATE)
        report.equal("inquire node-ID", NODE, lss.inquire_node_id())
        for command, part in zip((0x5A, 0x5B, 0x5C, 0x5D), own, strict=True):
            report.equal(f"inquire {command:02X}h", part, lss.inquire_lss_address(command))
        lss.send_switch_state_global(lss.WAITING_STATE)
        try:
            lss.inquire_node_id()
            report.verdict(False, "waiting", "no answer", "an answer")
        except LssError as error:
            report.equal("waiting", "No LSS response received", str(error))
        report.equal("switch state selective", True, lss.send_switch_state_selective(*own))
        for bad in (0, 127):
            try:
                lss.configure_node_id(bad)
                report.verdict(False, f"node-ID {bad}", "error 1", "accepted")
            except LssError as error:
                report.equal(f"node-ID {bad}", "LSS Error: 1", str(error))
        lss.configure_bit_timing(2)
        lss.configure_bit_timing(4)
        lss.configure_node_id(255)
        lss.send_switch_state_global(lss.WAITING_STATE)
        node.nmt.send_command(0x82)
        time.sleep(0.3)
        report.equal("fastscan", (True, own), tuple(lss.fast_scan()))
        lss.configure_node_id(77)
        lss.store_configuration()
        lss.send_switch_state_global(lss.WAITING_STATE)
        session.node = 77
        report.equal("boot-up of node 77", True, session.wait_boot_up())
        new = net.add_node(77, dictionary(77))
        report.equal("SDO of node 77", IMS360.product.upper(), new.sdo[0x1008].raw)
    with context.session(store=context.store(), node=77) as session:
        session.reads("stored node-ID", 0x2002, 0, 77)


def events_by_master(context: Context) -> None:
    """Heartbeat, EMCY and the boot-up as python-canopen sees them."""
    with context.session(scene="tilt=10,0", real_time=True) as session, network(session.sensor.port) as (net, node):
        report = session.report
        time.sleep(1.5)
        net.scanner.search()
        time.sleep(0.5)
        report.equal("the scanner finds the sensor", [NODE], net.scanner.nodes)
        node.sdo[0x1017].raw = 50
        report.equal("heartbeat", "PRE-OPERATIONAL", node.nmt.wait_for_heartbeat(2))
        node.nmt.state = "OPERATIONAL"
        time.sleep(0.15)
        report.equal("heartbeat after start", "OPERATIONAL", node.nmt.wait_for_heartbeat(2))
        node.sdo[0x3210].raw = 8500
        time.sleep(0.5)
        report.equal("EMCY", [0x5010], [entry.code for entry in node.emcy.active])
        node.sdo[0x3210].raw = 0
        time.sleep(0.5)
        report.equal("EMCY reset", [], [entry.code for entry in node.emcy.active])
        node.sdo[0x2010][1].raw = 1
        node.nmt.wait_for_bootup(5)
        report.equal("2010h:01h: boot-up", "PRE-OPERATIONAL", node.nmt.state)
        report.equal("2010h:01h: as stored", 0, node.sdo[0x1017].raw)


GROUPS = (mapping_by_master, blocks_by_master, lss_by_master, events_by_master)
