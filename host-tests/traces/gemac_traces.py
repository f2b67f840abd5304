"""The traces of the GEMAC sensors, written from the manual of 2021 (version 1.7); the older types from the German one."""

from collections.abc import Iterator

import gemac_memory_traces
import wire
from gemac import protocol as p
from tracefile import MANUAL, ONE_AXIS, SAVING_US, TWO_AXIS, Trace

OLDER = "written from GEMAC Bedienungsanleitung 230xx-HB-1-2-D (IS1D 00 P20, IS2D 90 P20)"


def all_traces() -> Iterator[Trace]:
    """Every trace."""
    yield boot_up("is2", MANUAL, TWO_AXIS)
    yield boot_up("is2d", OLDER, TWO_AXIS)
    yield boot_up("is2dm", OLDER, TWO_AXIS)
    yield boot_up("is2tk", MANUAL, TWO_AXIS)
    yield read_all("is2", MANUAL, TWO_AXIS)
    yield read_all("is1", MANUAL, ONE_AXIS)
    yield read_all("is1d", OLDER, ONE_AXIS)
    yield read_all("is1dm", OLDER, ONE_AXIS)
    yield read_all("is1tk", MANUAL, ONE_AXIS)
    yield write_all("is2", TWO_AXIS)
    yield write_all("is1", ONE_AXIS)
    yield identifiers()
    yield modes("is2", TWO_AXIS)
    yield modes("is1", ONE_AXIS)
    yield zero_two_axis()
    yield zero_one_axis()
    yield from gemac_memory_traces.all_traces()


def boot_up(product: str, manual: str, scene: str) -> Trace:
    """Boot-up after power-up and after RESET, alive, versions."""
    trace = Trace(
        f"{product}-boot-up",
        f"{manual}, boot-up message (table 16), product and version (table 18)",
        scene=scene,
        serial=123456,
    )
    expected, product = trace.expected, trace.product
    trace.note("Silent until the first frame, which is not answered; then two boot-up messages.")
    trace.boot((expected.set_id, bytes([p.ANGLES])))
    trace.poll()
    trace.note("Product number and revision; serial number and software version.")
    trace.ask(b"\x03", bytes([0x03, expected.status]) + p.u32(product.product_number) + p.u16(p.REVISION))
    trace.ask(b"\x04", bytes([0x04, expected.status]) + p.u32(trace.serial) + product.version)
    trace.note("FFh without data: one alive message. With other data than 'RESET': the same, and CmdParamError.")
    trace.ask(b"\xff", expected.boot_message())
    expected.errors = p.CMD_ERROR
    trace.ask(b"\xffRESEX", expected.boot_message())
    trace.ask(b"\xffRES", expected.boot_message())
    trace.note("RESET clears the error; the sensor detects the bit rate again, so it is silent until there is traffic.")
    trace.reset()
    trace.status()
    trace.note("RESET with a further byte, which is discarded.")
    trace.silent(expected.set_id, b"\xffRESET!")
    trace.wait(200)
    trace.boot((0x123, bytes(8)))
    trace.poll()
    return trace


def read_all(product: str, manual: str, scene: str) -> Trace:
    """Every read request, without and with extra bytes."""
    trace = Trace(f"{product}-read-all", f"{manual}, tables for request and reply frames, factory values", scene=scene)
    trace.boot()
    for extra in (b"", b"\xaa\xbb\xcc\xdd\xee\xff\x00"):
        trace.note("Further data bytes are discarded." if extra else "Every read code.")
        expected = trace.expected
        trace.ask(b"\x00" + extra, expected.angles_reply(trace.measured))
        trace.acknowledged(b"\x02" + extra)
        trace.ask(b"\x03" + extra, bytes([0x03, expected.status]) + p.u32(trace.product.product_number) + p.u16(p.REVISION))
        trace.ask(b"\x04" + extra, bytes([0x04, expected.status]) + p.u32(trace.serial) + trace.product.version)
        for parameter in trace.product.parameters:
            trace.ask(bytes([parameter.read]) + extra, expected.read_reply(parameter))
    return trace


def write_all(product: str, scene: str) -> Trace:
    """Every parameter written and read back, limits included; DefaultParam follows."""
    trace = Trace(f"{product}-write-all", f"{MANUAL}, sections 9.5.2 (DefaultParam, AutobaudDetection) and 9.10", scene=scene)
    values = {
        p.SET_ID: (p.u32(0x7FF), p.u32(p.EXTENDED | 0x361)),
        p.REPLY_ID: (p.u32(0x000), p.u32(p.EXTENDED | 0x1FFF_FFFF)),
        p.SYNC_ID: (p.u32(0x080), p.u32(p.EXTENDED)),
        p.BAUD_RATE: tuple(bytes([code]) for code in range(1, 11)),
        p.BUS_OFF_RECOVERY: (b"\x01",),
        p.CYCLIC_TIME: (p.u16(1), p.u16(65535)),
        p.FILTER: tuple(p.filter_value(*v) for v in ((100, 2), (8000, 2), (100, 1), (25000, 1), (100, 0), (25000, 0), (2000, 0))),
        p.ZERO_OFFSET: (p.u16(1), p.u16(35999)),
        p.ZERO_OFFSET_X: (p.u16(-9000), p.u16(9000)),
        p.ZERO_OFFSET_Y: (p.u16(9000), p.u16(-9000)),
    }
    trace.boot()
    for parameter in trace.product.parameters:
        if parameter == p.CYCLIC_MODE:  # has its own trace
            continue
        trace.note(f"{parameter.name}: accepted and read back; DefaultParam is set again with the factory value.")
        for value in (*values[parameter], parameter.factory):
            trace.write(parameter, value)
    trace.note("All at once; one factory value alone does not set DefaultParam again.")
    for parameter in (p.BUS_OFF_RECOVERY, p.CYCLIC_TIME):
        trace.write(parameter, values[parameter][0])
    trace.write(p.CYCLIC_TIME, p.CYCLIC_TIME.factory)
    trace.write(p.BUS_OFF_RECOVERY, p.BUS_OFF_RECOVERY.factory)
    return trace


def identifiers() -> Trace:
    """New identifiers: not yet in force, lost without SAVE, in force after SAVE and RESET, 29 bits."""
    trace = Trace(
        "is2-identifiers",
        f"{MANUAL}, sections 9.7 (effective after reboot), 9.10.2 (table 23) and 9.10.8",
        scene=TWO_AXIS,
        tolerance_us=SAVING_US,
    )
    expected = trace.expected

    def write_ids(set_id: int, reply_id: int, sync_id: int) -> None:
        for parameter, value in ((p.SET_ID, set_id), (p.REPLY_ID, reply_id), (p.SYNC_ID, sync_id)):
            trace.write(parameter, p.u32(value))

    trace.boot()
    trace.note("Written identifiers are read back but not in force. Alive contains the set id in force.")
    write_ids(0x400, p.EXTENDED | 0x1ABC_DEF1, p.EXTENDED | 0x100)
    trace.poll()
    trace.sync()
    trace.ask(b"\xff", expected.boot_message())
    trace.silent(0x400, b"\x00")
    trace.silent(p.EXTENDED | 0x100)
    trace.note("RESET without SAVE: as before.")
    expected.load_values()
    trace.reset()
    trace.read(p.SET_ID)
    trace.read(p.REPLY_ID)
    trace.read(p.SYNC_ID)
    trace.note("An identifier of another frame type is refused; the same number in the other format is another identifier.")
    trace.refused(b"\x20" + p.u32(0x301))
    trace.refused(b"\x21" + p.u32(0x100))
    trace.refused(b"\x22" + p.u32(0x300))
    trace.status()
    trace.write(p.SYNC_ID, p.u32(p.EXTENDED | 0x300))
    trace.note("Bits 11..30 of an 11-bit identifier must be zero.")
    trace.refused(b"\x20" + p.u32(0x800))
    trace.refused(b"\x20" + p.u32(0x4000_0361))
    trace.read(p.SET_ID)
    trace.status()
    trace.note("With SAVE: in force after RESET. The reply id has 29 bits.")
    write_ids(0x400, p.EXTENDED | 0x1ABC_DEF1, p.EXTENDED | 0x100)
    trace.save()
    trace.poll()
    trace.reset()
    trace.poll()
    trace.sync()
    trace.silent(0x300, b"\x00")
    trace.silent(p.EXTENDED | 0x400, b"\x00")
    trace.silent(0x100)
    trace.note("A 29-bit set id, the example 361h of the manual; in boot-up and alive bit 31 is set.")
    write_ids(p.EXTENDED | 0x361, 0x7FF, 0x080)
    trace.save()
    trace.reset()
    trace.ask(b"\xff", expected.boot_message())
    trace.poll()
    trace.sync()
    trace.silent(0x361, b"\x00")
    trace.read(p.SET_ID)
    return trace


def modes(product: str, scene: str) -> Trace:
    """Polling, sync and cyclic mode at once, and the counter."""
    trace = Trace(
        f"{product}-modes",
        f"{MANUAL}, section 9.9 (tables 20 to 22), counter in cyclic mode",
        scene=scene,
    )
    expected = trace.expected
    trace.boot()
    trace.note("Without cyclic mode there is no counter.")
    trace.poll()
    trace.sync()
    trace.note("A sync frame with data, a remote frame and the other format are ignored.")
    trace.silent(expected.sync_id, b"\x00")
    trace.silent(expected.sync_id, remote_dlc=0)
    trace.silent(p.EXTENDED | expected.sync_id)
    trace.note("Cyclic mode at 100 ms: the counter is 0 until the first period has passed, then 1.")
    trace.write(p.CYCLIC_TIME, p.u16(100))
    started = switch_on(trace)
    trace.poll(0)
    for number in range(1, 6):
        cyclic_frame(trace, number, started + 100_000 * number)
        trace.wait(20)
        trace.poll(number)
        trace.wait(10)
        trace.sync(number)
    trace.note("Cyclic mode on while it is on changes nothing.")
    trace.write(p.CYCLIC_MODE, b"\x01")
    cyclic_frame(trace, 6, started + 600_000)
    trace.note("Off: no frames, no counter. On again: the counter starts at 0.")
    trace.wait(10)
    trace.write(p.CYCLIC_MODE, b"\x00")
    trace.wait(250)
    trace.poll()
    trace.sync()
    started = switch_on(trace)
    trace.poll(0)
    for number in range(1, 3):
        cyclic_frame(trace, number, started + 100_000 * number)
    trace.wait(10)
    trace.write(p.CYCLIC_MODE, b"\x00")
    trace.wait(300)
    trace.status()
    return trace


def switch_on(trace: Trace) -> int:
    """Switches cyclic mode on; returns the time in us at which the sensor has received the request."""
    request = bytes([p.CYCLIC_MODE.write, 1])
    started = trace.now + trace.bit_us * wire.frame_bits(trace.expected.set_id, request)
    trace.write(p.CYCLIC_MODE, b"\x01")
    return started


def cyclic_frame(trace: Trace, number: int, due_us: int) -> None:
    """A cyclic frame at the end of its period."""
    trace.expect(trace.expected.angles_reply(trace.measured, number), due_us)


def zero_two_axis() -> Trace:
    """Zero offsets of a 2-axis type: written, automatic, clamped."""
    trace = Trace("is2-zero", f"{MANUAL}, sections 9.2 and 9.10.6", scene="60.00,-20.00", tolerance_us=SAVING_US)
    trace.boot()
    trace.poll()
    for axis, name in enumerate("XY"):
        parameter = trace.product.offset(axis)
        trace.note(f"Offsets of {name}: added to the measured angle, the sum stays within -9000..9000.")
        for value in (1, -1, 5000, 9000, -9000):
            trace.write(parameter, p.u16(value))
            trace.poll()
        trace.note(f"Automatic zero of {name}: the request without parameters.")
        automatic(trace, axis)
        trace.note(f"Out of range for {name}: refused, nothing changes.")
        for value in (9001, -9001):
            trace.refused(bytes([parameter.write]) + p.u16(value))
        trace.refused(bytes([parameter.write, 0x01]))
        trace.status()
        trace.read(parameter)
    trace.poll()
    trace.note("SAVE keeps the offsets; they also apply to the new pose.")
    trace.save()
    trace.power_cycle()
    trace.boot()
    trace.poll()
    trace.move("61.23,-18.77")
    trace.poll()
    trace.note("Automatic zero again: it uses the measured angle, not the reported one.")
    automatic(trace, 0)
    automatic(trace, 1)
    return trace


def automatic(trace: Trace, axis: int) -> None:
    """Automatic zero adjustment of an axis."""
    parameter = trace.product.offset(axis)
    trace.expected.values[parameter] = trace.expected.automatic_offset(trace.measured[axis])
    trace.acknowledged(bytes([parameter.write]))
    trace.read(parameter)
    trace.poll()


def zero_one_axis() -> Trace:
    """The zero offset of a 1-axis type: written, automatic, wrapped."""
    trace = Trace("is1-zero", f"{MANUAL}, sections 9.2 and 9.10.6", scene="350.50,10.00")
    trace.boot()
    trace.poll()
    trace.note("The offset is added, modulo 36000.")
    for value in (1, 949, 950, 18000, 35999, 0):
        trace.write(p.ZERO_OFFSET, p.u16(value))
        trace.poll()
    trace.note("Automatic zero.")
    automatic(trace, 0)
    trace.move("0.25,10.00")
    trace.poll()
    automatic(trace, 0)
    trace.note("Out of range: refused.")
    trace.refused(b"\x28" + p.u16(36000))
    trace.refused(b"\x28\x00")
    trace.status()
    trace.read(p.ZERO_OFFSET)
    return trace
