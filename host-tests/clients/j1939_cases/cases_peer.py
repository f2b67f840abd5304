"""can-j1939 as the other nodes: claims against ours, requests, BAM and RTS/CTS, DM1, Commanded Address, parameters.

can-j1939 knows only the time of the computer. It sends nothing before it has an address, which takes up to 0.75 s.
"""

import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import j1939

from canopen_cases.runner import Context

from . import protocol as p
from .cases_request import texts
from .session import Node

TIMEOUT = 8.0
STATE = j1939.ControllerApplication.State


class Ecu:
    """An ECU with one controller application on an adapter of its own."""

    def __init__(self, session: Node, name: p.Name, address: int, packets: int = 1) -> None:
        self.ecu = j1939.ElectronicControlUnit(max_cmdt_packets=packets)
        self.bus = self.ecu.connect(interface="slcan", channel=f"socket://127.0.0.1:{session.sensor.port}", sleep_after_open=0)
        fields = j1939.Name(
            arbitrary_address_capable=name.capable,
            industry_group=name.industry,
            vehicle_system_instance=name.system_instance,
            vehicle_system=name.system,
            function=name.function,
            function_instance=name.function_instance,
            ecu_instance=name.ecu_instance,
            manufacturer_code=name.manufacturer,
            identity_number=name.identity,
        )
        session.report.equal(
            f"S21 can-j1939 encodes the NAME {name.value:016X} in the same way", list(name.data), list(fields.bytes)
        )
        self.application = j1939.ControllerApplication(fields, address)
        self.ecu.add_ca(controller_application=self.application)
        self.received: queue.Queue = queue.Queue()
        self.application.subscribe(self._receive)

    def _receive(self, priority: int, pgn: int, source: int, timestamp: float, data: bytes) -> None:
        self.received.put((priority, pgn, source, bytes(data)))

    def start(self) -> None:
        """Begins to claim."""
        self.application.start()

    def settled(self) -> str:
        """Waits until it has an address, or none; returns that."""
        wait(lambda: self.application.state in (STATE.NORMAL, STATE.CANNOT_CLAIM), TIMEOUT)
        return self.shown()

    def shown(self) -> str:
        """The address, or why there is none."""
        if self.application.state == STATE.NORMAL:
            return f"{self.application.device_address:02X}h"
        return "none" if self.application.state == STATE.CANNOT_CLAIM else "claiming"

    def get(self, pgn: int, source: int | None = None, size: int | None = None) -> bytes | None:
        """The data of the next message of a group."""
        end = time.monotonic() + TIMEOUT
        while (left := end - time.monotonic()) > 0:
            try:
                _, got, sender, data = self.received.get(timeout=left)
            except queue.Empty:
                break
            if got == pgn and source in (None, sender) and size in (None, len(data)):
                return data
        return None

    def request(self, pgn: int, to: int) -> None:
        """59904."""
        while not self.received.empty():
            self.received.get()
        self.application.send_request(0, pgn, to)

    def close(self) -> None:
        """Leaves the bus."""
        self.ecu.stop()
        self.ecu._notifier.stop()
        # pyserial sleeps 0.3 s when it closes a socket.
        threading.Thread(target=self.bus.shutdown, daemon=True).start()


def wait(done: Callable[[], bool], seconds: float) -> bool:
    """Waits until something is so."""
    end = time.monotonic() + seconds
    while not done() and time.monotonic() < end:
        time.sleep(0.01)
    return done()


@contextmanager
def ecus(session: Node, *names: tuple[p.Name, int], packets: int = 1) -> Iterator[list[Ecu]]:
    """Starts ECUs with these NAMEs and addresses."""
    found = [Ecu(session, name, address, packets) for name, address in names]
    try:
        for one in found:
            one.start()
        yield found
    finally:
        for one in found:
            one.close()


def node(context: Context, settings: dict | None = None, **options: object) -> Node:
    """A sensor in the time of the computer."""
    return Node(context, settings, real_time=True, **options)


MASTER = p.Name(capable=0, function=20, manufacturer=100, identity=7)


def claims(context: Context) -> None:
    """S21, S23: a master without arbitrary address takes our address; a node with a higher NAME does not."""
    with node(context) as session:
        with ecus(session, (MASTER, 0x80)) as (master,):
            frame = session.wait(lambda frame: str(frame) == p.claim(0x81), TIMEOUT)
            session.report.equal("S23 can-j1939 claims our address with a lower NAME: we move", True, frame is not None)
            session.report.equal("S23 can-j1939 has it", "80h", master.settled())
            session.address = 0x81
            session.wait_online()
            session.reads("S23 we answer at the next", 0x2102, 0, 0x80)
    higher = p.Name(capable=1, function=200, identity=9)
    for name, expected in ((higher, "81h"), (p.Name(capable=1, function=145, identity=2), "81h")):
        with node(context, name=f"h{name.function}") as session, ecus(session, (name, 0x80)) as (other,):
            # A defence within microseconds of its claim is lost (can-j1939 notes its claim after sending it): again.
            for _ in range(3):
                if wait(lambda: other.shown() == expected, 3.0):
                    break
                session.tx(session.request(p.CLAIMED, p.GLOBAL))
            session.report.equal("S23 can-j1939 with a higher NAME loses and moves", expected, other.settled())
            got = session.after(session.request(p.CLAIMED))
            session.report.equal(
                "S23 we keep our address", p.claim(), [line for line in got if line.endswith(p.OURS.data.hex().upper())][-1:][0]
            )


def contention(context: Context) -> None:
    """S23: five nodes of can-j1939 and ours claim the same address; in the end, each has its own."""
    with node(context) as session:
        names = [(p.Name(capable=1, function=100 + 30 * number, identity=number + 2), 0x80) for number in range(5)]
        with ecus(session, *names) as others:
            end = time.monotonic() + 25.0
            while time.monotonic() < end:
                session.tx(session.request(p.CLAIMED, p.GLOBAL))
                session.wait(lambda frame: False, 0.7)
                seen = [str(frame) for frame in session.others if p.split(frame) and p.split(frame).pgn == p.CLAIMED]
                session.others.clear()
                mine = {line[6:8] for line in seen if line.endswith(p.OURS.data.hex().upper())}
                addresses = [one.shown() for one in others] + [f"{one}h" for one in mine]
                if len(mine) == 1 and len(set(addresses)) == 6 and not {"none", "claiming"} & set(addresses):
                    break
            session.report.equal("S23 six nodes, six addresses", 6, len(set(addresses)))
            session.report.equal("S23 ours has one of 128..247", True, len(mine) == 1 and 128 <= int(min(mine), 16) <= 247)


def requests(context: Context) -> None:
    """S26..S29: requests of can-j1939, answered in one frame, by RTS/CTS with 1, 2 and 255 packets per CTS, and by BAM."""
    for packets in (1, 2, 255):
        with node(context, name=f"p{packets}") as session, ecus(session, (MASTER, p.ME), packets=packets) as (master,):
            session.report.equal("can-j1939 has its address", f"{p.ME:02X}h", master.settled())
            whole = texts(session)
            for pgn, text in whole.items():
                for to in (0x80, p.GLOBAL):
                    master.request(pgn, to)
                    got = master.get(pgn, 0x80)
                    session.report.equal(f"S28 {pgn} to {to:02X}h, {packets} packets per CTS", text, got and got[: len(text)])
            for pgn in p.PROCESS:
                master.request(pgn, 0x80)
                session.report.equal(f"S26 {pgn}", 8, len(master.get(pgn, 0x80) or b""))
            master.request(65262, 0x80)
            got = master.get(p.ACKNOWLEDGE, 0x80)
            session.report.equal("S27 negative acknowledgement", "01FFFFFF21EEFE00", got.hex().upper() if got else None)


def diagnostics(context: Context) -> None:
    """S37: can-j1939's decoder of DM1: lamps and codes, in one frame and by BAM."""
    with node(context, {(0x3110, 1): 0}) as session, ecus(session, (MASTER, p.ME)) as (master,):
        master.settled()
        found: queue.Queue = queue.Queue()
        decoder = j1939.Dm1(master.application)
        decoder.subscribe(lambda source, lamps, codes, timestamp: found.put((source, lamps, codes)))

        def until(name: str, lamp: int, *expected: tuple[int, int, int]) -> None:
            end, seen = time.monotonic() + TIMEOUT, None
            while time.monotonic() < end:
                try:
                    source, lamps, codes = found.get(timeout=2.0)
                except queue.Empty:
                    continue
                seen = lamps["awl"], sorted((code["spn"], code["fmi"], code["oc"]) for code in codes if code["spn"])
                if seen == (lamp, sorted(expected)):
                    break
            session.report.equal(name, (lamp, sorted(expected)), seen)

        until("S37 no code", j1939.DtcLamp.OFF)
        session.put(0x3210, 0, 9500)
        # Flash bits 11 mean a lamp that is constantly on.
        until("S37 pitch above", j1939.DtcLamp.ON, (4976, 0, 1))
        session.put(0x3220, 0, -9500)
        until("S37 and roll below, by BAM", j1939.DtcLamp.ON, (4976, 0, 1), (4977, 1, 1))
        session.put(0x3210, 0, 0)
        session.put(0x3220, 0, 0)
        until("S37 gone", j1939.DtcLamp.OFF)


def commands(context: Context) -> None:
    """S25, S38: Commanded Address by can-j1939's BAM, parameters, slope messages."""
    with node(context, {(0x2104, 1): 50}) as session, ecus(session, (MASTER, p.ME)) as (master,):
        master.settled()
        got = master.get(p.SSI2, 0x80)
        session.report.equal("S31 can-j1939 receives SSI2", "00007D00007D33FF", got.hex().upper() if got else None)
        send = master.application.send_pgn
        send(0, 0xEF, 0x80, 6, list(bytes.fromhex("4000100000000000")))
        got = master.get(p.PROPRIETARY_A, 0x80)
        session.report.equal("S38 can-j1939 reads 1000h", "430010009A010407", got.hex().upper() if got else None)
        send(0, 0xFE, 0xD8, 6, list(p.OURS.data + b"\xa0"))
        frame = session.wait(lambda frame: str(frame) == p.claim(0xA0), TIMEOUT)
        session.report.equal("S25 Commanded Address to A0h", True, frame is not None)
        got = master.get(p.SSI2, 0xA0)
        session.report.equal("S25 SSI2 from A0h", True, got is not None)
        # A message of 30 bytes of a group that the sensor does not receive, by RTS: it aborts.
        send(0, 0xEF, 0xA0, 6, list(range(30)))
        frame = session.wait(lambda frame: str(frame) == p.abort(0xA0, p.ME, p.PROPRIETARY_A, p.RESOURCES), TIMEOUT)
        session.report.equal("S29 RTS of can-j1939: abort, reason 2", True, frame is not None)


GROUPS = (claims, contention, requests, diagnostics, commands)
