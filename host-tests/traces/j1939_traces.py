"""The traces of the IMS360 in J1939, written from SAE J1939-21, -71, -73 and -81 and the decisions in the document of the IMS360."""

from collections.abc import Iterator

import j1939_address_traces
from canopen_traces import IMS360, Trace
from j1939_frames import (
    ACCS,
    ARI,
    BAM_MS,
    CLAIM,
    COMPONENT,
    CONTROL,
    DATA,
    DM1,
    DM1_MS,
    ECU,
    EVERYONE,
    J1939Trace,
    NOBODY,
    NO_CODES,
    PROPRIETARY,
    QUIET,
    REQUEST,
    SAVE,
    SENSOR,
    SOFTWARE,
    SSI,
    SSI2,
    TESTER,
    code,
    component,
    identifier,
    little,
    packets,
    scaled,
)


def all_traces() -> Iterator[Trace]:
    """Every trace of this file."""
    yield switch()
    yield j1939_address_traces.claim()
    yield process_data()
    yield requests()
    yield broadcast()
    yield connection()
    yield parameters()
    yield trouble_codes()
    yield j1939_address_traces.commanded_address()
    yield j1939_address_traces.cannot_claim()


def switch() -> Trace:
    """From CANopen to J1939 and back."""
    trace = J1939Trace("switch", "7.2.36 of the SIKO IMS360 CANopen manual, J1939-81 and CiA 301", writes=QUIET)
    trace.claims()
    trace.wait(10)
    trace.note("Frames with 11 bits are neither answered nor obeyed.")
    for number, data in ((0x632, "4000100000000000"), (0x080, ""), (0x000, "8132"), (0x7E5, "5E00000000000000")):
        trace.send(number, data)
        trace.wait(10)
    trace.note("3100h:01 reads what was written. Back: 3100h:01 = 2, save, 2010h:01.")
    trace.parameter("4000310100000000", "4F00310101000000")
    trace.parameter("2F00310102000000", "6000310100000000")
    trace.saved(lambda: trace.parameter(*SAVE))
    trace.restarts()
    trace.expect(0x700 + IMS360, "00")
    trace.wait(10)
    trace.note("CANopen: frames with 29 bits are ignored.")
    trace.tell(REQUEST, little(CLAIM, 3))
    trace.wait(10)
    trace.ask("4000100000000000", "430010009A010407")
    trace.ask("4004210100000000", "4B04210100000000")
    return trace


def process_data() -> Trace:
    """The four groups, level: all numbers are exact."""
    trace = J1939Trace("process-data", "J1939-71, SSI2, SSI, ARI and ACCS", scene="0,0")
    fine = 2 * scaled(0, 1 / 32768, -250, 3) + "33FF"
    coarse = 3 * scaled(0, 0.002, -64, 2) + "C0FF"
    rates = 3 * scaled(0, 1 / 128, -250, 2) + "C0FF"
    forces = "".join(scaled(force, 0.01, -320, 2) for force in (0, 0, 9.80665)) + "C0FF"

    def fine_at(*times: int) -> None:
        for time in times:
            trace.at(time)
            trace.group(SSI2, fine)

    trace.note("SSI2 every 10 ms: compensation not available, good; the latency of 2 Hz is more than 125 ms.")
    trace.claims()
    fine_at(10, 20, 30)
    trace.note("The others on request, to us and by all; SSI2 too, between two of the cycle.")
    for count, (group, data) in enumerate(((SSI, coarse), (ARI, rates), (ACCS, forces), (SSI2, fine))):
        trace.at(33 + 10 * count)
        trace.request(group, (SENSOR, EVERYONE)[count % 2])
        trace.group(group, data)
        fine_at(40 + 10 * count)
    trace.note("SSI2 off. SSI with priority 5, every 20 ms from the write on.")
    trace.at(72)
    trace.tell(PROPRIETARY, "2B04210100000000", SENSOR)
    trace.group(PROPRIETARY, "6004210100000000", TESTER)
    trace.wait(20)
    trace.parameter("2F05210205000000", "6005210200000000")
    trace.tell(PROPRIETARY, "2B04210214000000", SENSOR)
    start = trace.now
    trace.group(PROPRIETARY, "6004210200000000", TESTER)
    for count in (1, 2, 3):
        trace.now = start + 20_000 * count
        trace.expect(identifier(SSI, priority=5), coarse)
    return trace


def requests() -> Trace:
    """Requests that are answered, refused and ignored."""
    trace = J1939Trace("requests", "J1939-21, 5.4.2 and 5.4.4", writes=QUIET)
    trace.claims()
    trace.wait(10)
    trace.note("Unknown groups are refused if the request was to us.")
    for group in (0xFEEE, 0xFECB, 0xEF00, 0xEA00, 0x3FFFF):
        trace.request(group)
        trace.refused(group)
        trace.wait(10)
    trace.note("By all, unknown groups are ignored; so are a request with two bytes, and one to another node.")
    trace.request(0xFEEE, EVERYONE)
    trace.wait(10)
    trace.tell(REQUEST, "EEFE", SENSOR)
    trace.wait(10)
    trace.request(0xFEEE, 0x81)
    trace.wait(10)
    trace.note("More than three bytes are the same.")
    trace.tell(REQUEST, "EEFE00FFFFFFFFFF", SENSOR)
    trace.refused(0xFEEE)
    trace.wait(10)
    trace.note("From 254, only the claim.")
    trace.request(SOFTWARE, SENSOR, NOBODY)
    trace.wait(10)
    trace.request(0xFEEE, SENSOR, NOBODY)
    trace.wait(10)
    trace.request(CLAIM, SENSOR, NOBODY)
    trace.group(CLAIM, trace.name_data)
    trace.wait(10)
    trace.note("Software identification in one frame, by all and to us: one field, 100Ah, and `*`.")
    for destination in (EVERYONE, SENSOR):
        trace.request(SOFTWARE, destination)
        trace.group(SOFTWARE, "01" + b"010000*".hex().upper())
        trace.wait(10)
    trace.note("DM1 on request, and once a second.")
    trace.request(DM1)
    trace.group(DM1, NO_CODES)
    trace.at(DM1_MS)
    trace.group(DM1, NO_CODES)
    return trace


def broadcast() -> Trace:
    """Identification by BAM."""
    trace = J1939Trace("bam", "J1939-21, 5.10.3.5, and J1939-71", writes=QUIET)
    trace.claims()
    trace.wait(10)
    for group, text in ((COMPONENT, component()), (ECU, "IMS360*1**Inclinometer*Plumbline*")):
        parts = packets(text.encode())
        trace.note(text)
        trace.request(group, EVERYONE)
        trace.group(CONTROL, f"20{little(len(text), 2)}{len(parts):02X}FF{little(group, 3)}")
        trace.tolerance(2000)  # 50 to 200 ms are permitted
        for part in parts:
            trace.wait(BAM_MS)
            trace.group(DATA, part)
        trace.tolerance(300)
        trace.wait(10)
    return trace


def connection() -> Trace:
    """Identification by RTS and CTS."""
    trace = J1939Trace("rts-cts", "J1939-21, 5.10.3, and J1939-71", writes=QUIET)
    trace.claims()
    trace.wait(10)
    text = component()
    parts = packets(text.encode())
    announced = f"{little(len(text), 2)}{len(parts):02X}FF{little(COMPONENT, 3)}"

    def begin() -> None:
        trace.request(COMPONENT)
        trace.group(CONTROL, "10" + announced, TESTER)
        trace.wait(10)

    def packet(number: int) -> None:
        trace.group(DATA, parts[number - 1], TESTER)

    trace.note("All packets at once; the end is acknowledged.")
    begin()
    trace.control("110301", COMPONENT)
    for number in (1, 2, 3):
        packet(number)
    trace.wait(10)
    trace.tell(CONTROL, "13" + announced, SENSOR)
    trace.wait(10)
    trace.note("One packet, a hold, the same one again, the last two; CTS beyond the end or for another group are ignored.")
    begin()
    trace.control("110101", COMPONENT)
    packet(1)
    trace.wait(10)
    trace.control("1100FF", COMPONENT)
    trace.wait(300)
    trace.control("110101", COMPONENT)
    packet(1)
    trace.wait(10)
    for text_, group in (("110202", ECU), ("110104", COMPONENT), ("110302", COMPONENT), ("110100", COMPONENT)):
        trace.control(text_, group)
        trace.wait(10)
    trace.control("110202", COMPONENT)
    packet(2)
    packet(3)
    trace.wait(10)
    trace.tell(CONTROL, "13" + announced, SENSOR)
    trace.wait(10)
    trace.note("RTS for a group that nobody wants here is aborted: no resources.")
    trace.control("100A0002FF", 0xFECA)
    trace.group(CONTROL, f"FF02FFFFFF{little(0xFECA, 3)}", TESTER)
    return trace


def parameters() -> Trace:
    """The bytes of an SDO in Proprietary A."""
    trace = J1939Trace("parameters", "J1939-21, Proprietary A, and CiA 301, 7.2.4", writes=QUIET)
    trace.claims()
    trace.wait(10)
    trace.note("Device type, cut-off frequency, the objects of J1939.")
    trace.parameter("4000100000000000", "430010009A010407")
    trace.parameter("4011310000000000", "4B113100D0070000")
    trace.parameter("2B113100401F0000", "6011310000000000")
    trace.parameter("4011310000000000", "4B113100401F0000")
    trace.parameter("4002210000000000", "4F02210080000000")
    trace.parameter("4005210100000000", "4F05210103000000")
    for sub, reply in enumerate(("4F%s01", "4F%s00", "4F%s00", "4F%s00", "4F%s91", "4F%s00", "4F%s00", "4B%sFF07", "43%s01"), 1):
        trace.parameter(f"400621{sub:02X}00000000", (reply % f"0621{sub:02X}").ljust(16, "0"))
    trace.note("No such object, no such sub-index, read-only, a wrong value.")
    trace.parameter("40FE5F0000000000", "80FE5F0000000206")
    trace.parameter("4002210100000000", "8002210111000906")
    trace.parameter("230621090A000000", "8006210902000106")
    trace.parameter("2B04210109000000", "8004210130000906")
    trace.note("1008h in segments.")
    trace.parameter("4008100000000000", "4108100006000000")
    trace.parameter("6000000000000000", "03494D5333363000")
    trace.note("To all, with seven bytes, from 254: ignored.")
    trace.tell(PROPRIETARY, "4000100000000000", EVERYONE)
    trace.wait(10)
    trace.tell(PROPRIETARY, "40001000000000", SENSOR)
    trace.wait(10)
    trace.tell(PROPRIETARY, "4000100000000000", SENSOR, NOBODY)
    trace.wait(10)
    trace.note("The reply goes to the node that asks.")
    trace.tell(PROPRIETARY, "4000100000000000", SENSOR, 0x42)
    trace.group(PROPRIETARY, "430010009A010407", 0x42)
    return trace


def trouble_codes() -> Trace:
    """DM1 once a second and with each change: pitch and roll beyond their range by an offset."""
    trace = J1939Trace("dm1", "J1939-73, 5.7.1", scene="0,0", writes=QUIET)
    trace.claims()
    trace.note("Each second.")
    trace.at(DM1_MS)
    trace.group(DM1, NO_CODES)
    trace.wait(100)

    def offset(index: int, degrees: int, *codes: str) -> None:
        """Writes 3210h or 3220h. DM1 follows with the next sample."""
        number = little(100 * degrees & 0xFFFF_FFFF, 4)
        low = index & 0xFF
        trace.tell(PROPRIETARY, f"23{low:02X}3200{number}", SENSOR)
        trace.group(PROPRIETARY, f"60{low:02X}320000000000", TESTER)
        trace.tolerance(8000)
        trace.wait(3)
        message = bytes.fromhex("04FF" + "".join(codes) if codes else "00FF00000000")
        if len(message) <= 8:
            trace.group(DM1, message.ljust(8, bytes([255])).hex().upper())
        else:
            parts = packets(message)
            trace.group(CONTROL, f"20{little(len(message), 2)}{len(parts):02X}FF{little(DM1, 3)}")
            for part in parts:
                trace.wait(BAM_MS)
                trace.group(DATA, part)
        trace.tolerance(300)
        trace.wait(60)

    trace.note("Pitch 100 deg, above: SPN 4976, FMI 0. The angle is sent, with figure of merit 1.")
    offset(0x3210, 100, code(4976, 0, 1))
    trace.request(SSI2)
    trace.group(SSI2, scaled(100, 1 / 32768, -250, 3) + scaled(0, 1 / 32768, -250, 3) + "37FF")
    trace.wait(10)
    trace.note("Roll -95 deg too, below: SPN 4977, FMI 1. Ten bytes by BAM.")
    offset(0x3220, -95, code(4976, 0, 1), code(4977, 1, 1))
    trace.note("Pitch in its range, then above again: the second appearance.")
    offset(0x3210, 0, code(4977, 1, 1))
    offset(0x3210, 100, code(4976, 0, 2), code(4977, 1, 1))
    trace.note("None.")
    offset(0x3220, 0, code(4976, 0, 2))
    offset(0x3210, 0)
    return trace
