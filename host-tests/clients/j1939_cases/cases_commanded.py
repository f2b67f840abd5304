"""Commanded Address by BAM and by RTS/CTS, and what of the transport protocol the sensor receives (S25, S29)."""

from dataclasses import replace

from canopen_cases.runner import Context

from . import protocol as p
from .session import AT_ONCE, SILENCE, START_TIME, Node

SIZE = 9


def command(address: int, name: bytes = p.OURS.data) -> bytes:
    """The message: NAME and new address."""
    return name + bytes([address])


def by_bam(data: bytes, source: int = p.ME, pgn: int = p.COMMANDED) -> list[str]:
    """A message by BAM."""
    return [p.bam(source, pgn, len(data)), *p.packets(source, p.GLOBAL, data)]


def moved(session: Node, name: str, address: int) -> bool:
    """Checks that this address is claimed at once, and follows the node to it."""
    frame = session.wait_pgn(p.CLAIMED, AT_ONCE)
    session.report.equal(name, p.claim(address), str(frame))
    if frame:
        session.address = p.split(frame).source
        session.wait_online()
    return frame is not None


def broadcast(context: Context) -> None:
    """S25: by BAM, for addresses in all ranges; 2102h takes the address, 1010h keeps it."""
    with Node(context) as session:
        for address in (0xA0, 0, 127, 253, 247, 0x21 + 1, 0x80):
            session.tx(*by_bam(command(address)))
            if not moved(session, f"S25 BAM to {address}: claimed at once", address):
                continue
            session.reads(f"S25 BAM to {address}: 2102h follows", 0x2102, 0, address)
        session.tx(*by_bam(command(0xA0)))
        moved(session, "S25 the bytes in facts: A0h", 0xA0)
        frame = session.restarted()
        session.report.equal("S25 not stored: the start address again", p.claim(), str(frame))
        session.address = p.PREFERRED
        session.wait_online()
        session.tx(*by_bam(command(0xA0)))
        moved(session, "S25 again", 0xA0)
        session.save()
        session.report.equal("S25 1010h keeps it", p.claim(0xA0), str(session.restarted()))
        session.wait_online()


def waits(context: Context) -> None:
    """S22, S25: after Commanded Address, 250 ms without anything but the claim."""
    with Node(context, {(0x2104, 1): 10}) as session:
        session.tx(*by_bam(command(0x95)))
        claim = session.wait_pgn(p.CLAIMED)
        first = session.wait(lambda frame: True)
        session.report.equal("S25 claimed", p.claim(0x95), str(claim))
        session.report.verdict(p.split(first).source == 0x95, "S25 then from the new address", "95h", str(first))
        session.report.within("S22 250 ms anew", *SILENCE, first.at - claim.at)


def connection(context: Context) -> None:
    """S25, S29: by RTS/CTS, with the answers of the receiver."""
    with Node(context) as session:
        for address in (0x9A, 0x21 + 7, 0xF0):
            us, data = session.address, command(address)
            session.others.clear()
            session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
            session.comes(f"S29 to {address}: CTS for both packets", p.cts(us, p.ME, p.COMMANDED, 2, 1))
            session.tx(*p.packets(p.ME, us, data))
            frame = session.next()
            session.report.equal(f"S29 to {address}: end of message", p.end_of_message(us, p.ME, p.COMMANDED, SIZE), str(frame))
            moved(session, f"S25 to {address}: claimed", address)
        # The sender permits one packet per CTS.
        us, data = session.address, command(0x9B)
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE, 1))
        session.comes("S29 one packet per CTS: the first", p.cts(us, p.ME, p.COMMANDED, 1, 1))
        session.tx(p.packet(p.ME, us, data, 1))
        session.comes("S29 one packet per CTS: the second", p.cts(us, p.ME, p.COMMANDED, 1, 2))
        session.tx(p.packet(p.ME, us, data, 2))
        session.comes("S29 end of message", p.end_of_message(us, p.ME, p.COMMANDED, SIZE))
        moved(session, "S25 claimed", 0x9B)


def refused(context: Context) -> None:
    """S25: other NAMEs, addresses 254 and 255, wrong lengths and broken transfers change nothing."""
    with Node(context) as session:
        other = replace(p.OURS, identity=2).data
        broken = by_bam(command(0xA0))
        wrong = {
            "another NAME": by_bam(command(0xA0, other)),
            "our NAME with another capable bit": by_bam(command(0xA0, p.LOWER)),
            "address 254": by_bam(command(254)),
            "address 255": by_bam(command(255)),
            "8 bytes in one frame": [p.shown(p.COMMANDED, p.ME, p.OURS.data)],
            "8 bytes by BAM": by_bam(p.OURS.data),
            "10 bytes": by_bam(command(0xA0) + b"\xff"),
            "14 bytes": by_bam(command(0xA0) + bytes(5)),
            "1 byte": by_bam(b"\xa0"),
            "packet 2 missing": broken[:2],
            "packet 1 missing": [broken[0], broken[2]],
            "packets exchanged": [broken[0], broken[2], broken[1]],
            "packet 1 twice": [broken[0], broken[1], broken[1], broken[2]],
            "packet 0": [broken[0], broken[1].replace("#01", "#00"), broken[2]],
            "packets of another node": [broken[0], *p.packets(p.OTHER, p.GLOBAL, command(0xA0))],
            "packets to one node": [broken[0], *p.packets(p.ME, p.PREFERRED, command(0xA0))],
            "without announcement": p.packets(0x37, p.GLOBAL, command(0xA0)),
            "3 packets announced": [broken[0].replace("#20090002", "#20090003"), *broken[1:]],
            "1 packet announced": [broken[0].replace("#20090002", "#20090001"), *broken[1:]],
            "aborted": [broken[0], broken[1], p.abort(p.ME, p.GLOBAL, p.COMMANDED, 3), "18EAFF21#00EF00"],
            "another PGN": by_bam(command(0xA0), pgn=65241),
            "another PGN, Proprietary A": by_bam(command(0xA0), pgn=0xEF00),
            "9 bytes in 3 packets, as announced": [
                broken[0].replace("#20090002", "#20090003"),
                *broken[1:],
                broken[2].replace("#02", "#03"),
            ],
            "short packet 2": [broken[0], broken[1], broken[2][: 9 + 4]],
            "announcement to us alone": [broken[0].replace("1CECFF", "1CEC80"), *broken[1:]],
            "announcement with the extended data page bit": [f"1E{broken[0][2:]}", *broken[1:]],
            "packets with the extended data page bit": [broken[0], *(f"1E{line[2:]}" for line in broken[1:])],
            "announcement of 7 bytes": [broken[0][:-2], *broken[1:]],
        }
        for name, lines in wrong.items():
            session.expect(f"S25 {name} changes nothing", lines)
            # Another announcement of the same node ends what is open.
            session.tx(p.bam(p.ME, p.DM1, 20))
        session.reads("S25 2102h is still", 0x2102, 0, p.PREFERRED)
        session.expect("S25 the address is still", session.request(p.CLAIMED), p.claim())
        session.tx(*by_bam(command(0xA1)))
        moved(session, "S25 and a whole one acts", 0xA1)


def among_others(context: Context) -> None:
    """S29: others' BAMs run in between; a new announcement of the same node begins anew."""
    with Node(context) as session:
        ours = by_bam(command(0xB0))
        dm1 = [by_bam(bytes(range(30)), 0x40 + number, p.DM1) for number in range(12)]
        session.tx(*(lines[0] for lines in dm1), ours[0], *(lines[1] for lines in dm1), ours[1])
        session.sleep(0.05)
        session.tx(*(lines[2] for lines in dm1))
        session.sleep(0.05)
        session.tx(ours[2])
        moved(session, "S29 between 12 other BAMs", 0xB0)
        ours = by_bam(command(0xB1))
        session.tx(ours[0], ours[1], *ours)
        moved(session, "S29 announced again: begins anew", 0xB1)
        ours = by_bam(command(0xB2))
        # A node has one BAM at a time: one of another PGN replaces the first.
        session.expect("S29 another BAM of the same node in between", [*ours[:2], p.bam(p.ME, p.DM1, 20), ours[2]])
        first, second = by_bam(command(0xB3)), by_bam(command(0xB3), p.OTHER)
        session.tx(first[0], second[0], first[1], second[1], first[2])
        frame = session.wait_pgn(p.CLAIMED, 1.5)
        if frame is None:  # one receiver is allowed: the later announcement may have taken it
            session.tx(second[2])
            frame = session.wait_pgn(p.CLAIMED)
        session.report.equal("S25 two nodes command at the same time: one of them is heard", p.claim(0xB3), str(frame))
        session.address = 0xB3
        session.wait_online()
        us = session.address
        # RTS/CTS while a BAM of somebody else is open.
        session.tx(dm1[0][0], p.rts(p.ME, us, p.COMMANDED, SIZE), dm1[0][1])
        session.comes("S29 RTS during a BAM: CTS", p.cts(us, p.ME, p.COMMANDED, 2, 1))
        parts = p.packets(p.ME, us, command(0xB4))
        session.tx(parts[0], dm1[0][2], parts[1])
        session.comes("S29 RTS during a BAM: end of message", p.end_of_message(us, p.ME, p.COMMANDED, SIZE))
        moved(session, "S25 claimed", 0xB4)


def unwanted(context: Context) -> None:
    """S29: RTS for anything else is aborted with reason 2."""
    with Node(context) as session:
        us = session.address
        for pgn, size in (
            (65259, 20),
            (p.DM1, 100),
            (p.PROPRIETARY_A, 9),
            (p.PROPRIETARY_A, 100),
            (65262, 1785),
            (0, 9),
            (0x1FECA, 9),
        ):
            name = f"S29 RTS for {pgn}, {size} bytes: abort 2"
            session.expect(name, p.rts(p.ME, us, pgn, size), p.abort(us, p.ME, pgn, p.RESOURCES))
        for other in (0x90, p.NULL):
            session.expect(f"S29 RTS to {other:02X}h is for somebody else", p.rts(p.ME, other, p.COMMANDED, SIZE))
        session.expect("S29 RTS for others, not to us", p.rts(p.ME, 0x90, p.DM1, 20))
        session.expect("S29 CTS without a connection", p.cts(p.ME, us, p.COMPONENT, 1, 1))
        session.expect("S29 end of message without a connection", p.end_of_message(p.ME, us, p.COMPONENT, 20))
        session.expect("S29 abort without a connection", p.abort(p.ME, us, p.COMPONENT, 3))
        session.expect("S29 packets without a connection", p.packets(p.ME, us, command(0xA0)))
        session.expect(
            "S29 unknown control byte", p.shown(p.TP_CM, p.ME, bytes([5, 9, 0, 2, 255]) + p.pgn_bytes(p.COMMANDED), us, 7)
        )
        session.expect("S29 short RTS", f"1CEC{us:02X}21#10090002FFD8")
        for size in (8, 10, 1785):
            name = f"S25 S29 RTS of {size} bytes of Commanded Address: abort 2"
            session.expect(name, p.rts(p.ME, us, p.COMMANDED, size), p.abort(us, p.ME, p.COMMANDED, p.RESOURCES))
        session.expect("S25 no address has changed", session.request(p.CLAIMED), p.claim())


def time_outs(context: Context) -> None:
    """S29: T1 = 750 ms between packets, T2 = 1250 ms after our CTS."""
    with Node(context) as session:
        us, data = session.address, command(0xA0)
        lines = p.packets(p.ME, us, data)
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
        cts = session.next()
        abort = session.next(4.0)
        session.report.equal("S29 T2: no packet after our CTS: abort 3", p.abort(us, p.ME, p.COMMANDED, p.TIMEOUT), str(abort))
        session.took("S29 T2", 1.25, abort.at - cts.at)
        session.expect("S29 packets after the abort are ignored", lines)
        # T1 begins after DM1, so that no other frame of the sensor is due at its end.
        session.wait_pgn(p.DM1, 1.2)
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
        session.next()
        since = session.now()
        session.tx(lines[0])
        abort = session.next(4.0)
        session.report.equal(
            "S29 T1: the second packet is missing: abort 3", p.abort(us, p.ME, p.COMMANDED, p.TIMEOUT), str(abort)
        )
        session.took("S29 T1", 0.75, abort.at - since)
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
        session.next()
        got = session.after(lines[1])
        session.report.verdict(
            len(got) <= 1 and all("#FF07" in one for one in got),
            "S29 packet 2 first: the transfer ends",
            "abort 7 or nothing",
            got,
        )
        session.expect("S29 and what follows is ignored", lines)
        # A BAM that pauses longer than T1 is gone.
        broken = by_bam(data)
        for pause, taken in ((0.756, False), (0.745, True)):
            moved_to = command(0xAA)
            lines = by_bam(moved_to)
            session.tx(*lines[:2])
            session.others.clear()
            session.wait(lambda frame: False, pause)
            session.tx(lines[2])
            frame = session.wait_pgn(p.CLAIMED, AT_ONCE)
            session.report.equal(
                f"S29 T1: a BAM that pauses {pause:.3f} s is {'taken' if taken else 'gone'}", taken, frame is not None
            )
        session.address = 0xAA
        session.wait_online()
        session.tx(*broken[:2])
        session.silent("S29 T1 of a BAM: nothing", 1.2)
        session.expect("S29 T1 of a BAM: the rest is ignored", broken[2])
        session.tx(*broken[:2])
        session.silent("S29 half of T1", 0.3)
        session.tx(broken[2])
        moved(session, "S29 a pause of 300 ms is allowed", 0xA0)
        us, data = session.address, command(0xA2)
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
        session.next()
        session.expect(
            "S29 aborted by the sender: no answer",
            [p.packet(p.ME, us, data, 1), p.abort(p.ME, us, p.COMMANDED, 3), p.packet(p.ME, us, data, 2)],
        )
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
        session.next()
        session.others.clear()
        session.tx(p.rts(p.ME, us, p.COMMANDED, SIZE))
        session.comes("S29 RTS again: CTS again", p.cts(us, p.ME, p.COMMANDED, 2, 1))
        session.tx(*p.packets(p.ME, us, data))
        session.comes("S29 end of message", p.end_of_message(us, p.ME, p.COMMANDED, SIZE))
        moved(session, "S25 claimed", 0xA2)


def without_address(context: Context) -> None:
    """S24, S25: a node that cannot claim takes the address; so does one within its 250 ms; a commanded address can be lost again."""
    ours = replace(p.OURS, capable=0)
    with Node(context, ours.settings()) as session:
        session.tx(p.claim(name=bytes(8)))
        session.wait_pgn(p.CLAIMED)
        session.tx(*by_bam(command(0xA0, p.OURS.data)))
        session.quiet("S25 cannot claim: another NAME", 0.3)
        session.tx(*by_bam(command(0xA0, ours.data)))
        frame = session.wait_pgn(p.CLAIMED, AT_ONCE)
        session.report.equal("S24 cannot claim: Commanded Address acts at once", p.claim(0xA0, ours.data), str(frame))
        session.address = 0xA0
        session.wait_online()
        session.reads("S25 2102h", 0x2102, 0, 0xA0)
    with Node(context, name="early") as session:
        session.restart()
        session.wait_pgn(p.CLAIMED, START_TIME)
        session.tx(*by_bam(command(0xA5)))
        moved(session, "S25 within the 250 ms", 0xA5)
        session.tx(p.claim(0xA5, p.LOWER))
        frame = session.wait_pgn(p.CLAIMED, AT_ONCE)
        session.report.equal("S23 a commanded address is lost as any", p.claim(0xA6), str(frame))
        session.address = 0xA6
        session.wait_online()
        session.reads("S23 2102h does not follow", 0x2102, 0, 0xA5)
        session.tx(p.claim(0x30, p.other_name(1)), *by_bam(command(0x30)))
        moved(session, "S25 an address that another node has is claimed all the same", 0x30)
        session.tx(*by_bam(command(0x30)))
        claim = session.wait_pgn(p.CLAIMED, AT_ONCE)
        session.report.equal("S25 the present address again: claimed at once", p.claim(0x30), str(claim))
        first = session.wait(lambda frame: True)
        session.report.within("S22 S25 the present address again: 250 ms anew", *SILENCE, first.at - claim.at)


GROUPS = (broadcast, waits, connection, refused, among_others, unwanted, time_outs, without_address)
