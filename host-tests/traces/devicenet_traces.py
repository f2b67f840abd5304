"""The traces of the DeviceNet sensors, written from the manual of the POSITAL TILTIX and the predefined master/slave connection set."""

from collections.abc import Iterator

from canopen_traces import Trace

MASTER = 0x0A
FACTORY_MAC = 63
VENDOR = "6201"
SERIAL = "01000000"

# Identifiers of group 1 (message ID, MAC ID) and of group 2 (MAC ID, message ID).
COS, POLL_RESPONSE = 0x340, 0x3C0
ACKNOWLEDGE, RESPONSE, REQUEST, POLL, UNCONNECTED, DUPLICATE = 2, 3, 4, 5, 6, 7

ORIGIN = "written from the POSITAL TILTIX DeviceNet manual, {}, and the predefined master/slave connection set"


def all_traces() -> Iterator[Trace]:
    """Every trace of this file."""
    yield poll("tiltix080", "12.34,-5.67", "D204C9FD")
    yield poll("tiltix360", "123.47,0", "3B300000")
    yield change_of_state()
    yield mac_id()


def group2(message: int, mac: int = FACTORY_MAC) -> int:
    """An identifier of message group 2."""
    return 0x400 | mac << 3 | message


def start(name: str, sections: str, scene: str) -> Trace:
    """A trace that begins with the duplicate MAC ID check."""
    trace = Trace(name, ORIGIN.format(sections), scene=scene)
    trace.note("Two requests of the duplicate MAC ID check; on-line one second after the second.")
    duplicate_check(trace, FACTORY_MAC)
    return trace


def duplicate_check(trace: Trace, mac: int) -> None:
    """Both requests and the time until the sensor is on-line."""
    trace.expect(group2(DUPLICATE, mac), f"00{VENDOR}{SERIAL}")
    trace.wait(1000)
    trace.expect(group2(DUPLICATE, mac), f"00{VENDOR}{SERIAL}")
    trace.wait(1010)


def ask(trace: Trace, request: str, response: str, port: int = REQUEST) -> None:
    """A request of the master without its header, the response, and a pause."""
    trace.send(group2(port), f"{MASTER:02X}{request}")
    trace.expect(group2(RESPONSE), f"{MASTER:02X}{response}")
    trace.wait(10)


def poll(name: str, scene: str, words: str) -> Trace:
    """The sequence of 6.1, attributes, the product name in fragments, and errors."""
    trace = start(f"{name}-poll", "5.1 and 6.1", scene)
    trace.note("Nothing is allocated, so a poll has no response; release is refused.")
    trace.send(group2(POLL))
    trace.wait(10)
    ask(trace, "4C030101", "940B02", UNCONNECTED)
    trace.note("Allocate explicit and poll; a poll is answered when the expected packet rate is set.")
    ask(trace, "4B0301030A", "CB00", UNCONNECTED)
    trace.send(group2(POLL))
    trace.wait(10)
    ask(trace, "100501090000", "900000")
    ask(trace, "10050209E803", "90E803")
    for _ in range(3):
        trace.send(group2(POLL))
        trace.expect(POLL_RESPONSE | FACTORY_MAC, words)
        trace.wait(10)
    trace.note("Vendor, number of attributes, resolution, assembly 101.")
    ask(trace, "0E010101", f"8E{VENDOR}")
    ask(trace, "0E650101", "8E1600")
    ask(trace, "0E650171", "8E0A00")
    ask(trace, "0E046503", f"8E{words[:4]}")
    trace.note("The product name in fragments.")
    text = bytes([23]) + f"INCLINOMETER {name[-3:]} degree".encode()
    body = bytes([0x8E]) + text
    trace.send(group2(REQUEST), f"{MASTER:02X}0E010107")
    parts = [body[at : at + 6] for at in range(0, len(body), 6)]
    for count, part in enumerate(parts):
        kind = 0x00 if count == 0 else 0x80 if count == len(parts) - 1 else 0x40
        trace.expect(group2(RESPONSE), f"{0x80 | MASTER:02X}{kind | count:02X}{part.hex().upper()}")
        trace.wait(1)
        trace.send(group2(REQUEST), f"{0x80 | MASTER:02X}{0xC0 | count:02X}00")
    trace.wait(10)
    trace.note("A value out of range, a read-only attribute, one that does not exist, too much and not enough data.")
    ask(trace, "10650184FB", "9409FF")
    ask(trace, "10650172", "940EFF")
    ask(trace, "0E650179", "9414FF")
    ask(trace, "10650184FFFF", "9415FF")
    ask(trace, "1065017164", "9413FF")
    trace.note("The assembly cannot be changed while the poll connection exists.")
    ask(trace, "1065018165", "940CFF")
    trace.note("Another master is refused; then the owner releases.")
    trace.send(group2(UNCONNECTED), "0B4B0301010B")
    trace.expect(group2(RESPONSE), "0B940C01")
    trace.wait(10)
    ask(trace, "4C030103", "CC", UNCONNECTED)
    return trace


def change_of_state() -> Trace:
    """The sequence of 6.2."""
    trace = start("tiltix080-cos", "6.2", "12.34,-5.67")
    ask(trace, "4B0301510A", "CB00", UNCONNECTED)
    ask(trace, "100501090000", "900000")
    trace.note("The first message follows the response; without a change there is no other.")
    trace.send(group2(REQUEST), f"{MASTER:02X}100504090000")
    trace.expect(group2(RESPONSE), f"{MASTER:02X}900000")
    trace.expect(COS | FACTORY_MAC, "D204C9FD")
    trace.wait(500)
    ask(trace, "4C030151", "CC", UNCONNECTED)
    return trace


def mac_id() -> Trace:
    """A new MAC ID, also after a power cycle."""
    trace = start("tiltix360-mac-id", "5.1.1", "327.68,0")
    ask(trace, "4B0301010A", "CB00", UNCONNECTED)
    trace.note("Answered with the old MAC ID, then the check with the new one.")
    trace.send(group2(REQUEST), f"{MASTER:02X}1003010103")
    trace.expect(group2(RESPONSE), f"{MASTER:02X}90")
    duplicate_check(trace, 3)
    trace.note("On-line: a request of another node with this MAC ID is answered.")
    trace.send(group2(DUPLICATE, 3), f"00{VENDOR}02000000")
    trace.expect(group2(DUPLICATE, 3), f"80{VENDOR}{SERIAL}")
    trace.wait(10)
    return trace
