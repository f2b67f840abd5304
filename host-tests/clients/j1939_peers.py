#!/usr/bin/env python3
"""can-j1939 as the other nodes on the bus of the virtual sensor ims360: claims, requests, BAM and RTS/CTS, DM1, Commanded Address.

    pip install -r requirements.txt
    python j1939_peers.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line for each check that fails, then `N passed, N failed`; the exit code is 1 if a check failed. The time is that of the
sensor (host-tests/virtual-sensor/src/server/clock.rs): can-j1939 gets it as the time of the computer, and its thread is a step of the
loop below.
"""

import argparse
import re
import socket
import subprocess
import sys
from types import SimpleNamespace

import j1939
from j1939 import electronic_control_unit, j1939_21

SENSOR, MASTER, ALL = 0x80, 0x21, 0xFF
OUR_NAME = bytes.fromhex("0100E0FF00910080")
COMPONENT, SOFTWARE, ECU = 65259, 65242, 64965
TEXTS = {COMPONENT: b"Plumbline*IMS360*1**", SOFTWARE: b"\x01010000*", ECU: b"IMS360*1**Inclinometer*Plumbline*"}
PROCESS = (61481, 61459, 61482, 61485)
STATE = j1939.ControllerApplication.State
QUIET, J1939_MODE, SAVE = "2B04210100000000", "2F00310101000000", "2310100173617665"
counts = {True: 0, False: 0}


def check(what, expected, got):
    """Counts a check and prints it if it failed."""
    counts[expected == got] += 1
    if expected != got:
        print(f"FAIL {what}: expected {expected!r}, got {got!r}")


class Node:
    """A node with can-j1939."""

    def __init__(self, bus, address, packets=1, **name):
        self.ecu = j1939.ElectronicControlUnit(max_cmdt_packets=packets, send_message=lambda *frame: bus.send(self, *frame))
        self.ecu._job_thread_wakeup_queue = SimpleNamespace(get=lambda *_: None, put=lambda _: None)
        name = j1939.Name(**{"arbitrary_address_capable": 1, "manufacturer_code": 100, "identity_number": 7} | name)
        self.application = self.ecu.add_ca(name=name, device_address=address)
        self.application.subscribe(lambda priority, pgn, source, at, data: self.received.append((pgn, source, bytes(data))))
        self.received = []
        bus.nodes.append(self)
        self.application.start()

    def step(self):
        """One round of the thread of can-j1939."""
        ends = iter((False, True))
        self.ecu._job_thread_end = SimpleNamespace(is_set=lambda: next(ends))
        self.ecu._async_job_thread()

    def address(self):
        """The address; None without one."""
        return self.application.device_address if self.application.state == STATE.NORMAL else None

    def request(self, pgn, to):
        """Requests a group."""
        self.received.clear()
        self.application.send_request(0, pgn, to)

    def get(self, pgn, source=SENSOR):
        """The data of the last message of a group from a node."""
        return next((data for got, sender, data in reversed(self.received) if (got, sender) == (pgn, source)), None)


class Bus:
    """A virtual sensor with these objects in J1939, an adapter, and the nodes on its bus."""

    def __init__(self, program, *objects):
        command = [program, "--model", "ims360", "--clock", "client", "--listen", "127.0.0.1:0", "--scene", "tilt=0,0"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        port = int(re.search(r":(\d+)\s*$", self.process.stdout.readline())[1])
        self.lines = socket.create_connection(("127.0.0.1", port))
        self.lines.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.nodes, self.time, self.rest = [], 0.0, b""
        self.sent, self.seen = [], []
        # can-j1939 starts a thread and reads the time of the computer.
        electronic_control_unit.threading = SimpleNamespace(Lock=lambda: None, Event=lambda: None, Thread=Idle)
        electronic_control_unit.time = j1939_21.time = SimpleNamespace(time=lambda: self.time)
        self.lines.sendall(b"O\r")
        self.run(0.1)
        for data in (*objects, J1939_MODE, SAVE):
            self.lines.sendall(f"t6328{data}\r".encode())
            self.run(0.1)
        self.lines.sendall(b"t00028132\r")
        self.run(0.4)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.lines.close()

    def send(self, sender, identifier, extended, data, fd_format=False):
        """Sends a frame of one of the nodes. The others receive it too: they share the adapter."""
        self.sent.append((sender, identifier, bytearray(data)))
        self.lines.sendall(f"T{identifier:08X}{len(data)}{bytes(data).hex().upper()}\r".encode())

    def run(self, seconds):
        """Lets time pass."""
        end = self.time + seconds
        while self.time < end - 1e-6:
            self.lines.sendall(b"@3E8\r")
            while not (line := self.line()).startswith("@"):
                if line.startswith("T"):
                    identifier, data = int(line[1:9], 16), bytearray.fromhex(line[10:])
                    self.seen.append(f"{identifier:08X}#{data.hex().upper()}")
                    for node in self.nodes:
                        node.ecu.notify(identifier, data, self.time)
            self.time = int(line[1:], 16) / 1e6
            sent, self.sent = self.sent, []
            for sender, *frame in sent:
                for node in self.nodes:
                    if node is not sender:
                        node.ecu.notify(*frame, self.time)
            for node in self.nodes:
                node.step()

    def line(self):
        """The next line of the adapter."""
        while b"\r" not in self.rest:
            self.rest += self.lines.recv(4096) or sys.exit("the sensor has ended")
        line, _, self.rest = self.rest.partition(b"\r")
        return line.decode().lstrip("\a")


class Idle:
    """A thread that does not run."""

    def __init__(self, **_):
        pass

    def start(self):
        """Nothing."""


def claims(program):
    """A node with a lower NAME takes the address; one with a higher NAME moves. Then each of six nodes gets an address of its own."""
    with Bus(program, QUIET) as bus:
        master = Node(bus, SENSOR, arbitrary_address_capable=0, function=20)
        bus.run(1.0)
        check("S23 lower NAME", (SENSOR, True), (master.address(), f"18EEFF81#{OUR_NAME.hex().upper()}" in bus.seen))
    with Bus(program, QUIET) as bus:
        other = Node(bus, SENSOR, function=200)
        bus.run(2.0)
        check("S23 higher NAME moves", SENSOR + 1, other.address())
        check("S23 we stay", False, f"18EEFF81#{OUR_NAME.hex().upper()}" in bus.seen)
    with Bus(program, QUIET) as bus:
        nodes = [Node(bus, SENSOR, function=100 + 30 * number, identity_number=number + 2) for number in range(5)]
        bus.run(5.0)
        ours = [int(text[6:8], 16) for text in bus.seen if text.endswith(f"#{OUR_NAME.hex().upper()}")]
        addresses = [node.address() for node in nodes] + ours[-1:]
        check("S23 six nodes, six addresses", list(range(128, 134)), sorted(addresses, key=lambda one: one or 0))


def requests(program):
    """Each group on request, in one frame, by RTS/CTS with 1, 2 and 255 packets for each CTS, and by BAM."""
    for packets in (1, 2, 255):
        with Bus(program, QUIET) as bus:
            node = Node(bus, MASTER, packets, arbitrary_address_capable=0)
            bus.run(1.0)
            for pgn, text in TEXTS.items():
                for to in (SENSOR, ALL):
                    node.request(pgn, to)
                    bus.run(0.6)
                    check(f"S28 {pgn} to {to}, {packets} packets", text, (node.get(pgn) or b"")[: len(text)])
            for pgn in PROCESS:
                node.request(pgn, SENSOR)
                bus.run(0.05)
                check(f"S26 {pgn}", 8, len(node.get(pgn) or b""))
            node.request(65262, SENSOR)
            bus.run(0.05)
            check("S27 refused", "01FFFFFF21EEFE00", (node.get(59392) or b"").hex().upper())


def diagnostics(program):
    """The decoder of DM1: lamps and codes, in one frame and by BAM; parameters."""
    with Bus(program, QUIET) as bus:
        node = Node(bus, MASTER, arbitrary_address_capable=0)
        bus.run(1.0)
        found = []
        j1939.Dm1(node.application).subscribe(lambda source, lamps, codes, at: found.append((lamps["awl"], codes)))
        steps = (
            ("1032001C250000", [(4976, 0, 1)]),  # 3210h = 95 deg
            ("203200E4DAFFFF", [(4976, 0, 1), (4977, 1, 1)]),  # 3220h = -95 deg
            ("10320000000000", [(4977, 1, 1)]),
            ("20320000000000", []),
        )
        for data, expected in steps:
            node.application.send_pgn(0, 0xEF, SENSOR, 6, list(bytes.fromhex(f"23{data}")))
            bus.run(1.2)
            lamp, codes = found[-1]
            codes = [(code["spn"], code["fmi"], code["oc"]) for code in codes if code["spn"]]
            check(f"S37 {data}", (j1939.DtcLamp.ON if expected else j1939.DtcLamp.OFF, expected), (lamp, codes))
            check(f"S38 {data}", f"60{data[:6]}00000000", (node.get(0xEF00) or b"").hex().upper())


def commands(program):
    """SSI2 as delivered; Commanded Address by BAM of can-j1939; a message to us that we do not receive."""
    with Bus(program) as bus:
        node = Node(bus, MASTER, arbitrary_address_capable=0)
        bus.run(1.0)
        check("S31 SSI2", "00007D00007D33FF", (node.get(PROCESS[0]) or b"").hex().upper())
        node.application.send_pgn(0, 0xFE, 0xD8, 6, list(OUR_NAME + b"\xa0"))
        bus.run(1.0)
        check("S25 claimed", True, f"18EEFFA0#{OUR_NAME.hex().upper()}" in bus.seen)
        check("S25 SSI2 from there", 8, len(node.get(PROCESS[0], 0xA0) or b""))
        node.application.send_pgn(0, 0xEF, 0xA0, 6, list(range(30)))
        bus.run(0.1)
        check("S29 aborted", True, "1CEC21A0#FF02FFFFFF00EF00" in bus.seen)


def main():
    """Runs the checks; returns the exit code."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--virtual-sensor", required=True)
    program = options.parse_args().virtual_sensor
    for group in (claims, requests, diagnostics, commands):
        group(program)
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
