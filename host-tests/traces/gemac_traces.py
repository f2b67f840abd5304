"""The traces of the GEMAC sensors, written from the manual of 2021 (version 1.7); the older types from the German one."""

from collections.abc import Iterator

import wire
from gemac import protocol as p
from tracefile import Trace

MANUAL = "written from GEMAC user manual 1.7 (2021-07-30)"
OLDER = "written from GEMAC Bedienungsanleitung 230xx-HB-1-2-D (IS1D 00 P20, IS2D 90 P20)"

# A save takes as long as the memory needs.
SAVING_US = 5000

TWO_AXIS = "12.34,-5.67"
ONE_AXIS = "10.65,3.00"  # the example of section 9.9.1: 1065


def all_traces() -> Iterator[Trace]:
    """Every trace."""
    yield boot_up("is2", MANUAL, TWO_AXIS)
    yield boot_up("is2d", OLDER, TWO_AXIS)
    yield read_all("is2", MANUAL, TWO_AXIS)
    yield read_all("is1", MANUAL, ONE_AXIS)
    yield read_all("is1d", OLDER, ONE_AXIS)
    yield write_all("is2", TWO_AXIS)
    yield write_all("is1", ONE_AXIS)
    yield identifiers()
    yield modes("is2", TWO_AXIS)
    yield modes("is1", ONE_AXIS)
    yield zero_two_axis()
    yield zero_one_axis()
    yield errors()
    yield errors_one_axis()
    yield load()
    yield power_cycle()
    yield memory_damaged()


def boot_up(model: str, manual: str, scene: str) -> Trace:
    """Boot-up after power-up and after RESET, alive, versions."""
    trace = Trace(
        f"{model}-boot-up",
        f"{manual}, boot-up message (table 16), product and version (table 18)",
        scene=scene,
        serial=123456,
    )
    book, model_data = trace.book, trace.model
    trace.note("Silent until the first frame, which is not answered; then two boot-up messages.")
    trace.boot((book.set_id, bytes([p.ANGLES])))
    trace.poll()
    trace.note("Product number and revision; serial number and software version.")
    trace.ask(b"\x03", bytes([0x03, book.status]) + p.u32(model_data.product) + p.u16(p.REVISION))
    trace.ask(b"\x04", bytes([0x04, book.status]) + p.u32(trace.serial) + model_data.version)
    trace.note("FFh without data: one alive message. With other data than 'RESET': the same, and CmdParamError.")
    trace.ask(b"\xff", book.boot_message())
    book.errors = p.CMD_ERROR
    trace.ask(b"\xffRESEX", book.boot_message())
    trace.ask(b"\xffRES", book.boot_message())
    trace.note("RESET clears the error; the sensor detects again, so it is silent until there is traffic.")
    trace.reset()
    trace.status()
    trace.note("RESET with a further byte, which is discarded.")
    trace.silent(book.set_id, b"\xffRESET!")
    trace.wait(200)
    trace.boot((0x123, bytes(8)))
    trace.poll()
    return trace


def read_all(model: str, manual: str, scene: str) -> Trace:
    """Every reading request, plain and with extra bytes."""
    trace = Trace(f"{model}-read-all", f"{manual}, tables for request and reply frames, factory values", scene=scene)
    trace.boot()
    for extra in (b"", b"\xaa\xbb\xcc\xdd\xee\xff\x00"):
        trace.note("Further data bytes are discarded." if extra else "Every code that reads.")
        book = trace.book
        trace.ask(b"\x00" + extra, book.angles_reply(trace.measured))
        trace.acknowledged(b"\x02" + extra)
        trace.ask(b"\x03" + extra, bytes([0x03, book.status]) + p.u32(trace.model.product) + p.u16(p.REVISION))
        trace.ask(b"\x04" + extra, bytes([0x04, book.status]) + p.u32(trace.serial) + trace.model.version)
        for parameter in trace.model.parameters:
            trace.ask(bytes([parameter.read]) + extra, book.read_reply(parameter))
    return trace


def write_all(model: str, scene: str) -> Trace:
    """Every parameter written and read back, limits included; DefaultParam follows."""
    trace = Trace(f"{model}-write-all", f"{MANUAL}, sections 9.5.2 (DefaultParam, AutobaudDetection) and 9.10", scene=scene)
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
    for parameter in trace.model.parameters:
        if parameter == p.CYCLIC_MODE:  # has a trace of its own
            continue
        trace.note(f"{parameter.name}: accepted and read back; DefaultParam comes back with the factory value.")
        for value in (*values[parameter], parameter.factory):
            trace.write(parameter, value)
    trace.note("All at once; one factory value alone does not bring DefaultParam back.")
    for parameter in (p.BUS_OFF_RECOVERY, p.CYCLIC_TIME):
        trace.write(parameter, values[parameter][0])
    trace.write(p.CYCLIC_TIME, p.CYCLIC_TIME.factory)
    trace.write(p.BUS_OFF_RECOVERY, p.BUS_OFF_RECOVERY.factory)
    return trace


def identifiers() -> Trace:
    """New identifiers: pending, lost without SAVE, in force after SAVE and RESET, 29 bits."""
    trace = Trace(
        "is2-identifiers",
        f"{MANUAL}, sections 9.7 (effective after reboot), 9.10.2 (table 23) and 9.10.8",
        scene=TWO_AXIS,
        tolerance_us=SAVING_US,
    )
    book = trace.book

    def write_ids(set_id: int, reply_id: int, sync_id: int) -> None:
        for parameter, value in ((p.SET_ID, set_id), (p.REPLY_ID, reply_id), (p.SYNC_ID, sync_id)):
            trace.write(parameter, p.u32(value))

    trace.boot()
    trace.note("Pending: read back, but not in force. Alive names the set id in force.")
    write_ids(0x400, p.EXTENDED | 0x1ABC_DEF1, p.EXTENDED | 0x100)
    trace.poll()
    trace.sync()
    trace.ask(b"\xff", book.boot_message())
    trace.silent(0x400, b"\x00")
    trace.silent(p.EXTENDED | 0x100)
    trace.note("RESET without SAVE: as before.")
    book.load_values()
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
    trace.note("A 29-bit set id, the manual's example 361h; boot-up and alive name it with bit 31.")
    write_ids(p.EXTENDED | 0x361, 0x7FF, 0x080)
    trace.save()
    trace.reset()
    trace.ask(b"\xff", book.boot_message())
    trace.poll()
    trace.sync()
    trace.silent(0x361, b"\x00")
    trace.read(p.SET_ID)
    return trace


def modes(model: str, scene: str) -> Trace:
    """Polling, sync and cyclic mode at once, and the counter."""
    trace = Trace(
        f"{model}-modes",
        f"{MANUAL}, section 9.9 (tables 20 to 22), counter in cyclic mode",
        scene=scene,
    )
    book = trace.book
    trace.boot()
    trace.note("Without cyclic mode there is no counter.")
    trace.poll()
    trace.sync()
    trace.note("A sync frame with data, a remote frame and the other format are ignored.")
    trace.silent(book.sync_id, b"\x00")
    trace.silent(book.sync_id, remote_dlc=0)
    trace.silent(p.EXTENDED | book.sync_id)
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
    """Cyclic mode on; when the sensor has received it, in us."""
    request = bytes([p.CYCLIC_MODE.write, 1])
    started = trace.now + trace.bit_us * wire.frame_bits(trace.book.set_id, request)
    trace.write(p.CYCLIC_MODE, b"\x01")
    return started


def cyclic_frame(trace: Trace, number: int, due_us: int) -> None:
    """A cyclic frame when its period has passed."""
    trace.expect(trace.book.angles_reply(trace.measured, number), due_us)


def zero_two_axis() -> Trace:
    """Zero offsets of a 2-axis type: written, automatic, clamped."""
    trace = Trace("is2-zero", f"{MANUAL}, sections 9.2 and 9.10.6", scene="60.00,-20.00", tolerance_us=SAVING_US)
    trace.boot()
    trace.poll()
    for axis, name in enumerate("XY"):
        parameter = trace.model.offset(axis)
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
    trace.note("The offsets are kept by SAVE; the new pose shows against them.")
    trace.save()
    trace.power_cycle()
    trace.boot()
    trace.poll()
    trace.move("61.23,-18.77")
    trace.poll()
    trace.note("Automatic zero again: it is the measured angle that counts, not the one that is shown.")
    automatic(trace, 0)
    automatic(trace, 1)
    return trace


def automatic(trace: Trace, axis: int) -> None:
    """Automatic zero adjustment of an axis."""
    parameter = trace.model.offset(axis)
    trace.book.values[parameter] = trace.book.automatic_offset(trace.measured[axis])
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


def errors() -> Trace:
    """Every error of section 9.5.2 that a 2-axis type of the classic line can show."""
    trace = Trace("is2-errors", f"{MANUAL}, section 9.5.2 (status byte)", scene=TWO_AXIS, tolerance_us=SAVING_US)
    book = trace.book
    trace.boot()
    trace.note("CmdParamError: invalid code. It stays in every reply until 02h has shown it.")
    trace.refused(b"\x01")
    trace.poll()
    trace.read(p.CYCLIC_TIME)
    trace.sync()
    trace.status()
    trace.status()
    trace.note("CmdParamError: too few data bytes.")
    for request in (b"\x20\x00\x04\x00", b"\x23", b"\x25\x64", b"\x26", b"\x27\xd0\x07", b"\x28\x01", b"\x29\x01"):
        trace.refused(request)
    trace.status()
    trace.note("CmdParamError: invalid values.")
    for request in (
        b"\x23\x0b",
        b"\x24\x02",
        b"\x25\x00\x00",
        b"\x26\x02",
        b"\x27" + p.filter_value(99, 1),
        b"\x27" + p.filter_value(25001, 1),
        b"\x27" + p.filter_value(8001, 2),
        b"\x27" + p.filter_value(99, 0),
        b"\x27" + p.filter_value(2000, 3),
        b"\x28" + p.u16(9001),
        b"\x40LOAX",
        b"\x40LOA",
        b"\x50save",
        b"\x50",
    ):
        trace.refused(request)
    trace.status()
    for parameter in trace.model.parameters:
        trace.read(parameter)
    trace.note("A request without data: no code to echo, so no reply, but CmdParamError.")
    trace.silent(book.set_id)
    book.errors = p.CMD_ERROR
    trace.status()
    trace.note("Not for this sensor, or remote: ignored, no error.")
    trace.silent(0x302, b"\x01")
    trace.silent(p.EXTENDED | book.set_id, b"\x01")
    trace.silent(book.set_id, remote_dlc=1)
    trace.silent(book.reply_id, b"\x01")
    trace.status()
    trace.note("EEPROMError: a save that fails sets it and CmdParamError.")
    trace.write(p.CYCLIC_TIME, p.u16(500))
    trace.action("fail-writes on")
    book.errors = p.CMD_ERROR | p.EEPROM_ERROR
    trace.save()
    trace.poll()
    trace.status()
    trace.status()
    trace.read(p.CYCLIC_TIME)
    trace.action("fail-writes off")
    trace.save()
    trace.note("SensorErrorX and SensorErrorY beyond 85 deg; they go by themselves.")
    trace.move("87.00,0.00")
    trace.status()
    trace.poll()
    trace.move("0.00,-88.00")
    trace.poll()
    trace.move("84.50,0.00")
    trace.poll()
    trace.note("The measured angle counts, not the one that is shown.")
    trace.write(p.ZERO_OFFSET_X, p.u16(550))
    trace.poll()
    trace.move("87.00,0.00")
    trace.write(p.ZERO_OFFSET_X, p.u16(-8700))
    trace.poll()
    return trace


def errors_one_axis() -> Trace:
    """What differs on a 1-axis type: the cross slope, no second axis."""
    trace = Trace("is1-errors", f"{MANUAL}, section 9.5.2 (status byte), tables 14 and 17", scene=ONE_AXIS)
    trace.boot()
    trace.note("There is no second axis: 19h and 29h are invalid.")
    for request in (b"\x19", b"\x29", b"\x29\x01\x00"):
        trace.refused(request)
    trace.status()
    trace.note("SensorError beyond 45 deg cross slope, at any angle; it goes by itself.")
    for scene in ("10.65,46.00", "123.45,-50.00", "200.00,-44.00", "300.00,44.50"):
        trace.move(scene)
        trace.poll()
        trace.status()
    return trace


def load() -> Trace:
    """LOAD: at once but for identifiers and bit rate, and for good."""
    trace = Trace("is2-load", f"{MANUAL}, sections 9.8 and 9.10.7 (tables 19 and 24)", scene=TWO_AXIS, tolerance_us=SAVING_US)
    trace.boot()
    for parameter, value in (
        (p.SET_ID, p.u32(0x500)),
        (p.REPLY_ID, p.u32(0x501)),
        (p.SYNC_ID, p.u32(0x502)),
        (p.BUS_OFF_RECOVERY, b"\x01"),
        (p.CYCLIC_TIME, p.u16(1000)),
        (p.FILTER, p.filter_value(5000, 1)),
        (p.ZERO_OFFSET_X, p.u16(-1234)),
        (p.ZERO_OFFSET_Y, p.u16(567)),
    ):
        trace.write(parameter, value, read_back=False)
    trace.save()
    trace.reset()
    trace.poll()
    trace.write(p.CYCLIC_TIME, p.u16(60000))
    trace.write(p.CYCLIC_MODE, b"\x01", read_back=False)
    trace.note("A wrong signature is refused.")
    trace.refused(b"\x40load")
    trace.status()
    trace.note("LOAD: factory values at once, on the identifiers in force; cyclic mode and offsets are off.")
    trace.book.load_values()
    trace.acknowledged(b"\x40LOAD")
    for parameter in trace.model.parameters:
        trace.read(parameter)
    trace.poll()
    trace.ask(b"\xff", trace.book.boot_message())
    trace.silent(0x300, b"\x00")
    trace.note("RESET: the factory identifiers too, without SAVE.")
    trace.reset()
    for parameter in trace.model.parameters:
        trace.read(parameter)
    trace.sync()
    return trace


def power_cycle() -> Trace:
    """What a power cycle takes away and what it leaves."""
    trace = Trace("is2-power-cycle", f"{MANUAL}, section 9.10.8 (table 25)", scene=TWO_AXIS, tolerance_us=SAVING_US)
    trace.boot()
    trace.note("Written, not saved: gone.")
    trace.write(p.CYCLIC_TIME, p.u16(333))
    trace.write(p.ZERO_OFFSET_X, p.u16(100))
    trace.write(p.SET_ID, p.u32(0x320))
    trace.book.load_values()
    trace.power_cycle()
    trace.boot()
    for parameter in trace.model.parameters:
        trace.read(parameter)
    trace.poll()
    trace.note("Saved: kept, on the saved identifier. DefaultParam is clear in the boot-up message.")
    trace.write(p.CYCLIC_TIME, p.u16(333))
    trace.write(p.ZERO_OFFSET_X, p.u16(100))
    trace.write(p.SET_ID, p.u32(0x320))
    trace.save()
    trace.power_cycle()
    trace.boot()
    for parameter in trace.model.parameters:
        trace.read(parameter)
    trace.poll()
    trace.note("An error does not survive; a later change that is not saved leaves the saved value.")
    trace.refused(b"\x77")
    trace.acknowledged(b"\x25" + p.u16(444))
    trace.power_cycle()
    trace.boot()
    trace.read(p.CYCLIC_TIME)
    return trace


def memory_damaged() -> Trace:
    """EEPROMError at boot: the older image, then none."""
    trace = Trace("is2-memory-damaged", f"{MANUAL}, sections 9.5.2 and 9.8", scene=TWO_AXIS, tolerance_us=SAVING_US)
    book = trace.book
    trace.boot()
    for value in (111, 222):
        trace.write(p.CYCLIC_TIME, p.u16(value))
        trace.save()
    trace.note("The newest image is damaged: the older one, and EEPROMError until 02h has shown it.")
    trace.action("corrupt newest-image")
    book.values[p.CYCLIC_TIME] = p.u16(111)
    trace.power_cycle()
    book.errors = p.EEPROM_ERROR
    trace.boot()
    trace.read(p.CYCLIC_TIME)
    trace.poll()
    trace.status()
    trace.status()
    trace.note("A save makes the memory whole again.")
    trace.write(p.CYCLIC_TIME, p.u16(333))
    trace.save()
    trace.power_cycle()
    trace.boot()
    trace.read(p.CYCLIC_TIME)
    trace.status()
    return trace
