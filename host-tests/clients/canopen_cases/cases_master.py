"""python-canopen as the master, and a session decoded by tshark."""

import contextlib
import json
import os
import shutil
import subprocess
import threading
import time

import canopen
from canopen import objectdictionary as od

from . import protocol as p
from . import scenes
from .runner import Context

TYPES = {(1, False): od.UNSIGNED8, (2, False): od.UNSIGNED16, (4, False): od.UNSIGNED32,
         (2, True): od.INTEGER16, (4, True): od.INTEGER32, (None, False): od.VISIBLE_STRING}  # fmt: skip


def dictionary() -> canopen.ObjectDictionary:
    """The tables of the manual in the form of python-canopen."""
    found = canopen.ObjectDictionary()
    found.node_id = p.FACTORY_NODE_ID
    subs: dict[int, list[p.Object]] = {}
    for entry in p.OBJECTS:
        subs.setdefault(entry.index, []).append(entry)
    for index, entries in subs.items():
        variables = [variable(entry) for entry in entries]
        if len(variables) == 1:
            found.add_object(variables[0])
            continue
        record = od.ODRecord(f"{index:04X}", index)
        for one in variables:
            record.add_member(one)
        found.add_object(record)
    return found


def variable(entry: p.Object) -> od.ODVariable:
    """One entry."""
    made = od.ODVariable(str(entry), entry.index, entry.sub)
    made.data_type = TYPES[entry.size, entry.signed]
    made.access_type = "rw" if entry.writable else "ro"
    made.pdo_mappable = entry.index in (0x6010, 0x6020, 0x6110, 0x6120)
    return made


@contextlib.contextmanager
def network(port: int):
    """A network of python-canopen with the sensor as its node."""
    net = canopen.Network()
    net.connect(interface="slcan", channel=f"socket://127.0.0.1:{port}", sleep_after_open=0)
    try:
        yield net, net.add_node(p.FACTORY_NODE_ID, dictionary())
    finally:
        with contextlib.suppress(OSError):
            net.disconnect()


def master(context: Context) -> None:
    """NMT, SDO, PDO, heartbeat, emergency and scanner of python-canopen."""
    scene = scenes.steps(context.folder / "range.csv", [(0.0, 10.0), (6.0, 60.0)])
    with context.session(scene=scene, real_time=True) as session, network(session.sensor.port) as (net, node):
        report = session.report
        net.scanner.search()
        time.sleep(0.5)
        report.equal("the scanner finds the sensor", [p.FACTORY_NODE_ID], net.scanner.nodes)
        report.equal("device type", 0x4019A, node.sdo[0x1000].raw)
        report.equal("product designation", "JN2101", node.sdo[0x1008].raw)
        report.equal("programming key", "D0UfZEgRKHAI5Ag=", node.sdo[0x3000].raw)
        node.sdo[0x3000].raw = "D0UfZEgRKHAI5Ag="
        report.equal("programming key written", "D0UfZEgRKHAI5Ag=", node.sdo[0x3000].raw)
        report.equal("longitudinal", 1000, node.sdo[0x6010].raw)
        try:
            node.sdo[0x2044].raw = 9
            report.verdict(False, "a wrong value", "abort", "none")
        except canopen.SdoAbortedError as error:
            report.verdict(error.code in p.RANGE, "a wrong value", "abort", f"{error.code:08X}h")
        node.nmt.state = "RESET COMMUNICATION"
        node.nmt.wait_for_bootup(5)
        report.equal("boot-up", "PRE-OPERATIONAL", node.nmt.state)
        node.sdo[0x1017].raw = 50
        report.equal("heartbeat", "PRE-OPERATIONAL", node.nmt.wait_for_heartbeat(2))
        node.nmt.state = "OPERATIONAL"
        time.sleep(0.12)
        report.equal("heartbeat after start", "OPERATIONAL", node.nmt.wait_for_heartbeat(2))
        node.sdo[0x1017].raw = 0
        tpdos(report, net, node)
        entry = node.emcy.wait(timeout=8)
        report.verdict(entry is not None and entry.code != 0, "emergency", "a code", str(entry))
        node.nmt.state = "STOPPED"
        node.nmt.start_node_guarding(0.1)
        time.sleep(0.4)
        node.nmt.stop_node_guarding()
        report.equal("node guarding", "STOPPED", node.nmt.state)


def tpdos(report, net: canopen.Network, node: canopen.RemoteNode) -> None:
    """Reads the PDO parameters, then checks SYNC, remote frame and timer."""
    node.tpdo.read()
    for number, base in ((1, p.TPDO0), (2, p.TPDO1)):
        pdo = node.tpdo[number]
        report.equal(f"TPDO {number}: COB-ID", base + p.FACTORY_NODE_ID, pdo.cob_id)
        report.equal(f"TPDO {number}: enabled, RTR allowed", (True, True), (pdo.enabled, pdo.rtr_allowed))
        net.sync.transmit()
        arrived = pdo.wait_for_reception(2)
        report.equal(f"TPDO {number}: longitudinal and lateral at SYNC", [1000, 0], [one.raw for one in pdo] if arrived else None)
        pdo.remote_request()
        report.verdict(pdo.wait_for_reception(2) is not None, f"TPDO {number}: remote request", "a PDO", "see left")
    node.sdo[0x1800][2].raw = 254
    node.sdo[0x1800][5].raw = 20
    report.within("TPDO 1: period in s", 0.015, 0.025, mean_period(node.tpdo[1]))
    node.sdo[0x1800][2].raw = 1


def mean_period(pdo: canopen.pdo.PdoMap, periods: int = 10) -> float:
    """The mean of the next periods of a TPDO in s, from the times at which this computer has received it; 0 if it is not received."""
    times = []
    complete = threading.Event()

    def received(_: canopen.pdo.PdoMap) -> None:
        times.append(pdo.timestamp)
        if len(times) > periods:
            complete.set()

    pdo.add_callback(received)
    complete.wait(5)
    pdo.callbacks.remove(received)
    return (times[-1] - times[0]) / (len(times) - 1) if len(times) > periods else 0


def tshark(context: Context) -> None:
    """tshark decodes a complete session without a malformed frame."""
    program = shutil.which("tshark")
    if program is None:
        name = "tshark is installed"
        if os.environ.get("CI"):
            context.report.verdict(False, name, "yes", "no")
        return
    log = context.folder / "session.log"
    with context.session(log=log, scene="tilt=1,2") as session:
        converse(session)
    base = [program, "-r", str(log), "-d", "can.subdissector,canopen"]
    frames = json.loads(subprocess.run([*base, "-T", "json"], check=True, capture_output=True, text=True).stdout)
    context.report.within("frames decoded", 120, 10000, len(frames))
    # It does not decode remote frames as CANopen.
    data = [layers for frame in frames if (layers := frame["_source"]["layers"])["can"]["can.flags.rtr"] == "0"]
    context.report.equal("data frames", len(frames) - 1, len(data))
    context.report.equal("data frames decoded as CANopen", len(data), sum("canopen" in layers for layers in data))
    bad = subprocess.run([*base, "-Y", "_ws.malformed"], check=True, capture_output=True, text=True).stdout
    context.report.equal("malformed frames", "", bad)
    fields = ["-T", "fields", "-e", "canopen.function_code"]
    output = subprocess.run([*base, *fields], check=True, capture_output=True, text=True).stdout.split()
    wanted = {0x0, 0x1, 0x3, 0x5, 0xB, 0xC, 0xE}
    seen = {int(code, 0) for code in output}
    context.report.equal("NMT, SYNC/EMCY, both PDOs, SDO both ways, error control", wanted, seen & wanted)


def converse(session) -> None:
    """Exchanges frames of all services."""
    for entry in p.OBJECTS:
        session.upload(entry.index, entry.sub)
    session.download(0x3000, 0, b"D0UfZEgRKHAI5Ag=")
    session.abort_code(session.upload, 0x1004)
    session.put(0x1017, 0, 50)
    session.nmt(p.START)
    for _ in range(5):
        session.send(p.SYNC)
    session.collect(0.3)
    session.put(0x1017, 0, 0)
    session.put(0x100C, 0, 20)
    session.put(0x100D, 0, 2)
    session.guard()
    session.wait_id(p.EMCY)
    session.reset()


GROUPS = (master, tshark)
