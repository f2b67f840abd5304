#!/usr/bin/env python3
"""Checks a virtual sensor that has just started with python-can's slcan driver.

    pip install -r requirements.txt
    virtual-sensor --model is2 --scene tilt=12.34,-5.67 --log traffic.log
    python smoke.py --log traffic.log socket://127.0.0.1:11898

Opens all given channels (sockets, pseudoterminals), which share the bus. Prints one line per check; the exit code is 1 if a check
failed. It expects a GEMAC IS2 with factory values: requests with identifier 300h, replies with 301h.
"""

import argparse
import sys
import time

import can

REQUEST, REPLY, SYNC = 0x300, 0x301, 0x100
ANGLES, CYCLIC_TIME, BOOT_UP = 0x00, 0x15, 0xFF
BURST = 2000
PATIENCE = 20.0  # s; a busy computer answers late


def open_bus(channel: str, **options: object) -> can.BusABC:
    """Opens a bus on this channel. It is open on return, because the version is answered after the command to open."""
    bus = can.Bus(interface="slcan", channel=channel, sleep_after_open=0, **options)
    if None in bus.get_version(PATIENCE):
        raise SystemExit(f"FAILED {channel} does not answer with its version")
    return bus


def message(identifier: int, data: bytes = b"", **options: object) -> can.Message:
    """A message, by default with an 11-bit identifier."""
    options.setdefault("is_extended_id", False)
    return can.Message(arbitration_id=identifier, data=data, **options)


def take(bus: can.BusABC, count: int, timeout: float = PATIENCE, only: int | None = None) -> list[can.Message]:
    """The next messages, all or those with one identifier; fewer after the timeout."""
    end = time.monotonic() + timeout
    messages: list[can.Message] = []
    while len(messages) < count and (left := end - time.monotonic()) > 0:
        if (received := bus.recv(left)) and only in (None, received.arbitration_id):
            messages.append(received)
    return messages


def settle(*buses: can.BusABC) -> list[list[can.Message]] | None:
    """What these clients of one sensor have received, until the reply to a last request of the first one, which comes after all others;
    None without this reply."""
    buses[0].send(message(REQUEST, bytes([CYCLIC_TIME])))
    everything = []
    for bus in buses:
        received = []
        while not received or received[-1].arbitration_id != REPLY or received[-1].data[0] != CYCLIC_TIME:
            if not (got := bus.recv(PATIENCE)):
                return None
            received.append(got)
        everything.append(received[:-1])
    return everything


def poll(bus: can.BusABC, identifier: int = REQUEST, data: bytes = bytes([ANGLES])) -> list[can.Message]:
    """Sends a request and returns the reply; an empty list without a valid one."""
    bus.send(message(identifier, data))
    return [reply for reply in take(bus, 1, only=REPLY) if reply.data[0] == ANGLES]


def wake(bus: can.BusABC) -> list[can.Message]:
    """Sends until a sensor that detects the bit rate has found it, and returns its boot-up messages."""
    for _ in range(50):
        bus.send(message(REQUEST, bytes([ANGLES])))
        if first := take(bus, 1, 0.5, only=REPLY):
            return first + take(bus, 1, only=REPLY)
    return []


def same(a: can.Message, b: can.Message) -> bool:
    """Whether two messages are the same frame."""
    return a.equals(b, timestamp_delta=None, check_channel=False, check_direction=False)


def every_kind() -> list[can.Message]:
    """Data and remote frames of both formats with every length."""
    return [
        message(identifier, b"" if remote else bytes(range(0xF0, 0xF0 + dlc)), dlc=dlc, **kind, is_remote_frame=remote)
        for dlc in range(9)
        for remote in (False, True)
        for identifier, kind in ((0x7F0 + dlc % 4, {}), (0x1FFFFF00 + dlc, {"is_extended_id": True}))
    ]


class Checks:
    """Prints and counts the results of checks."""

    failed = 0

    def check(self, what: str, good: bool, found: object = "") -> None:
        """Prints one result."""
        self.failed += not good
        print("ok    " if good else "FAILED", what, found)


def check_bus(checks: Checks, channels: list[str]) -> None:
    """Checks the sensor and the adapters, channel by channel."""
    first, *others = (open_bus(channel) for channel in channels)
    try:
        serial = first.get_serial_number(PATIENCE)
        checks.check("the serial number of the adapter is answered", serial is not None, serial)

        boot_up = wake(first)
        good = len(boot_up) == 2 and all(m.arbitration_id == REPLY and m.data[0] == BOOT_UP for m in boot_up)
        checks.check("two boot-up messages after the first traffic", good, boot_up)

        for channel, bus in zip(channels, (first, *others)):
            settle(first, *others)
            checks.check(f"a poll through {channel} is answered", poll(bus) != [])
        checks.check("a sync frame is answered", poll(first, SYNC, b"") != [])

        for channel, other in zip(channels[1:], others):
            settle(first, *others)
            sent = every_kind()
            for frame in sent:
                first.send(frame)
            got = take(other, len(sent))
            good = len(got) == len(sent) and all(map(same, got, sent))
            checks.check(f"{channel} receives every kind of frame", good, f"({len(got)} of {len(sent)})")

            for number in range(BURST):
                other.send(message(0x123, number.to_bytes(8, "big")))
            got = take(first, BURST, 3 * PATIENCE)
            good = [int.from_bytes(m.data, "big") for m in got] == list(range(BURST))
            checks.check(f"a burst through {channel} is received completely and in order", good, f"({len(got)} of {BURST})")
        settle(first, *others)
        first.send(message(0x123))
        checks.check("an adapter does not receive its own frames", settle(first) == [[]])
    finally:
        for bus in (first, *others):
            bus.shutdown()


def check_options(checks: Checks, channel: str) -> None:
    """Opens the channel with a bit rate, with a bit timing and listen-only; a new connection is no power cycle."""
    timing = can.BitTiming.from_registers(f_clock=8_000_000, btr0=0x03, btr1=0x1C)
    for name, options in (("a bit rate", {"bitrate": 500_000}), ("bit timing", {"timing": timing})):
        bus = open_bus(channel, **options)
        try:
            checks.check(f"opened with {name}", poll(bus) != [])
        finally:
            bus.shutdown()
    bus, silent = open_bus(channel), open_bus(channel, listen_only=True)
    try:
        bus.send(message(REQUEST, bytes([ANGLES])))
        heard = take(silent, 2)
        checks.check("a listen-only client receives both frames", [m.arbitration_id for m in heard] == [REQUEST, REPLY], heard)
        settle(bus)
        silent.send(message(0x123))
        # The version is answered after the frame.
        checks.check("a listen-only client has an answer", None not in silent.get_version(PATIENCE))
        checks.check("a listen-only client cannot send", settle(bus) == [[]])
    finally:
        bus.shutdown()
        silent.shutdown()


def check_log(checks: Checks, path: str) -> None:
    """Checks that python-can reads the log, by the ending of its name and in the format of candump."""
    messages = list(can.LogReader(path))
    kinds = {m.arbitration_id for m in messages}
    good = len(messages) > 100 and {REQUEST, REPLY} <= kinds
    checks.check("python-can reads the log", good, f"({len(messages)} messages)")
    times = [m.timestamp for m in messages]
    good = times == sorted(times) and abs(times[-1] - time.time()) < 60
    checks.check("the log has ascending times of day", good)


def main() -> int:
    """Runs the checks; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--log", metavar="FILE", help="the log of the sensor, which is checked too")
    parser.add_argument("channel", nargs="+", help="socket://127.0.0.1:PORT or /dev/pts/N; the first must be a socket")
    arguments = parser.parse_args()
    checks = Checks()
    check_bus(checks, arguments.channel)
    check_options(checks, arguments.channel[0])
    if arguments.log:
        check_log(checks, arguments.log)
    return int(checks.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
