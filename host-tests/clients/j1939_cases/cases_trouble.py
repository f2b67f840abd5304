"""Diagnostics: DM1 with its lamps, codes, occurrence counts, one frame or BAM (S37).

DM1      lamps: 04h amber warning, 00h none; FFh; then for each code SPN bits 0..7, SPN bits 8..15, SPN bits 16..18 and FMI,
         conversion method and occurrence count; one code is filled with FFh to 8 bytes
"""

from canopen_cases.ims360_emergency import supply_scene
from canopen_cases.runner import Context
from gemac import record
from gemac.harness import Frame

from . import protocol as p
from . import values as v
from .session import Node

PITCH, ROLL, SUPPLY, MEMORY, NETWORK = 4976, 4977, 168, 630, 639
ABOVE, BELOW, ERRATIC, VOLTAGE_ABOVE, VOLTAGE_BELOW, BAD = 0, 1, 2, 3, 4, 12
NONE = "00FF00000000FFFF"

Code = tuple[int, int, int]  # SPN, FMI, occurrence count


def codes(data: bytes) -> list[Code]:
    """The codes of a DM1."""
    found = []
    for at in range(2, len(data) - 3, 4):
        one = data[at : at + 4]
        spn = one[0] | one[1] << 8 | one[2] >> 5 << 16
        found.append((spn, one[2] & 0x1F, one[3] & 0x7F))
    return found


def message(*found: Code) -> bytes:
    """A DM1 with these codes."""
    if not found:
        return bytes.fromhex(NONE)
    body = b"\x04\xff" + b"".join(
        bytes([spn & 0xFF, spn >> 8 & 0xFF, spn >> 16 << 5 | fmi, count]) for spn, fmi, count in found
    )
    return body.ljust(8, b"\xff")


def next_dm1(session: Node, timeout: float = 4.0) -> tuple[Frame | None, bytes]:
    """The next DM1, in one frame or by BAM: its first frame and its data."""

    def wanted(frame: Frame) -> bool:
        parts = p.split(frame)
        announced = (
            parts.pgn == p.TP_CM
            and parts.destination == p.GLOBAL
            and frame.data[0] == 0x20
            and frame.data[5:] == p.pgn_bytes(p.DM1)
        )
        return parts.pgn == p.DM1 or announced

    first = session.wait(wanted, timeout)
    if first is None or p.split(first).pgn == p.DM1:
        return first, first.data if first else b""
    size, data = int.from_bytes(first.data[1:3], "little"), b""
    for number in range(1, first.data[3] + 1):
        frame = session.wait(lambda frame: p.split(frame).pgn == p.TP_DT and p.split(frame).destination == p.GLOBAL, 2.0)
        if frame is None or frame.data[0] != number:
            return first, b"broken"
        data += frame.data[1:]
    return first, data[:size]


def until(session: Node, name: str, *found: Code, timeout: float = 8.0) -> Frame | None:
    """Waits for a DM1 with these codes, in any order, and checks its bytes."""
    data, first = b"", None
    end = session.now() + timeout
    while session.now() < end:
        first, data = next_dm1(session)
        if (
            first is None
            or (len(found) == len(codes(data)) and set(found) == set(codes(data)))
            or (not found and data.hex().upper() == NONE)
        ):
            break
    right = set(found) == set(codes(data)) if len(found) > 1 else data == message(*found)
    right = (
        right and data[:2] == (b"\x04\xff" if found else b"\x00\xff") and (len(found) < 2 or len(data) == 2 + 4 * len(found))
    )
    session.report.verdict(right, name, f"{message(*found).hex().upper()} in any order", data.hex().upper())
    return first


def cadence(context: Context) -> None:
    """S37: without a code, these bytes, once a second, with priority 6."""
    with Node(context) as session:
        frames = [frame for frame in (next_dm1(session)[0] for _ in range(6)) if frame]
        session.report.equal("S37 no code", {f"18FECA80#{NONE}"}, {str(frame) for frame in frames})
        steps = [later.at - earlier.at for earlier, later in zip(frames[1:], frames[2:], strict=False)]
        session.report.within("S37 once a second: shortest", 0.99, 1.01, min(steps))
        session.report.within("S37 once a second: longest", 0.99, 1.01, max(steps))
        session.expect("S37 on request", session.request(p.DM1))
        session.tx(session.request(p.DM1))
        session.report.equal("S37 the data on request", NONE, session.wait_pgn(p.DM1).data.hex().upper())


def ranges(context: Context) -> None:
    """S36, S37: pitch and roll above and below their ranges; occurrence counts; at once when the set changes."""
    with Node(context, {(0x3110, 1): 0}, scene="tilt=12.34,-5") as session:
        until(session, "S37 before")
        session.put(0x3210, 0, 8000)
        until(session, "S37 pitch above: the bytes in facts", (PITCH, ABOVE, 1))
        session.put(0x3210, 0, 0)
        until(session, "S37 pitch good again")
        session.put(0x3210, 0, -11000)
        until(session, "S37 pitch below: its own count", (PITCH, BELOW, 1))
        session.put(0x3210, 0, 8000)
        until(session, "S37 from below to above: the second time", (PITCH, ABOVE, 2))
        session.put(0x3220, 0, 9501)
        until(session, "S37 roll above too: two codes by BAM", (PITCH, ABOVE, 2), (ROLL, ABOVE, 1))
        session.put(0x3210, 0, 0)
        until(session, "S37 roll above alone", (ROLL, ABOVE, 1))
        session.put(0x3220, 0, -8600)
        until(session, "S37 roll below", (ROLL, BELOW, 1))
        session.put(0x3220, 0, 0)
        until(session, "S37 all good")
        # The border: -90.00 and +90.00 deg are within the range.
        for index, angle, rest in ((0x3210, 1234, (PITCH, BELOW, ABOVE)), (0x3220, -500, (ROLL, BELOW, ABOVE))):
            for target in (9000, -9000):
                session.put(index, 0, target - angle)
                session.wait(lambda frame: False, 0.3)
                data = session.ask(p.DM1)
                session.report.equal(
                    f"S36 {index:04X}h: {target / 100} deg is within the range", NONE, data.hex().upper() if data else None
                )
            for target, kind in ((9001, rest[2]), (-9001, rest[1])):
                session.put(index, 0, target - angle)
                session.wait(lambda frame: False, 0.3)
                data = session.ask(p.DM1) or b""
                found = [(spn, fmi) for spn, fmi, _ in codes(data)][:1]
                session.report.equal(f"S36 {index:04X}h: {target / 100} deg is beyond the range", [(rest[0], kind)], found)
            session.put(index, 0, 0)


def at_once(context: Context) -> None:
    """S37: sent when the set of codes changes, not only at the next second."""
    with Node(context, {(0x3110, 1): 0}) as session:
        until(session, "S37 before")
        for number in range(1, 6):
            first, _ = next_dm1(session)
            session.put(0x3210, 0, 9500)
            after = until(session, f"S37 appears, {number}", (PITCH, ABOVE, number))
            session.report.within(f"S37 appears at once, {number}: time after the last DM1", 0.0, 0.9, after.at - first.at)
            first, _ = next_dm1(session)
            session.put(0x3210, 0, 0)
            after = until(session, f"S37 goes, {number}")
            session.report.within(f"S37 goes at once, {number}: time after the last DM1", 0.0, 0.9, after.at - first.at)


def by_bam(context: Context) -> None:
    """S37: two codes: BAM with packets 50..200 ms apart, by RTS/CTS if one node asks."""
    with Node(context, {(0x3110, 1): 0}) as session:
        session.put(0x3210, 0, 9500)
        session.put(0x3220, 0, -9500)
        two = ((PITCH, ABOVE, 1), (ROLL, BELOW, 1))
        until(session, "S37 two codes", *two)
        first, data = next_dm1(session)
        session.report.equal("S37 announcement of 10 bytes", p.bam(0x80, p.DM1, 10), str(first))
        session.report.equal("S37 the codes", sorted(two), sorted(codes(data)))
        second, _ = next_dm1(session)
        session.report.within("S37 once a second by BAM", 0.98, 1.02, second.at - first.at)
        session.others.clear()
        session.tx(session.request(p.DM1))
        opened = session.wait_text(p.rts(0x80, p.ME, p.DM1, 10))
        session.report.equal("S26 requested by us: RTS", True, opened is not None)
        session.others.clear()
        session.tx(p.cts(p.ME, 0x80, p.DM1, 2, 1))
        parts = [session.wait(lambda frame: p.split(frame).destination == p.ME) for _ in range(2)]
        got = b"".join(frame.data[1:] for frame in parts if frame)[:10]
        session.report.equal("S26 requested by us: the same data", data, got)
        session.tx(p.end_of_message(p.ME, 0x80, p.DM1, 10))
        for _ in range(3):
            # A request to all, at any time between two cyclic ones: DM1 by BAM, and never two BAMs mixed.
            session.wait(lambda frame: False, 0.27)
            session.others.clear()
            session.tx(session.request(p.DM1, p.GLOBAL), session.request(p.COMPONENT, p.GLOBAL))
            session.wait(lambda frame: False, 0.8)
            lines = [str(frame) for frame in session.others if p.split(frame).destination == p.GLOBAL]
            session.report.equal("S29 one BAM after the other", [], mixed(lines))
        session.others.clear()
        session.put(0x3220, 0, 0)
        until(session, "S37 one code again: one frame", two[0])


def mixed(lines: list[str]) -> list[str]:
    """The frames of BAMs that are not in their order: each announcement is followed by its packets."""
    wrong, count, last = [], 0, 0
    for line in lines:
        if line.startswith("1CECFF80#20"):
            if last < count:
                wrong.append(line)
            count, last = int(line[15:17], 16), 0
        elif line.startswith("1CEBFF80#"):
            if int(line[9:11], 16) != last + 1:
                wrong.append(line)
            last += 1
    # The last one may not be finished yet.
    return wrong


def supply(context: Context) -> None:
    """S37, S69: supply voltage below 8.0 V and above 36.0 V, gone at 8.5 V and 35.5 V."""
    volts = [(0.0, 24.0), (4.0, 7.5), (7.0, 8.2), (9.0, 24.0), (12.0, 37.0), (15.0, 35.8), (17.0, 30.0), (20.0, 7.0)]
    with Node(context, scene=supply_scene(context.folder / "volts.csv", volts)) as session:
        until(session, "S37 24 V")
        until(session, "S37 7.5 V: below", (SUPPLY, VOLTAGE_BELOW, 1))
        held, _ = next_dm1(session)
        session.report.equal("S69 still below", (SUPPLY, VOLTAGE_BELOW, 1), codes(held.data)[0])
        until(session, "S37 24 V again", timeout=12.0)
        until(session, "S37 37 V: above", (SUPPLY, VOLTAGE_ABOVE, 1), timeout=12.0)
        until(session, "S37 30 V", timeout=12.0)
        until(session, "S37 7 V: below for the second time", (SUPPLY, VOLTAGE_BELOW, 2), timeout=12.0)


def clipping(context: Context) -> None:
    """S36, S37: while the accelerometer clips: FMI 2 of both angles; one axis too."""
    lines = "t_s,ax_g,ay_g,az_g\n0,{0}\n4,{0}\n4.001,{1}\n9,{1}\n9.001,{0}\n"
    for variant, level, shock in ((1, "0,0,1", "0,0,3"), (0, "0,1,0", "0,3,0")):
        path = context.folder / f"clip{variant}.csv"
        path.write_text(lines.format(level, shock))
        with Node(context, {(0x3110, 1): 0, (0x3120, 1): variant}, scene=path, name=f"clip{variant}") as session:
            until(session, f"S37 variant {variant}: before")
            until(session, f"S37 variant {variant}: clipping", (PITCH, ERRATIC, 1), (ROLL, ERRATIC, 1), timeout=12.0)
            until(session, f"S37 variant {variant}: afterwards", timeout=12.0)


def memory(context: Context) -> None:
    """S37, S70: damaged memory: SPN 630 FMI 12, until the next good save."""
    with Node(context) as session:
        session.put(0x3210, 0, 5)
        session.save()
        session.put(0x3210, 0, 6)
        session.save()
        store = session.options["store"]
        session.power_down()
        newest = record.find(store)[-1]
        record.flip(store, newest.offset + record.HEADER + 20)
        session.power_up()
        until(session, "S37 memory", (MEMORY, BAD, 1))
        session.reads("J29 the older values are in force", 0x3210, 0, 5)
        session.put(0x3220, 0, 9500)
        until(session, "S37 memory and roll", (MEMORY, BAD, 1), (ROLL, ABOVE, 1))
        session.put(0x3220, 0, 0)
        session.save()
        until(session, "S70 gone after a good save")


def network(context: Context) -> None:
    """S37: error passive, because nobody acknowledges the claim: SPN 639 FMI 2, and then it goes."""
    with Node(context, online=False) as session:
        session.power_down()
        session.online = True
        session.power_up(boot=False, alone=1.5)
        session.wait_online()
        # Whether DM1 shows it after the recovery depends on the time; the history of CANopen has it.
        found = [session.get(0x1003, sub) & 0xFFFF for sub in range(1, session.get(0x1003) + 1)]
        session.report.verdict(
            not found or set(found) == {0x8120}, "S37 history", "8120h or nothing", [f"{one:04X}h" for one in found]
        )
        until(session, "S37 afterwards: no code")


def counts(context: Context) -> None:
    """S37: the count ends at 126, and begins anew at the next start."""
    with Node(context, {(0x3110, 1): 0}) as session:
        for number in range(1, 131):
            session.put(0x3210, 0, 9500)
            deadline = 200
            while not session.get(0x1001) and deadline:
                deadline -= 1
            data = session.ask(p.DM1) or b""
            expected = min(number, 126)
            if codes(data)[:1] != [(PITCH, ABOVE, expected)]:
                session.report.equal(f"S37 occurrence {number}", message((PITCH, ABOVE, expected)).hex(), data.hex())
                break
            session.put(0x3210, 0, 0)
            deadline = 200
            while session.get(0x1001) and deadline:
                deadline -= 1
        session.report.equal("S37 occurrence counts 1..126, and no further", 130, number)
        session.put(0x3210, 0, 9500)
        session.save()
        session.reset()
        until(session, "S37 after a restart: 1", (PITCH, ABOVE, 1))


def unsupported(context: Context) -> None:
    """S37: DM2..DM13 are not supported."""
    groups = {
        "DM2": 65227,
        "DM3": 65228,
        "DM4": 65229,
        "DM5": 65230,
        "DM6": 65231,
        "DM7": 58112,
        "DM8": 65232,
        "DM10": 65234,
        "DM11": 65235,
        "DM12": 65236,
        "DM13": 57088,
    }
    with Node(context) as session:
        for name, pgn in groups.items():
            session.expect(f"S37 S26 {name} to us", session.request(pgn), p.nack(pgn))
            session.expect(f"S37 S26 {name} to all", session.request(pgn, p.GLOBAL))
        session.expect("S37 a DM13 is ignored", p.shown(57088, p.ME, bytes(8), 0xFF))
        first, _ = next_dm1(session)
        second, _ = next_dm1(session)
        session.report.within("S37 DM1 goes on", 0.99, 1.01, second.at - first.at)
        session.becomes("S35 and SSI2 is good", p.SSI2, v.ssi2(0.0, 0.0))


GROUPS = (cadence, ranges, at_once, by_bam, supply, clipping, memory, network, counts, unsupported)
