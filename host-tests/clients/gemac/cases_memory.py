"""Nonvolatile memory: SAVE and power cycles, blank and damaged memory (sections 9.8, 9.10.8, G25, G28)."""

import random
from collections.abc import Callable
from pathlib import Path

from . import record
from . import protocol as p
from .context import Context
from .session import Session

SEED = 20210730


def other_values(product: p.Product) -> dict[p.Parameter, bytes]:
    """A value for each parameter that is not the factory value."""
    table = {
        p.SET_ID: p.u32(0x555),
        p.REPLY_ID: p.u32(p.EXTENDED | 0x0BAD_CAFE),
        p.SYNC_ID: p.u32(0x001),
        p.BAUD_RATE: b"\x07",
        p.BUS_OFF_RECOVERY: b"\x01",
        p.CYCLIC_TIME: p.u16(0xABCD),
        p.CYCLIC_MODE: b"\x01",
        p.FILTER: p.filter_value(12345, 1),
    }
    offsets = (p.u16(-1234), p.u16(4321)) if product.axes == 2 else (p.u16(23456),)
    return table | {product.offset(axis): offset for axis, offset in enumerate(offsets)}


def power(context: Context) -> None:
    """Saved values survive a power cut right after the reply to SAVE; others do not."""
    with context.session(store=context.store()) as session:
        for parameter in (p.CYCLIC_TIME, p.FILTER, p.SET_ID):
            session.accept(parameter, other_values(session.product)[parameter])
        session.power_down()
        session.factory()
        session.power_up(wake=False)
        session.check_wake("power cycle without SAVE: boot-up")
        session.read_all("power cycle without SAVE: factory values")

        for parameter, value in other_values(session.product).items():
            session.accept(parameter, value)
        session.save()
        session.power_down()
        session.restart_ids()
        session.power_up(wake=False)
        session.check_wake("power cycle after SAVE: boot-up on the saved ids")
        session.read_all("power cycle after SAVE: all values kept")

        # A change that is not saved does not change the saved values.
        session.tester.request(session.set_id, b"\x24\x00")
        session.power_down()
        session.power_up(wake=False)
        session.check_wake("boot-up")
        session.read_all("a change that was not saved is lost")


def many_saves(context: Context) -> None:
    """After many saves, the last one is loaded."""
    with context.session(store=context.store()) as session:
        for count in range(1, 301):
            session.values[p.CYCLIC_TIME] = p.u16(count)
            session.tester.request(session.set_id, b"\x25" + p.u16(count))
            reply = session.tester.request(session.set_id, b"\x50SAVE")
            if str(reply) != f"301#50{session.status:02X}":
                session.report.equal(f"SAVE {count}", f"301#50{session.status:02X}", str(reply))
                break
            if count in (1, 2, 3, 50, 100, 150, 200, 250, 300):
                session.power_down()
                session.power_up(wake=False)
                session.check_wake(f"power cycle after {count} saves")
                session.read(p.CYCLIC_TIME, f"the last of {count} saves")


def blank(context: Context) -> None:
    """Missing or erased memory: factory values, no error (G28)."""
    store = context.store()
    with context.session(store=store, wake=False) as session:
        session.check_wake("no memory file: boot-up without EEPROMError")
        session.read_all("no memory file: factory values")
        session.accept(p.CYCLIC_TIME, p.u16(99))
        session.save()
    store.write_bytes(b"\xff" * store.stat().st_size)
    with context.session(store=store, wake=False) as session:
        session.check_wake("erased memory: boot-up without EEPROMError")
        session.read_all("erased memory: factory values")
        session.accept(p.CYCLIC_TIME, p.u16(98))
        session.save()
        session.power_down()
        session.power_up(wake=False)
        session.check_wake("erased memory, then saved: boot-up")
        session.read(p.CYCLIC_TIME, "a save to erased memory is loaded")


def damaged(context: Context) -> None:
    """Damage is reported with EEPROMError; the older record is used, or else factory values (G28)."""
    generator = random.Random(SEED)
    older, newer = p.u16(1111), p.u16(2222)

    def overwrite(store: Path) -> None:
        store.write_bytes(generator.randbytes(store.stat().st_size))

    def flip_payload(store: Path) -> None:
        newest = record.find(store)[-1]
        record.flip(store, newest.offset + record.HEADER + 3)

    def flip_all(store: Path) -> None:
        for found in record.find(store):
            record.flip(store, found.offset + record.HEADER)

    damages: list[tuple[str, Callable[[Path], None], bytes]] = [
        ("a payload bit of the newest record", flip_payload, older),
        ("the magic of the newest record", lambda s: record.flip(s, record.find(s)[-1].offset, 0xFF), older),
        ("the product of the newest record", lambda s: record.flip(s, record.find(s)[-1].offset + 2), older),
        ("the sequence of the newest record", lambda s: record.flip(s, record.find(s)[-1].offset + 4), older),
        ("the CRC of the newest record", lambda s: record.flip(s, last_byte(s), 0x80), older),
        ("the newest record cut off in the payload", lambda s: record.cut_off(s, record.find(s)[-1], 16), older),
        ("the newest record cut off before the CRC", lambda s: record.cut_off(s, record.find(s)[-1], -4), older),
        ("every record", flip_all, p.CYCLIC_TIME.factory),
        ("garbage everywhere", overwrite, p.CYCLIC_TIME.factory),
        ("zeros everywhere", lambda s: s.write_bytes(bytes(s.stat().st_size)), p.CYCLIC_TIME.factory),
    ]
    for number, (name, damage, kept) in enumerate(damages):
        store = context.store(f"damaged{number}")
        with context.session(store=store) as session:
            for value in (older, newer):
                session.tester.request(session.set_id, b"\x25" + value)
                session.tester.request(session.set_id, b"\x50SAVE")
        try:
            damage(store)
        except IndexError:
            context.report.verdict(False, name, "a record to damage", "none in the memory file")
            continue
        with context.session(store=store, wake=False) as session:
            session.values[p.CYCLIC_TIME] = kept
            session.errors = p.EEPROM_ERROR
            check_boot_after_damage(session, name)
            session.read_all(f"{name}: values")
            session.accept(p.CYCLIC_TIME, p.u16(3333))
            session.save()
            session.power_down()
            session.power_up(wake=False)
            session.check_wake(f"{name}, then saved: boot-up without EEPROMError")
            session.read(p.CYCLIC_TIME, f"{name}, then saved")


def last_byte(store: Path) -> int:
    """The position of the last byte of the newest record, in its CRC."""
    newest = record.find(store)[-1]
    return newest.offset + newest.size - 1


def check_boot_after_damage(session: Session, name: str) -> None:
    """Boot-up with EEPROMError, which 02h shows and clears (9.5.2, G17).

    The manual ("writing/reading error on EEPROM") does not define whether CmdParamError is set too, so it is masked here.
    """
    got = [mask(frame.data) for frame in session.wake()]
    expected = [session.product.boot(session.status).hex()] * 2
    session.report.equal(f"{name}: boot-up with EEPROMError", expected, got)
    frame = session.tester.request(session.set_id, b"\x02")
    expected = bytes([p.STATUS, session.status]).hex()
    session.report.equal(f"{name}: 02h shows EEPROMError", expected, mask(frame.data) if frame else None)
    session.errors = 0
    session.acknowledged(f"{name}: 02h has cleared it", b"\x02")


def mask(data: bytes) -> str:
    """A reply without its CmdParamError bit."""
    return (data[:1] + bytes([data[1] & ~p.CMD_ERROR]) + data[2:]).hex() if len(data) > 1 else data.hex()


def other_product(context: Context) -> None:
    """A record of another product: factory values and EEPROMError (G28)."""
    for other in p.PRODUCTS.values():
        if other == context.product:
            continue
        store = context.store(f"from-{other.name}")
        with Session(context.report, context.program, other, store=store) as session:
            session.tester.request(session.set_id, b"\x25" + p.u16(1234))
            session.tester.request(session.set_id, b"\x50SAVE")
        with context.session(store=store, wake=False) as session:
            session.errors = p.EEPROM_ERROR
            check_boot_after_damage(session, f"memory of {other.name}")
            session.read_all(f"memory of {other.name}: factory values")


GROUPS = (power, many_saves, blank, damaged, other_product)
