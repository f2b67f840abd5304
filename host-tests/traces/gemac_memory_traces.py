"""The traces of the GEMAC sensors for errors, LOAD and nonvolatile memory, written from the manual of 2021."""

from collections.abc import Iterator

from gemac import protocol as p

from tracefile import MANUAL, ONE_AXIS, SAVING_US, TWO_AXIS, Trace


def all_traces() -> Iterator[Trace]:
    """Every trace of this file."""
    yield errors()
    yield errors_one_axis()
    yield load()
    yield power_cycle()
    yield memory_damaged()


def errors() -> Trace:
    """Every error of section 9.5.2 that a 2-axis type of the classic line can show."""
    trace = Trace("is2-errors", f"{MANUAL}, section 9.5.2 (status byte)", scene=TWO_AXIS, tolerance_us=SAVING_US)
    expected = trace.expected
    trace.boot()
    trace.note("CmdParamError: invalid code. It is set in every reply up to that to 02h.")
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
    for parameter in trace.product.parameters:
        trace.read(parameter)
    trace.note("A request without data: no code to echo, so no reply, but CmdParamError.")
    trace.silent(expected.set_id)
    expected.errors = p.CMD_ERROR
    trace.status()
    trace.note("Not for this sensor, or remote: ignored, no error.")
    trace.silent(0x302, b"\x01")
    trace.silent(p.EXTENDED | expected.set_id, b"\x01")
    trace.silent(expected.set_id, remote_dlc=1)
    trace.silent(expected.reply_id, b"\x01")
    trace.status()
    trace.note("EEPROMError: a save that fails sets it and CmdParamError.")
    trace.write(p.CYCLIC_TIME, p.u16(500))
    trace.action("fail-writes on")
    expected.errors = p.CMD_ERROR | p.EEPROM_ERROR
    trace.save()
    trace.poll()
    trace.status()
    trace.status()
    trace.read(p.CYCLIC_TIME)
    trace.action("fail-writes off")
    trace.save()
    trace.note("SensorErrorX and SensorErrorY beyond 85 deg; they are cleared without a request.")
    trace.move("87.00,0.00")
    trace.status()
    trace.poll()
    trace.move("0.00,-88.00")
    trace.poll()
    trace.move("84.50,0.00")
    trace.poll()
    trace.note("The measured angle is judged, not the reported one.")
    trace.write(p.ZERO_OFFSET_X, p.u16(550))
    trace.poll()
    trace.move("87.00,0.00")
    trace.write(p.ZERO_OFFSET_X, p.u16(-8700))
    trace.poll()
    return trace


def errors_one_axis() -> Trace:
    """The differences of a 1-axis type: the cross slope, no second axis."""
    trace = Trace("is1-errors", f"{MANUAL}, section 9.5.2 (status byte), tables 14 and 17", scene=ONE_AXIS)
    trace.boot()
    trace.note("There is no second axis: 19h and 29h are invalid.")
    for request in (b"\x19", b"\x29", b"\x29\x01\x00"):
        trace.refused(request)
    trace.status()
    trace.note("SensorError beyond 45 deg cross slope, at any angle; it is cleared without a request.")
    for scene in ("10.65,46.00", "123.45,-50.00", "200.00,-44.00", "300.00,44.50"):
        trace.move(scene)
        trace.poll()
        trace.status()
    return trace


def load() -> Trace:
    """LOAD: in force at once except identifiers and bit rate, also after a power cycle."""
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
    trace.expected.load_values()
    trace.acknowledged(b"\x40LOAD")
    for parameter in trace.product.parameters:
        trace.read(parameter)
    trace.poll()
    trace.ask(b"\xff", trace.expected.boot_message())
    trace.silent(0x300, b"\x00")
    trace.note("RESET: also the factory identifiers, without SAVE.")
    trace.reset()
    for parameter in trace.product.parameters:
        trace.read(parameter)
    trace.sync()
    return trace


def power_cycle() -> Trace:
    """The state before and after power cycles."""
    trace = Trace("is2-power-cycle", f"{MANUAL}, section 9.10.8 (table 25)", scene=TWO_AXIS, tolerance_us=SAVING_US)
    trace.boot()
    trace.note("Written, not saved: lost.")
    trace.write(p.CYCLIC_TIME, p.u16(333))
    trace.write(p.ZERO_OFFSET_X, p.u16(100))
    trace.write(p.SET_ID, p.u32(0x320))
    trace.expected.load_values()
    trace.power_cycle()
    trace.boot()
    for parameter in trace.product.parameters:
        trace.read(parameter)
    trace.poll()
    trace.note("Saved: kept, with the saved identifier. DefaultParam is clear in the boot-up message.")
    trace.write(p.CYCLIC_TIME, p.u16(333))
    trace.write(p.ZERO_OFFSET_X, p.u16(100))
    trace.write(p.SET_ID, p.u32(0x320))
    trace.save()
    trace.power_cycle()
    trace.boot()
    for parameter in trace.product.parameters:
        trace.read(parameter)
    trace.poll()
    trace.note("An error does not survive; after a later change without SAVE the saved value is read.")
    trace.refused(b"\x77")
    trace.acknowledged(b"\x25" + p.u16(444))
    trace.power_cycle()
    trace.boot()
    trace.read(p.CYCLIC_TIME)
    return trace


def memory_damaged() -> Trace:
    """EEPROMError at boot: the older record, then no error."""
    trace = Trace("is2-memory-damaged", f"{MANUAL}, sections 9.5.2 and 9.8", scene=TWO_AXIS, tolerance_us=SAVING_US)
    expected = trace.expected
    trace.boot()
    for value in (111, 222):
        trace.write(p.CYCLIC_TIME, p.u16(value))
        trace.save()
    trace.note("The newest record is damaged: the older one is used, and EEPROMError is set up to the reply to 02h.")
    trace.action("corrupt newest-image")
    expected.values[p.CYCLIC_TIME] = p.u16(111)
    trace.power_cycle()
    expected.errors = p.EEPROM_ERROR
    trace.boot()
    trace.read(p.CYCLIC_TIME)
    trace.poll()
    trace.status()
    trace.status()
    trace.note("A save replaces the damaged record.")
    trace.write(p.CYCLIC_TIME, p.u16(333))
    trace.save()
    trace.power_cycle()
    trace.boot()
    trace.read(p.CYCLIC_TIME)
    trace.status()
    return trace
