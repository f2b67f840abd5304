"""Diagnostics: DM1 with its lamps, codes, occurrence counts, one frame or BAM (S37)."""

from pathlib import Path

from canopen_cases.ims360_emergency import supply_scene
from canopen_cases.runner import Context
from gemac import record
from gemac.harness import Tester

from . import protocol as p
from . import values as v
from .cases_request import texts
from .dm1 import NONE, Dm1Log, codes, message
from .session import AT_ONCE, DM1_PERIOD, SILENCE, Node

PITCH, ROLL, SUPPLY, MEMORY, NETWORK = 4976, 4977, 168, 630, 639
ABOVE, BELOW, ERRATIC, VOLTAGE_ABOVE, VOLTAGE_BELOW, BAD = 0, 1, 2, 3, 4, 12


def cadence(context: Context) -> None:
    """S37: without a code, these bytes, once a second, with priority 6."""
    with Node(context) as session:
        log = Dm1Log(session)
        found = [log.next() for _ in range(6)]
        session.report.equal("S37 no code", [NONE] * 6, [str(one) for one in found])
        steps = [later.begin - earlier.begin for earlier, later in zip(found, found[1:], strict=False)]
        session.report.within("S37 once a second: shortest", *DM1_PERIOD, min(steps))
        session.report.within("S37 once a second: longest", *DM1_PERIOD, max(steps))
        heads = {frame.id & 0x1FFF_FFFF for frame in session.all_of(p.DM1, 1.5)}
        session.report.equal("S37 identifier", {0x18FECA80}, heads)
        session.tx(session.request(p.DM1))
        session.report.equal("S37 the data on request", f"18FECA80#{NONE}", str(session.wait_pgn(p.DM1, AT_ONCE)))


def ranges(context: Context) -> None:
    """S36, S37: pitch and roll above and below their ranges; occurrence counts; at once when the set changes."""
    with Node(context, {(0x3110, 1): 0}, scene="tilt=12.34,-5") as session:
        log = Dm1Log(session)
        log.until("S37 before")
        log.put(0x3210, 0, 8000)
        log.until("S37 pitch above: the bytes in facts", (PITCH, ABOVE, 1))
        log.put(0x3210, 0, 0)
        log.until("S37 pitch good again")
        log.put(0x3210, 0, -11000)
        log.until("S37 pitch below: its own count", (PITCH, BELOW, 1))
        log.put(0x3210, 0, 8000)
        log.until("S37 from below to above: the second time", (PITCH, ABOVE, 2))
        log.put(0x3220, 0, 9501)
        log.until("S37 roll above too: two codes by BAM", (PITCH, ABOVE, 2), (ROLL, ABOVE, 1))
        log.put(0x3210, 0, 0)
        log.until("S37 roll above alone", (ROLL, ABOVE, 1))
        log.put(0x3220, 0, -8600)
        log.until("S37 roll below", (ROLL, BELOW, 1))
        log.put(0x3220, 0, 0)
        log.until("S37 all good")
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
    """S37: sent when the set of codes changes, not only at the next second: one message for each change."""
    with Node(context, {(0x3110, 1): 0}) as session:
        log = Dm1Log(session)
        log.until("S37 before")
        for number in range(1, 6):
            for name, angle, found in (("appears", 9500, [(PITCH, ABOVE, number)]), ("goes", 0, [])):
                # At different times after the last DM1.
                session.sleep(0.07 * number)
                log.put(0x3210, 0, angle)
                log.until(f"S37 {name} at once, {number}", *found)
                rest = [str(one) for one in log.collect(0.9)]
                session.report.equal(f"S37 {name}, {number}: once", [], rest)
                log.next()


def by_bam(context: Context) -> None:
    """S37: two codes: BAM with packets 50..200 ms apart, by RTS/CTS if one node asks."""
    with Node(context, {(0x3110, 1): 0}) as session:
        log = Dm1Log(session)
        log.until("S37 before")
        log.put(0x3210, 0, 9500)
        log.until("S37 one code", (PITCH, ABOVE, 1))
        two = ((PITCH, ABOVE, 1), (ROLL, BELOW, 1))
        log.put(0x3220, 0, -9500)
        first = log.until("S37 two codes", *two)
        second = log.next()
        session.report.within("S37 once a second by BAM", *DM1_PERIOD, second.begin - first.begin)
        data = second.data
        announced = session.wait_pgn(p.TP_CM, 1.2)
        session.report.equal("S37 announcement of 10 bytes", p.bam(0x80, p.DM1, 10), str(announced))
        session.wait(lambda frame: False, 0.2)
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
            announced = {line for line in lines if line.startswith("1CECFF80#20")}
            wanted = {p.bam(0x80, p.COMPONENT, len(texts(session)[p.COMPONENT])), p.bam(0x80, p.DM1, 10)}
            session.report.equal("S26 both are answered", wanted, announced)
        log = Dm1Log(session)
        log.until("S37 two codes still", *two)
        log.put(0x3220, 0, 0)
        log.until("S37 one code again: one frame", two[0])


def mixed(lines: list[str]) -> list[str]:
    """The frames of BAMs that are not in their order: each announcement is followed by its packets. The first packets may be those
    of an earlier announcement."""
    begin = next((place for place, line in enumerate(lines) if line.startswith("1CECFF80#20")), len(lines))
    wrong, count, last = [], 0, 0
    for line in lines[begin:]:
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


MEASURED = 0.4  # s from a supply voltage to its code: the voltage is a mean value


def supply(context: Context) -> None:
    """S37, S69: supply voltage below 8.0 V and above 36.0 V, gone at 8.5 V and 35.5 V."""
    volts = [(0.0, 24.0), (2.0, 7.5), (4.0, 8.2), (6.0, 24.0), (8.0, 37.0), (10.0, 35.8), (12.0, 30.0), (14.0, 7.0)]
    changes = (
        ("7.5 V: below, also at 8.2 V", 2.0, [(SUPPLY, VOLTAGE_BELOW, 1)]),
        ("24 V again", 6.0, []),
        ("37 V: above, also at 35.8 V", 8.0, [(SUPPLY, VOLTAGE_ABOVE, 1)]),
        ("30 V", 12.0, []),
        ("7 V: below for the second time", 14.0, [(SUPPLY, VOLTAGE_BELOW, 2)]),
    )
    with Node(context, scene=supply_scene(context.folder / "volts.csv", volts)) as session:
        log = Dm1Log(session)
        log.until("S37 24 V")
        for name, at, found in changes:
            log.changed = at
            log.until(f"S37 S69 {name}", *found, timeout=5.0, limit=MEASURED)


SHOCKS = ((2.0, 1), (2.6, 2), (3.43, 3))  # times in s at which the accelerometer clips for one or two samples, and the counts
SHOCK = 0.006
HELD = 0.1  # s that the code of a clipped sample is active


def shocks(path: Path, level: str, shock: str, times: list[float]) -> Path:
    """A scene with shocks at these times."""
    rows = [(0.0, level)]
    for at in times:
        rows += [(at, level), (at + 0.0001, shock), (at + SHOCK, shock), (at + SHOCK + 0.0001, level)]
    path.write_text("t_s,ax_g,ay_g,az_g\n" + "".join(f"{at:.4f},{value}\n" for at, value in rows))
    return path


def clipping(context: Context) -> None:
    """S36, S37: after a clipped sample: FMI 2 of both angles, with one axis too. The whole sequence of DM1: a receiver never has an
    older message after a newer one."""
    for variant, level, shock in ((1, "0,0,1", "0,0,3"), (0, "0,1,0", "0,3,0")):
        path = shocks(context.folder / f"clip{variant}.csv", level, shock, [at for at, _ in SHOCKS])
        with Node(context, {(0x3110, 1): 0, (0x3120, 1): variant}, scene=path, name=f"clip{variant}") as session:
            log = Dm1Log(session)
            log.until(f"S37 variant {variant}: before")
            for at, count in SHOCKS:
                log.changed = at
                name = f"S37 variant {variant}, shock {count}"
                log.until(f"{name}: two codes", (PITCH, ERRATIC, count), (ROLL, ERRATIC, count))
                log.changed = at + SHOCK + HELD
                log.until(f"{name}: afterwards")


def clipping_within_a_bam(context: Context) -> None:
    """S29, S37: the codes come and go while another BAM runs: the last DM1 is right, and a message of 8 bytes is no BAM."""
    times = (2.0, 3.0, 4.2)
    path = shocks(context.folder / "shocks.csv", "0,0,1", "0,0,3", list(times))
    with Node(context, {(0x3110, 1): 0}, scene=path) as session:
        log = Dm1Log(session)
        log.until("S37 before")
        for at in times:
            session.sleep(at - 0.01 - session.now())
            session.tx(session.request(p.COMPONENT, p.GLOBAL))
            found = log.collect(at + 0.45 - session.now())
            wrong = [one.wrong for one in found if one.wrong]
            session.report.equal(f"S37 S29 shock at {at} s within a BAM: each DM1 is right", [], wrong)
            told_last = str(found[-1]) if found else "nothing"
            session.report.equal(f"S37 S29 shock at {at} s within a BAM: the last DM1", NONE, told_last)


def steady_clipping(context: Context) -> None:
    """S36, S37: while the accelerometer clips for some seconds."""
    lines = "t_s,ax_g,ay_g,az_g\n0,0,0,1\n2,0,0,1\n2.0001,0,0,3\n5.5,0,0,3\n5.5001,0,0,1\n"
    path = context.folder / "clip.csv"
    path.write_text(lines)
    with Node(context, {(0x3110, 1): 0}, scene=path) as session:
        log = Dm1Log(session)
        log.until("S37 before")
        log.changed = 2.0
        log.until("S37 clipping", (PITCH, ERRATIC, 1), (ROLL, ERRATIC, 1))
        log.changed = 5.5 + HELD
        log.until("S37 afterwards", timeout=4.0)


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
        log = Dm1Log(session)
        log.until("S37 memory", (MEMORY, BAD, 1))
        session.reads("J29 the older values are in force", 0x3210, 0, 5)
        log.put(0x3220, 0, 9500)
        log.until("S37 memory and roll", (MEMORY, BAD, 1), (ROLL, ABOVE, 1))
        log.put(0x3220, 0, 0)
        log.until("S37 memory alone", (MEMORY, BAD, 1))
        log.changed = session.now()
        session.save()
        log.until("S70 gone after a good save")


def network(context: Context) -> None:
    """S37: error passive, because nobody acknowledges: SPN 639 FMI 2, and then it goes."""
    with Node(context, online=False) as session:
        session.power_down()
        session.online = True
        session.power_up(boot=False, alone=1.5)
        claim = session.wait_pgn(p.CLAIMED)
        log = Dm1Log(session)
        first = log.until("S37 nobody acknowledges the claim, over before the first DM1: it has no code")
        session.report.within("S22 the first DM1 ends the silence", *SILENCE, first.begin - claim.at)
        session.wait_online()
        found = [session.get(0x1003, sub) & 0xFFFF for sub in range(1, session.get(0x1003) + 1)]
        session.report.equal("S37 history", ["8120h"], [f"{one:04X}h" for one in found])
        log = Dm1Log(session)
        log.until("S37 before")
        session.tester.close()
        session.sleep(2.0)
        session.tester = Tester(session.sensor)
        log.until("S37 nobody acknowledges for 2 s: error passive", (NETWORK, ERRATIC, 2))
        # Each frame that is acknowledged lowers the error counter by one.
        log.until("S37 afterwards: no code", timeout=10.0)


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
        Dm1Log(session).until("S37 after a restart: 1", (PITCH, ABOVE, 1))


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
        log = Dm1Log(session)
        first, second = log.next(), log.next()
        session.report.within("S37 DM1 goes on", *DM1_PERIOD, second.begin - first.begin)
        session.becomes("S35 and SSI2 is good", p.SSI2, v.ssi2(0.0, 0.0))


GROUPS = (
    cadence, ranges, at_once, by_bam, supply, clipping, clipping_within_a_bam, steady_clipping, memory, network, counts, unsupported,
)  # fmt: skip
