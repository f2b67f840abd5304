"""Device parameters: ranges, refusals, DefaultParam, pending communication parameters, LOAD (sections 9.8 and 9.10)."""

from . import protocol as p
from .context import Context

IDS = (p.SET_ID, p.REPLY_ID, p.SYNC_ID)


def ranges(product: p.Product) -> dict[p.Parameter, tuple[list[bytes], list[bytes]]]:
    """The values of each parameter that must be accepted and refused: at the limits and beyond them (9.10)."""
    one_byte = [bytes([n]) for n in range(256)]
    table = {
        # Table 23 and its example; bits 11..30 of an 11-bit identifier must be zero (G15).
        **{
            parameter: (
                [p.u32(n) for n in (0, 0x7FF, 0x361, 0x8000_0361, 0x8000_0000, 0x9FFF_FFFF)],
                [p.u32(n) for n in (0x800, 0xFFFF, 0x1_0361, 0x1000_0361, 0x4000_0361, 0x7FFF_FFFF)],
            )
            for parameter in IDS
        },
        p.BAUD_RATE: (one_byte[:11], [b"\x0b", b"\x0c", b"\x80", b"\xff"]),
        p.BUS_OFF_RECOVERY: (one_byte[:2], [b"\x02", b"\x80", b"\xff"]),
        p.CYCLIC_TIME: ([p.u16(n) for n in (1, 2, 255, 256, 65534, 65535)], [p.u16(0)]),
        # The limits depend on the type (table 11), also with the filter off (G16).
        p.FILTER: (
            [p.filter_value(cf, ft) for ft, top in ((0, 25000), (1, 25000), (2, 8000)) for cf in (100, 101, top - 1, top)],
            [p.filter_value(cf, ft) for ft, top in ((0, 25000), (1, 25000), (2, 8000)) for cf in (0, 99, top + 1, 65535)]
            + [p.filter_value(25000, 2), p.filter_value(2000, 3), p.filter_value(2000, 255)],
        ),
    }
    for axis in range(product.axes):
        if product.axes == 1:
            good, bad = (0, 1, 18000, 35998, 35999), (36000, 36001, 65535)
        else:
            good, bad = (-9000, -8999, -1, 0, 1, 8999, 9000), (-32768, -9001, 9001, 32767)
        table[product.offset(axis)] = ([p.u16(n) for n in good], [p.u16(n) for n in bad])
    return table


def values(context: Context) -> None:
    """Every limit of every parameter is accepted and read back, every value beyond is refused."""
    with context.session() as session:
        for parameter, (good, bad) in ranges(session.product).items():
            for value in bad:
                session.refuse(f"{parameter.name} = {value.hex()}", bytes([parameter.write]) + value)
            for value in good:
                session.accept(parameter, value)
            for value in bad[:1]:
                session.refuse(f"{parameter.name} = {value.hex()} later", bytes([parameter.write]) + value)
            session.accept(parameter, parameter.factory, f"{parameter.name} to the factory value")
        session.accept(p.CYCLIC_TIME, p.u16(60000))
        for value in (b"\x02", b"\x80", b"\xff"):
            session.refuse(f"Cyclic Mode = {value.hex()}", b"\x26" + value)
        for value in (b"\x01", b"\x00"):
            session.accept(p.CYCLIC_MODE, value)


def clash(context: Context) -> None:
    """An identifier must not be used by another frame type, in number and format (9.10.2, G15)."""
    with context.session() as session:
        for parameter in IDS:
            for other in IDS:
                value = other.factory
                if parameter == other:
                    session.accept(parameter, value, f"{parameter.name} to its own value")
                else:
                    name = f"{parameter.name} to the {other.name}"
                    session.refuse(name, bytes([parameter.write]) + value)
                    in_29_bits = p.u32(int.from_bytes(value, "little") | p.EXTENDED)
                    session.accept(parameter, in_29_bits, f"{name}, same number in the other format")
                    session.accept(parameter, parameter.factory)
        # The written values are compared, not those in force.
        session.accept(p.SET_ID, p.u32(0x400))
        session.refuse("Reply-Parameter-ID to the written set id", b"\x21" + p.u32(0x400))
        session.refuse("Sync-ID to the written set id", b"\x22" + p.u32(0x400))
        session.accept(p.REPLY_ID, p.u32(0x300), "Reply-Parameter-ID to the former set id")
        session.refuse("Set-Parameter-ID to its former value, now the reply id", b"\x20" + p.u32(0x300))
        session.accept(p.SYNC_ID, p.u32(0x301), "Sync-ID to the former reply id")
        session.accept(p.SYNC_ID, p.u32(p.EXTENDED | 0x1ABC_DEF0))
        session.refuse("Set-Parameter-ID to a 29-bit sync id", b"\x20" + p.u32(p.EXTENDED | 0x1ABC_DEF0))


def default_param(context: Context) -> None:
    """DefaultParam is set exactly while every parameter has its factory value; AutobaudDetection while BR = 0 (9.5.2, G12)."""
    others = {
        p.SET_ID: p.u32(0x310),
        p.REPLY_ID: p.u32(0x311),
        p.SYNC_ID: p.u32(0x312),
        p.BAUD_RATE: b"\x06",
        p.BUS_OFF_RECOVERY: b"\x01",
        p.CYCLIC_TIME: p.u16(251),
        p.CYCLIC_MODE: b"\x01",
    }
    with context.session() as session:
        for parameter in session.product.parameters:
            for value in (
                [p.filter_value(2001, 2), p.filter_value(2000, 1)] if parameter == p.FILTER else [others.get(parameter, p.u16(1))]
            ):
                session.accept(parameter, value, f"{parameter.name}: DefaultParam is cleared")
                session.accept(parameter, parameter.factory, f"{parameter.name}: DefaultParam is set again")
                session.read_status("status")
        session.accept(p.CYCLIC_TIME, p.u16(9))
        session.accept(p.BUS_OFF_RECOVERY, b"\x01")
        session.accept(p.CYCLIC_TIME, p.u16(250), "one of two factory values: DefaultParam is still cleared")
        session.load()
        session.read_all("LOAD restores the factory values")
        session.accept(p.BAUD_RATE, b"\x05", "AutobaudDetection is cleared")
        session.accept(p.BAUD_RATE, b"\x00", "AutobaudDetection is set again")


def communication(context: Context) -> None:
    """Identifiers and bit rate take effect with a restart and are lost without SAVE (9.7, 9.10.8, G22)."""
    with context.session(store=context.store()) as session:
        poll = bytes([p.ANGLES])

        def write_ids(set_id: int, reply_id: int, sync_id: int) -> None:
            for parameter, value in zip(IDS, (set_id, reply_id, sync_id)):
                session.accept(parameter, p.u32(value))

        def angles() -> bytes:
            return session.angles_reply((0,) * session.product.axes)

        def sync_answer(name: str) -> None:
            session.tester.send(session.sync_id)
            frame = session.tester.receive()
            expected = f"{session_id(session.reply_id)}#{angles().hex().upper()}"
            session.report.equal(name, expected, str(frame))

        # Without SAVE: the old identifiers stay in force; after RESET they are read again.
        write_ids(0x400, p.EXTENDED | 0x1ABC_DEF1, p.EXTENDED | 0x100)
        session.accept(p.BAUD_RATE, b"\x06")
        session.reply("still on the old ids", poll, angles())
        session.ignored("the new set id, not yet in force", 0x400, poll)
        session.ignored("the new sync id, not yet in force", p.EXTENDED | 0x100)
        sync_answer("the old sync id still works")
        session.reply("alive: the set id in force", b"\xff", session.boot_message())
        session.factory()
        session.reset("RESET without SAVE")
        session.read_all("RESET without SAVE: everything as before")

        # With SAVE: new identifiers after RESET.
        write_ids(0x400, p.EXTENDED | 0x1ABC_DEF1, p.EXTENDED | 0x100)
        session.save()
        session.reply("after SAVE, before RESET: old ids", poll, angles())
        session.reset("RESET with SAVE: boot-up on the new 29-bit reply id")
        session.read_all("RESET with SAVE: values kept")
        session.reply("poll on the new ids", poll, angles())
        sync_answer("29-bit sync id")
        session.ignored("the old set id", 0x300, poll)
        session.ignored("the new set id in the other format", p.EXTENDED | 0x400, poll)
        session.ignored("11-bit sync id of the same number", 0x100)

        # A 29-bit set id; in the boot-up message bit 31 is set (table 23).
        write_ids(p.EXTENDED | 0x0361, 0x7FF, 0x080)
        session.save()
        session.reset("RESET: the 29-bit set id in the boot-up message")
        session.reply("alive: the 29-bit set id", b"\xff", session.boot_message())
        session.reply("poll on a 29-bit set id", poll, angles())
        sync_answer("11-bit sync id")
        session.ignored("11-bit set id of the same number", 0x361, poll)

        # LOAD: the ids stay in force until the restart; SAVE is not needed (9.10.7, G8).
        session.accept(p.CYCLIC_TIME, p.u16(9999))
        session.accept(p.FILTER, p.filter_value(25000, 1))
        session.load()
        session.read_all("LOAD: factory values, on the ids in force")
        session.reply("LOAD: alive: the set id in force", b"\xff", session.boot_message())
        session.ignored("LOAD: the factory set id is not in force yet", 0x300, poll)
        session.reset("LOAD then RESET: factory ids")
        session.read_all("LOAD then RESET: factory values")

        # With a fixed rate the sensor boots without traffic.
        session.accept(p.BAUD_RATE, b"\x06")
        session.save()
        session.tester.send(session.set_id, b"\xffRESET")
        got = [str(frame) for frame in session.tester.collect(0.5)]
        session.report.equal("RESET with a fixed rate: boot-up without traffic", session.boot_up(), got)
        session.accept(p.BAUD_RATE, b"\x00", "automatic detection with the next restart")
        session.reply("the fixed rate is still in force", poll, angles())


def session_id(identifier: int) -> str:
    """An identifier as candump writes it."""
    return f"{identifier & 0x1FFF_FFFF:08X}" if identifier & p.EXTENDED else f"{identifier:03X}"


def load(context: Context) -> None:
    """LOAD stores the factory values (G8): they survive a power cycle and take effect at once."""
    with context.session(store=context.store()) as session:
        session.accept(p.CYCLIC_TIME, p.u16(20))
        session.accept(p.FILTER, p.filter_value(8000, 2))
        session.accept(p.BUS_OFF_RECOVERY, b"\x01")
        session.accept(session.product.offset(0), p.u16(77))
        session.save()
        session.accept(p.CYCLIC_TIME, p.u16(40000))
        session.load()
        session.read_all("LOAD: factory values at once")
        session.reply("LOAD: no offset", b"\x00", session.angles_reply((0,) * session.product.axes))
        session.power_down()
        session.factory()
        session.power_up(wake=False)
        session.check_wake("power cycle after LOAD")
        session.read_all("factory values after a power cycle without SAVE")
        session.acknowledged("LOAD with extra bytes (G26)", b"\x40LOAD\x00\x01\x02")
        session.acknowledged("SAVE with extra bytes (G26)", b"\x50SAVE\xff\xff\xff")
        session.accept(p.CYCLIC_TIME, p.u16(30000))
        session.accept(p.CYCLIC_MODE, b"\x01")
        session.load()
        session.reply("LOAD ends cyclic mode", b"\x00", session.angles_reply((0,) * session.product.axes))


GROUPS = (values, clash, default_param, communication, load)
