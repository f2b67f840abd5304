"""Bit rates, bursts, several testers, random frames (sections 9.10.3 and 9.5)."""

import random

import can

from . import protocol as p
from .context import Context
from .harness import Frame, Tester
from .session import Session

SEED = 49152


def bit_rates(context: Context) -> None:
    """Automatic detection and fixed rates on a bus with a fixed bit rate (9.10.3)."""
    every = context.product.name == "is2"
    for rate in p.BAUD_CODES.values():
        if (every or rate in (125_000, 250_000)) and rate != 62_500:
            options = {"bus_rate": f"{rate // 1000}", "bitrate": rate}
            with context.session(wake=False, **options) as session:
                session.quiet(f"{rate} bit/s: silent before traffic", 0.05)
                session.check_wake(f"{rate} bit/s: detected, boot-up")
                session.tester.collect(0.05)
                session.read(p.BAUD_RATE, f"{rate} bit/s: 13h still 0")
    change_rate(context)


def change_rate(context: Context) -> None:
    """From 250 to 500 kbit/s with SAVE and RESET, then to 62.5 kbit/s."""
    report = context.report
    options = {"store": context.store(), "bus_rate": "250", "bitrate": 250_000}
    with context.session(**options) as session:
        session.tester.collect(0.05)
        session.accept(p.BAUD_RATE, b"\x07")
        session.read(p.BAUD_RATE, "before the restart: still at 250 kbit/s")
        session.save()
        session.tester.send(session.set_id, b"\xffRESET")
        session.tester.collect(0.1)
        for _ in range(3):
            session.tester.send(session.set_id, b"\x00")
        session.quiet("at 500 kbit/s: no reply on a bus at 250 kbit/s", 0.2)

        session.power_down()
        session.options["bus_rate"], session.bitrate = "500", 500_000
        session.power_up(wake=False)
        got = [str(frame) for frame in session.tester.collect(0.3)]
        report.equal("on a bus at 500 kbit/s: boot-up without traffic", session.boot_up(), got)
        session.read_all("all values kept")
        wrong = Tester(session.sensor, 250_000)
        wrong.send(session.set_id, b"\x00")
        report.equal("a tester at the wrong rate receives nothing", [], [str(f) for f in wrong.collect(0.15)])
        wrong.close()
        session.read(p.BAUD_RATE, "a tester at the right rate receives the reply")

        session.accept(p.BAUD_RATE, b"\x0a", "62.5 kbit/s")
        session.save()
        session.power_down()
        session.options["bus_rate"], session.bitrate = "62.5", None
        # BTR0/BTR1 of an SJA1000 at 8 MHz: 8 x 16 time quanta.
        timing = can.BitTiming(f_clock=8_000_000, brp=8, tseg1=13, tseg2=2, sjw=1)
        session.sensor = type(session.sensor)(session.program, session.product.name, **session.options)
        session.tester = Tester(session.sensor, timing=timing)
        got = [str(frame) for frame in session.tester.collect(0.3)]
        report.equal("on a bus at 62.5 kbit/s: boot-up", session.boot_up(), got)
        session.read(p.BAUD_RATE, "62.5 kbit/s read")


def burst(context: Context) -> None:
    """1000 requests without a pause are all answered, in order."""
    with context.session() as session:
        tester = session.tester
        expected = []
        for number in range(1000):
            kind = number % 4
            if kind == 0:
                session.values[p.CYCLIC_TIME] = p.u16(number + 1)
                request = b"\x25" + p.u16(number + 1)
                reply = bytes([0x25, session.status])
            elif kind == 1:
                request, reply = b"\x15", bytes([0x15, session.status]) + session.values[p.CYCLIC_TIME]
            elif kind == 2:
                request, reply = b"\x00", session.angles_reply((0,) * session.product.axes)
            else:
                request, reply = b"\x02", bytes([0x02, session.status])
            expected.append(str(Frame(session.reply_id, reply)))
            tester.send(session.set_id, request)
        got = [str(frame) for frame in tester.take(1000, 10.0)]
        wrong = next((n for n, (e, g) in enumerate(zip(expected, got)) if e != g), None)
        session.report.equal("1000 requests in a burst: replies", 1000, len(got))
        session.report.verdict(
            wrong is None,
            "1000 requests in a burst: order and content",
            "all" if wrong is None else f"no. {wrong}: {expected[wrong]}",
            "all" if wrong is None else got[wrong],
        )
        session.quiet("no further replies")


def clients(context: Context) -> None:
    """Two testers on one bus: both see every reply, each sees the requests of the other."""
    with context.session() as session:
        first, second = session.tester, Tester(session.sensor)
        session.quiet("a second tester causes no frame")
        reply = str(Frame(session.reply_id, session.angles_reply((0,) * session.product.axes)))
        first.send(session.set_id, b"\x00")
        session.report.equal("the tester that polls", [reply], [str(f) for f in first.collect(0.1)])
        expected = [str(Frame(session.set_id, b"\x00")), reply]
        session.report.equal("the other tester sees request and reply", expected, [str(f) for f in second.collect(0.1)])
        seen: dict[str, list[int]] = {"first": [], "second": []}
        for _ in range(100):
            first.send(session.set_id, b"\x00")
            second.send(session.set_id, b"\x02")
            # Each sees the request of the other and both replies.
            for name, tester in (("first", first), ("second", second)):
                seen[name] += [f.data[0] for f in tester.take(3, 0.5) if f.id == session.reply_id]
        for name, codes in seen.items():
            got = (codes.count(p.ANGLES), codes.count(p.STATUS))
            session.report.equal(f"both at once: replies seen by the {name}", (100, 100), got)
        second.close()
        session.acknowledged("the first tester still works", b"\x02")


def fuzz(context: Context) -> None:
    """Random frames: invalid frames change nothing, and no frame stops the sensor."""
    generator = random.Random(SEED)
    with context.session() as session:
        before = session.snapshot()
        for _ in range(2000):
            send_invalid(session, generator)
        session.tester.collect_until_quiet()
        session.report.equal("2000 invalid frames: parameters unchanged", before, session.snapshot())
        session.errors |= p.CMD_ERROR
        session.read_status("2000 invalid frames: CmdParamError and no other error")
        session.read_status("then no error")
    with context.session(store=context.store()) as session:
        for _ in range(2000):
            send_random(session, generator)
        session.tester.send(session.set_id, b"\x26\x00")
        session.tester.collect_until_quiet()
        running = session.sensor.running
        session.report.verdict(running, "2000 random frames: the process", "runs", "runs" if running else "ended")
        frame = session.tester.request(session.set_id, b"\x03")
        expected = p.u32(session.product.product_number) + p.u16(p.REVISION)
        got = frame.data[2:].hex() if frame else None
        session.report.equal("2000 random frames: the sensor still answers", expected.hex(), got)
        session.tester.request(session.set_id, b"\x02")
        session.load()
        session.read_all("LOAD still restores the factory values")


def send_invalid(session: Session, generator: random.Random) -> None:
    """Sends a frame that must change nothing: it is not for the sensor, or it is refused."""
    kind = generator.randrange(8)
    ids = (session.set_id, session.reply_id, session.sync_id)
    data = generator.randbytes(generator.randrange(9))
    invalid = sorted(set(range(256)) - session.product.codes)
    if kind == 0:
        identifier = generator.randrange(0x800)
        if identifier not in ids:
            session.tester.send(identifier, data)
    elif kind == 1:
        session.tester.send(p.EXTENDED | generator.choice([generator.randrange(1 << 29), *ids]), data)
    elif kind == 2:
        session.tester.send(generator.choice(ids), remote=True, dlc=generator.randrange(9))
    elif kind == 3:
        session.tester.send(session.sync_id, generator.randbytes(generator.randrange(1, 9)))
    elif kind == 4:
        session.tester.send(session.set_id, bytes([generator.choice(invalid)]) + data[:7])
    elif kind == 5:
        short = [q for q in session.product.parameters if not q.name.startswith("Zero")]
        parameter = generator.choice(short)
        session.tester.send(session.set_id, bytes([parameter.write]) + generator.randbytes(parameter.size - 1))
    elif kind == 6:
        limits = [b"\x23\x0b", b"\x24\x02", b"\x25\x00\x00", b"\x26\x02", b"\x27\x63\x00\x01", b"\x27\xd0\x07\x03"]
        session.tester.send(session.set_id, generator.choice(limits))
    else:
        signature = generator.choice([b"\x40LOAX", b"\x50SAVF", b"\xffRESEX", b"\x40", b"\x50", b""])
        session.tester.send(session.set_id, signature)


def send_random(session: Session, generator: random.Random) -> None:
    """Sends any frame except RESET, after which the sensor would use random identifiers."""
    data = generator.randbytes(generator.randrange(9))
    if generator.randrange(2):
        code = generator.choice(sorted(session.product.codes))
        data = bytes([code]) + (b"SAVE" if code == p.SAVE else data[:7])
    session.tester.send(generator.choice([session.set_id, session.set_id, session.sync_id]), data)


GROUPS = (bit_rates, burst, clients, fuzz)
