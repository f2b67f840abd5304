"""devicenet-py as the master: duplicate MAC ID check, attributes and rate of the poll connection, poll, fragmented answers."""

import contextlib
import time
from collections.abc import Iterator

import can
from devicenet.cid import DeviceNetCID
from devicenet.devicenet import DeviceNet
from devicenet.enums import DeviceNetConnectionObjectAttributes as Attribute
from devicenet.enums import DeviceNetServiceCode, DeviceNetState
from devicenet.messages import DeviceNetExplicitMessageGenericService, DeviceNetExplicitRequestMessage

from . import protocol as p
from .runner import Context
from .session import Session


@contextlib.contextmanager
def master(session: Session, mac: int = p.MASTER) -> Iterator[DeviceNet]:
    """devicenet-py on the bus of the sensor."""
    bus = can.Bus(interface="slcan", channel=f"socket://127.0.0.1:{session.sensor.port}", sleep_after_open=0)
    try:
        yield DeviceNet(bus, mac, vendor_id=1, serial_number=77)
    finally:
        bus.shutdown()


def error(action, *arguments: object) -> str:
    """The text of the exception of an action; empty without one."""
    try:
        action(*arguments)
    except RuntimeError as problem:
        return str(problem)
    return ""


def connects(context: Context) -> None:
    """The duplicate MAC ID check of the master: with a free MAC ID, and with that of the sensor."""
    with context.session(real_time=True) as session:
        report = session.report
        with master(session) as net:
            net.connect()
            report.equal("free MAC ID", DeviceNetState.ONLINE, net.state)
        with master(session, p.FACTORY_MAC) as net:
            report.equal("MAC ID of the sensor", "MAC already in use, cannot connect to bus.", error(net.connect))
            report.equal("state of the master", DeviceNetState.COMMUNICATION_FAULT, net.state)
        report.equal("the sensor stays on-line", True, session.wait_online(1) is not None)


def polls(context: Context) -> None:
    """Attributes of the poll connection, its rate, and polls."""
    with context.session(real_time=True) as session, master(session) as net:
        report, node = session.report, p.FACTORY_MAC
        net.connect()
        report.equal("nothing allocated", "No response to poll io", error(net.poll_io, node))
        report.equal("allocate", "0ACB00", session.allocate(3))
        get = lambda attribute: net.get_attribute_single(node, attribute)  # noqa: E731
        net.handle_messages(0.05)
        report.equal("state", p.CONFIGURING, get(Attribute.STATE))
        report.equal("type", 1, get(Attribute.INSTANCE_TYPE))
        report.equal("produced size", 4, get(Attribute.PRODUCED_CONNECTION_SIZE))
        report.equal("consumed size", 0, get(Attribute.CONSUMED_CONNECTION_SIZE))
        report.equal("produced identifier", p.poll_response(node), get(Attribute.CP23_PRODUCED_CONNECTION_ID))
        report.equal("consumed identifier", p.group2(p.POLL, node), get(Attribute.CP23_CONSUMED_CONNECTION_ID))
        report.equal("path length", 6, get(Attribute.PRODUCED_CONNECTION_PATH_LENGTH))
        report.equal("configuring: poll", "No response to poll io", error(net.poll_io, node))
        net.set_attribute_single(node, Attribute.EXPECTED_PACKET_RATE, 1000)
        report.equal("rate", 1000, get(Attribute.EXPECTED_PACKET_RATE))
        report.equal("state", p.ESTABLISHED, get(Attribute.STATE))
        words = session.words(session.subject.long)
        for number in range(5):
            report.equal(f"poll {number}", words, bytes(net.poll_io(node)).hex().upper())
        report.equal("poll with data", "No response to poll io", error(net.poll_io, node, b"\x00"))
        # What the other adapter has caused.
        session.collect(0.05)
        report.equal("release", "0ACC", session.release(3))
        net.handle_messages(0.05)
        report.equal("released: poll", "No response to poll io", error(net.poll_io, node))


def reads(context: Context) -> None:
    """Explicit requests and answers in its message classes, with the fragments of the product name."""
    with context.session(real_time=True) as session, master(session) as net:
        report, node = session.report, p.FACTORY_MAC
        session.connect()
        net.handle_messages(0.05)
        for kind, attribute, expected in (
            (1, 1, p.encode(p.VENDOR, 2)),
            (3, 1, "3F"),
            (0x65, 0x72, p.encode(session.subject.long, 2)),
        ):
            answer = DeviceNetExplicitMessageGenericService.unpack(request(net, node, kind, attribute))
            got = (answer.mac_id, answer.service_code, answer.is_response, answer.message.hex().upper())
            report.equal(f"{kind:02X}h attribute {attribute:02X}h", (p.MASTER, p.GET, True, expected), got)
        frames = [request(net, node, 1, 7)]
        while frames[-1][1] & 0xC0 != 0x80:
            frames.append(exchange(net, node, bytes([0x8A, 0xC0 | frames[-1][1] & 0x3F, 0])))
        net.bus.send(
            can.Message(
                arbitration_id=p.group2(p.EXPLICIT, node), is_extended_id=False, data=bytes([0x8A, 0xC0 | len(frames) - 1, 0])
            )
        )
        answer = DeviceNetExplicitMessageGenericService.unpack(frames)
        name = session.subject.name.encode()
        report.equal("product name in fragments", bytes([len(name)]) + name, bytes(answer.message))
        report.equal("number of fragments", 5, len(frames))


def request(net: DeviceNet, node: int, kind: int, attribute: int) -> bytes:
    """Sends Get_Attribute_Single; returns the data of the answer."""
    message = DeviceNetExplicitRequestMessage(
        service_code=DeviceNetServiceCode.GET_ATTRIBUTE_SINGLE,
        mac_id=p.MASTER,
        class_id=kind,
        instance_id=1,
        message=bytes([attribute]),
    )
    net.send(DeviceNetCID.master_explicit_request(dest_mac=node), message)
    return answer_of(net, node)


def exchange(net: DeviceNet, node: int, data: bytes) -> bytes:
    """Sends a frame on the explicit connection; returns the data of the answer."""
    net.bus.send(can.Message(arbitration_id=p.group2(p.EXPLICIT, node), is_extended_id=False, data=data))
    return answer_of(net, node)


def answer_of(net: DeviceNet, node: int) -> bytes:
    """The data of the next answer of the sensor; empty without one."""
    wanted, end = DeviceNetCID.slave_explicit_response(source_mac=node), time.monotonic() + 0.5
    while time.monotonic() < end:
        received = net.recv(0.5)
        if received and received[0].pack() == wanted.pack():
            return received[1]
    return b""


GROUPS = (connects, polls, reads)
