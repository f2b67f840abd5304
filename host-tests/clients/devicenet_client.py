#!/usr/bin/env python3
"""Lets devicenet-py, a public DeviceNet master, use the virtual sensors tiltix080 and tiltix360.

    pip install -r requirements.txt
    pip install --no-deps --ignore-requires-python -r requirements-no-deps.txt
    python devicenet_client.py --virtual-sensor ../../target/release/virtual-sensor

The master waits only for frames and by time.sleep: both advance the virtual time of the sensor. Prints one line per check; the exit
code is 1 if a check failed. The allocation is sent as a frame: devicenet-py sends it on the explicit connection, with the MAC ID in
other bits of its last byte.
"""

import argparse
import re
import socket
import subprocess
import sys
from types import SimpleNamespace

import can
from devicenet import devicenet
from devicenet.cid import DeviceNetCID
from devicenet.enums import DeviceNetConnectionObjectAttributes as Attribute
from devicenet.enums import DeviceNetServiceCode, DeviceNetState
from devicenet.messages import DeviceNetExplicitMessageGenericService, DeviceNetExplicitRequestMessage

NODE, MASTER = 63, 0x0A
EXPLICIT, PORT = 0x5FC, 0x5FE
RESPONSE = DeviceNetCID.slave_explicit_response(source_mac=NODE)
# A scene and its words: slope long16 and slope lateral16 in 0.01 deg.
PRODUCTS = {"tiltix080": ("tilt=12.34,-5.67", (1234, -567)), "tiltix360": ("tilt=123.47,0", (12347, 0))}


class VirtualBus(can.BusABC):
    """A bus whose time advances while a client waits: virtual-sensor/src/server/clock.rs describes the lines."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._lines = self._socket.makefile("rb")
        self._frames: list[can.Message] = []
        self._socket.sendall(b"O\r")
        self.sleep(0)
        super().__init__(channel=port)

    def sleep(self, seconds: float) -> None:
        """Advances the time, up to the next received frame."""
        self._socket.sendall(b"@%X\r" % int(seconds * 1e6))
        line = b""
        while not line.startswith(b"@"):
            line = b""
            while not line.endswith(b"\r"):
                line += self._lines.read(1)
            if line.startswith(b"t"):
                data = bytes.fromhex(line[5:-1].decode())
                self._frames.append(can.Message(arbitration_id=int(line[1:4], 16), data=data, is_extended_id=False))

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Queues a frame."""
        self._socket.sendall(f"t{msg.arbitration_id:03X}{msg.dlc}{msg.data.hex()}\r".encode())
        self.sleep(0)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The next frame, or None after the timeout."""
        if not self._frames:
            self.sleep(timeout or 0)
        return self._frames.pop(0) if self._frames else None


class Checks:
    """Prints and counts the results of checks."""

    failed = 0

    def equal(self, name: str, expected: object, got: object) -> None:
        """Checks that two values are equal."""
        self.failed += expected != got
        print("ok    " if expected == got else "FAILED", f"{name}: {got!r}", "" if expected == got else f"instead of {expected!r}")


def error(action, *arguments: object) -> str:
    """The text of the exception of an action; empty without one."""
    try:
        action(*arguments)
    except RuntimeError as problem:
        return str(problem)
    return ""


def exchange(net: devicenet.DeviceNet, identifier: int, data: str) -> bytes:
    """Sends a frame; returns the data of the next response of the sensor, or nothing."""
    net.bus.send(can.Message(arbitration_id=identifier, data=bytes.fromhex(data), is_extended_id=False))
    return answer(net)


def answer(net: devicenet.DeviceNet) -> bytes:
    """The data of the next response of the sensor, or nothing."""
    while received := net.recv(0.5):
        if received[0].pack() == RESPONSE.pack():
            return received[1]
    return b""


def read(net: devicenet.DeviceNet, kind: int, attribute: int) -> bytes:
    """Sends Get_Attribute_Single; returns the data of the response."""
    message = DeviceNetExplicitRequestMessage(
        service_code=DeviceNetServiceCode.GET_ATTRIBUTE_SINGLE,
        mac_id=MASTER,
        class_id=kind,
        instance_id=1,
        message=bytes([attribute]),
    )
    net.send(DeviceNetCID.master_explicit_request(dest_mac=NODE), message)
    return answer(net)


def check(checks: Checks, product: str, bus: VirtualBus) -> None:
    """The duplicate MAC ID check of the master, the poll connection, and explicit messages with fragments."""
    words = b"".join(word.to_bytes(2, "little", signed=word < 0) for word in PRODUCTS[product][1])
    net = devicenet.DeviceNet(bus, MASTER, vendor_id=1, serial_number=77)
    net.connect()
    checks.equal("free MAC ID", DeviceNetState.ONLINE, net.state)
    other = devicenet.DeviceNet(bus, NODE, vendor_id=1, serial_number=77)
    checks.equal("MAC ID of the sensor", "MAC already in use, cannot connect to bus.", error(other.connect))
    checks.equal("state of that master", DeviceNetState.COMMUNICATION_FAULT, other.state)

    no_poll = "No response to poll io"
    checks.equal("poll, not allocated", no_poll, error(net.poll_io, NODE))
    checks.equal("allocate explicit and poll", "0acb00", exchange(net, PORT, "0A4B0301030A").hex())
    for attribute, expected in (
        (Attribute.STATE, 1),
        (Attribute.INSTANCE_TYPE, 1),
        (Attribute.PRODUCED_CONNECTION_SIZE, 4),
        (Attribute.CONSUMED_CONNECTION_SIZE, 0),
        (Attribute.CP23_PRODUCED_CONNECTION_ID, 0x3FF),
        (Attribute.CP23_CONSUMED_CONNECTION_ID, 0x5FD),
        (Attribute.PRODUCED_CONNECTION_PATH_LENGTH, 6),
    ):
        checks.equal(attribute.name, expected, net.get_attribute_single(NODE, attribute))
    checks.equal("poll, configuring", no_poll, error(net.poll_io, NODE))
    net.set_attribute_single(NODE, Attribute.EXPECTED_PACKET_RATE, 1000)
    checks.equal("rate", 1000, net.get_attribute_single(NODE, Attribute.EXPECTED_PACKET_RATE))
    checks.equal("state", 3, net.get_attribute_single(NODE, Attribute.STATE))
    checks.equal("polls", [words] * 5, [bytes(net.poll_io(NODE)) for _ in range(5)])
    checks.equal("poll with data", no_poll, error(net.poll_io, NODE, b"\x00"))

    for kind, attribute, expected in ((1, 1, "6201"), (3, 1, "3f"), (0x65, 0x72, words[:2].hex())):
        message = DeviceNetExplicitMessageGenericService.unpack(read(net, kind, attribute))
        found = (message.mac_id, message.service_code, message.is_response, message.message.hex())
        expected = (MASTER, DeviceNetServiceCode.GET_ATTRIBUTE_SINGLE, True, expected)
        checks.equal(f"class {kind:02X}h attribute {attribute:02X}h", expected, found)
    fragments = [read(net, 1, 7)]
    while fragments[-1][1] & 0xC0 != 0x80:
        fragments.append(exchange(net, EXPLICIT, f"8A{0xC0 | fragments[-1][1] & 0x3F:02X}00"))
    name = f"INCLINOMETER {product[-3:]} degree".encode()
    message = DeviceNetExplicitMessageGenericService.unpack(fragments)
    checks.equal("product name in 5 fragments", (5, bytes([23]) + name), (len(fragments), bytes(message.message)))

    exchange(net, EXPLICIT, "8AC400")
    checks.equal("release", "0acc", exchange(net, PORT, "0A4C030103").hex())
    checks.equal("poll, released", no_poll, error(net.poll_io, NODE))


def main() -> int:
    """Runs the checks; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--virtual-sensor", required=True, metavar="PATH", help="the program to check")
    program, checks = parser.parse_args().virtual_sensor, Checks()
    for product, (scene, _) in PRODUCTS.items():
        command = [program, "--model", product, "--scene", scene, "--listen", "127.0.0.1:0", "--clock", "client"]
        with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as sensor:
            bus = VirtualBus(int(re.search(r":(\d+)\s*$", sensor.stdout.readline())[1]))
            devicenet.time = SimpleNamespace(sleep=bus.sleep)
            # On-line after both requests of its duplicate MAC ID check.
            while bus.recv(1.1):
                pass
            try:
                check(checks, product, bus)
            finally:
                sensor.kill()
                bus.shutdown()
    return int(checks.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
