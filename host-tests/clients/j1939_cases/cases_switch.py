"""Between CANopen and J1939: what switches, what is kept, which frames each mode hears and sends (S17..S20, S38)."""

import re

from canopen_cases import ims360_store
from canopen_cases import protocol as c
from canopen_cases.ims360_objects import MAPPABLE
from canopen_cases.runner import Context

from . import protocol as p
from .session import START_TIME, Node

# A value that differs from the factory's, for each setting of J1939.
OURS = {
    (0x2102, 0): 200,
    (0x2104, 1): 50,
    (0x2104, 2): 20,
    (0x2104, 3): 65535,
    (0x2104, 4): 10,
    (0x2105, 1): 0,
    (0x2105, 2): 7,
    (0x2105, 3): 1,
    (0x2105, 4): 6,
    (0x2106, 1): 0,
    (0x2106, 2): 7,
    (0x2106, 3): 15,
    (0x2106, 4): 127,
    (0x2106, 5): 255,
    (0x2106, 6): 31,
    (0x2106, 7): 7,
    (0x2106, 8): 0,
}


def everything(session: Node) -> dict[str, str]:
    """The value of each setting but 3100h:01, and of each constant."""
    keys = [key for key, one in p.TABLE.items() if one.readable and key not in VOLATILE]
    return {str(p.TABLE[key]): session.upload(*key).hex() for key in keys}


# Measured values, states, 3100h:01, and what follows the history of faults.
VOLATILE = {
    key
    for key in MAPPABLE
    if key[0] in (0x3000, 0x3010, 0x3011, 0x3012, 0x3013, 0x3020, 0x3021, 0x3022, 0x3023, 0x6110, 0x6120, 0x6511)
}
VOLATILE |= {p.SWITCH, (0x1001, 0), (0x1003, 0), (0x2020, 1)}


def changed(session: Node) -> None:
    """Changes every setting that CANopen has, and those of J1939."""
    ims360_store.change(session)
    for key, value in OURS.items():
        session.put(*key, value)


def both_ways(context: Context) -> None:
    """S17, S20, S38: there and back, over restarts by 2010h:01, every parameter is kept."""
    log = context.folder / "both.log"
    with Node(context, mode=p.CANOPEN, log=log) as session:
        changed(session)
        before = everything(session)
        session.put(*p.SWITCH, p.J1939)
        session.reads("S17 reads what was written", *p.SWITCH, p.J1939)
        session.download(0x1010, 1, c.SAVE)
        session.mode, session.address = p.J1939, 200
        session.nmt(c.RESET_NODE)
        name = p.Name(0, 7, 15, 127, 255, 31, 7, 0)
        frame = session.wait_pgn(p.CLAIMED, START_TIME)
        session.report.equal(
            "S17 S21 S22 reset node: the claim with all fields of the NAME", p.claim(200, name.data), str(frame)
        )
        session.wait_online()
        session.report.equal("S38 every parameter as over CANopen", before, everything(session))
        session.reads("S17 3100h:01", *p.SWITCH, 1)
        session.power_cycle()
        session.report.equal("S38 every parameter after power off and on", before, everything(session))
        session.put(*p.SWITCH, p.CANOPEN)
        session.reads("S17 reads what was written", *p.SWITCH, p.CANOPEN)
        session.save()
        session.restart()
        session.mode = p.CANOPEN
        session.report.equal("S38 2010h:01: boot-up message of CANopen", True, session.wait_boot_up(START_TIME))
        session.report.equal("S17 every parameter is back", before, everything(session))
        session.power_cycle()
        session.report.equal("S17 every parameter after power off and on", before, everything(session))


def when(context: Context) -> None:
    """S17: in force after store and restart, not after reset communication, not without store."""
    with Node(context, mode=p.CANOPEN) as session:
        for value in (0, 3, 128, 255):
            session.refused(f"S17 3100h:01 = {value}", c.INVALID_VALUE, session.put, *p.SWITCH, value)
            session.reads("S17 nothing changed", *p.SWITCH, p.CANOPEN)
        session.put(*p.SWITCH, p.J1939)
        session.report.equal("S17 not stored: reset communication stays CANopen", True, session.reset(c.RESET_COMMUNICATION))
        session.report.equal("S17 not stored: reset node stays CANopen", True, session.reset(c.RESET_NODE))
        session.power_cycle()
        session.reads("S17 not stored: after power off and on", *p.SWITCH, p.CANOPEN)
        session.put(*p.SWITCH, p.J1939)
        session.download(0x1010, 4, c.SAVE)
        session.report.equal("S17 stored: reset communication stays CANopen", True, session.reset(c.RESET_COMMUNICATION))
        session.reads("S17 stored: reads 1 in CANopen mode", *p.SWITCH, p.J1939)
        session.mode = p.J1939
        session.nmt(c.RESET_NODE)
        frame = session.wait_pgn(p.CLAIMED, START_TIME)
        session.report.equal("S17 S54 stored by 1010h:04: reset node", p.claim(), str(frame))
    with Node(context, mode=p.CANOPEN, name="restart") as session:
        session.put(*p.SWITCH, p.J1939)
        session.download(0x1010, 1, c.SAVE)
        session.put(0x2010, 1, 1)
        session.mode = p.J1939
        frame = session.wait_pgn(p.CLAIMED, START_TIME)
        session.report.equal("S17 2010h:01", p.claim(), str(frame))
    with Node(context) as session:
        for value in (0, 3, 255):
            session.refused(f"S17 J1939 mode: 3100h:01 = {value}", c.INVALID_VALUE, session.put, *p.SWITCH, value)
        session.put(*p.SWITCH, p.CANOPEN)
        session.report.equal("S17 not stored: 2010h:01 stays J1939", p.claim(), str(session.restarted()))
        session.wait_online()
        session.reads("S17 not stored: 3100h:01", *p.SWITCH, p.J1939)


def restart(context: Context) -> None:
    """S38, S64: 2010h:01 resets after its answer, as power does: the next frame is the claim."""
    with Node(context, {(0x2104, 1): 10, (0x2104, 2): 20}) as session:
        answer = p.shown(p.PROPRIETARY_A, session.address, bytes.fromhex("6010200100000000"), session.me)
        for name, before in (("SSI2 and SSI", []), ("a BAM", [session.request(p.COMPONENT, p.GLOBAL)])):
            session.wait(lambda frame: False, 0.3)
            session.tx(*before)
            session.wait(lambda frame: False, 0.03)
            session.send_to(session.address, bytes.fromhex("2F10200101"))
            found = session.wait_text(answer)
            session.report.equal(f"S64 {name}: answer to 2010h:01", answer, str(found))
            frames = session.tester.collect(0.02)
            session.tx(session.request(p.COMPONENT), session.request(p.CLAIMED), p.shown(p.CLAIMED, session.address, p.LOWER))
            frames += session.tester.collect(START_TIME)
            session.report.equal(f"S64 {name}: the next frame", p.claim(), str(frames[0]) if frames else "nothing")


def restored(context: Context) -> None:
    """S38: 1011h:01, :04 and :05 lead back to CANopen at the next restart; :02 and :03 do not."""
    for sub, leads in ((1, True), (2, False), (3, False), (4, True), (5, True)):
        with Node(context, name=f"load{sub}") as session:
            session.load(sub)
            session.report.equal(f"S55 1011h:{sub:02X} changes nothing before the restart", 1, session.get(*p.SWITCH))
            session.restart()
            if leads:
                session.mode = p.CANOPEN
                session.report.equal(f"S38 1011h:{sub:02X} leads to CANopen", True, session.wait_boot_up(START_TIME))
                session.clear_error_passive()
                session.reads(f"S38 1011h:{sub:02X}: 3100h:01", *p.SWITCH, p.CANOPEN)
                session.reads(f"S54 1011h:{sub:02X}: 2104h:01", 0x2104, 1, 10)
                # Without a save, the start after that has the stored values (S55).
                session.nmt(c.RESET_NODE)
                session.mode = p.J1939
                session.report.equal(
                    f"S55 1011h:{sub:02X}: the start after that", p.claim(), str(session.wait_pgn(p.CLAIMED, START_TIME))
                )
            else:
                session.report.equal(f"S38 1011h:{sub:02X} stays J1939", p.claim(), str(session.wait_pgn(p.CLAIMED, START_TIME)))


def silence(context: Context) -> None:
    """S18: J1939 mode neither sends nor hears 11-bit frames, remote frames and frames with the extended data page bit."""
    log = context.folder / "silence.log"
    with Node(context, {(0x1017, 0): 100, (0x1800, 2): 1, (0x1800, 5): 50}, log=log) as session:
        frames = {
            "NMT start": "000#0132",
            "NMT reset node": "000#8132",
            "NMT reset communication": "000#8232",
            "NMT, all nodes": "000#8100",
            "SYNC": "080#",
            "SDO": "632#4000100000000000",
            "SDO write of 3100h:01": "632#2F00310102000000",
            "LSS identify": "7E5#4C00000000000000",
            "LSS switch, inquire": "7E5#0401000000000000",
            "LSS inquire": "7E5#5E00000000000000",
            "LSS fastscan": "7E5#5100000000800000",
        }
        for name, frame in frames.items():
            session.expect(f"S18 {name}", frame)
        session.expect("S18 request with the extended data page bit", "1AEA8021#EBFE00")
        session.expect("S18 request with both page bits", "1BEA8021#EBFE00")
        session.expect("S18 SDO with the extended data page bit", "1AEF8021#4000100000000000")
        session.expect("S18 claim with the extended data page bit", f"1AEEFF80#{p.LOWER.hex()}")
        session.expect("S18 request on data page 1", "19EA8021#EBFE00")
        session.expect("S18 SDO on data page 1", "19EF8021#4000100000000000")
        for number in (0x18EA8021, 0x18EF8021, 0x0CF02980, 0x732, 0x1B2, 0x632):
            session.others.clear()
            session.tester.send(number | (p.EXTENDED if number > 0x7FF else 0), remote=True, dlc=8)
            session.report.equal(f"S18 remote frame {number:X}", [], session.after())
        session.reads("S18 3100h:01 is still", *p.SWITCH, 1)
        # An emergency identifier of 29 bits (S46) has no effect in J1939 mode.
        for cob_id in (c.INVALID | 0xB2, 1 << 29 | 0x12345):
            session.put(0x1014, 0, cob_id)
        session.others.clear()
        session.put(0x3210, 0, 9500)
        session.wait(lambda frame: False, 0.5)
        session.report.equal("S18 no EMCY with 29 bits", [], session.shown_others())
        session.expect("S18 and a request is answered", session.request(p.CLAIMED), p.claim())
        text = log.read_text()
    heard = set(frames.values())
    own = {line for line in re.findall(r"can0 ([0-9A-F]{3}#\S*)", text) if line not in heard and "#R" not in line}
    session.report.equal("S18 no 11-bit frame was sent: no boot-up, heartbeat, EMCY", set(), own)


def canopen_deaf(context: Context) -> None:
    """S18: CANopen mode ignores 29-bit frames."""
    with Node(context, mode=p.CANOPEN) as session:
        for frame in (
            "18EAFFFE#00EE00",
            "18EAFF21#00EE00",
            "18EA8021#00EE00",
            "18EA3221#00EE00",
            "18EF8021#4000100000000000",
            "18EF3221#4000100000000000",
            f"18EEFF80#{p.LOWER.hex()}",
            f"18EEFF32#{p.LOWER.hex()}",
            "1CECFF21#20090002FFD8FE00",
            "1CEC8021#10090002FFD8FE00",
            "00000632#4000100000000000",
            "00000000#8132",
            "00000080#",
        ):
            session.others.clear()
            session.tx(frame)
            session.get(0x1018, 1)
            session.report.equal(f"S18 CANopen mode ignores {frame}", [], [str(one) for one in session.others])


def bit_rate(context: Context) -> None:
    """S19: 2001h holds in both modes, the factory's rate too."""
    for value, kbits in ((250_000, "250"), (500_000, "500"), (125_000, "125")):
        with Node(context, {(0x2001, 0): value}, bus_rate=kbits, name=f"rate{kbits}") as session:
            session.reads(f"S19 2001h on a bus of {kbits} kbit/s", 0x2001, 0, value)
    with Node(context, bus_rate="250", online=False, name="rate") as session:
        session.tx(session.request(p.CLAIMED, p.GLOBAL))
        session.dead("S19 125 kbit/s is kept in J1939 mode: nothing on a bus of 250 kbit/s", 1.0)


LIMITS = {
    (0x2102, 0): ([0, 1, 127, 128, 247, 248, 253], [254, 255]),
    **{(0x2104, sub): ([0, 10, 11, 100, 65535], [1, 2, 5, 9]) for sub in (1, 2, 3, 4)},
    **{(0x2105, sub): ([0, 1, 6, 7], [8, 9, 128, 255]) for sub in (1, 2, 3, 4)},
    (0x2106, 1): ([0, 1], [2, 255]),
    (0x2106, 2): ([0, 7], [8, 255]),
    (0x2106, 3): ([0, 15], [16, 255]),
    (0x2106, 4): ([0, 127], [128, 255]),
    (0x2106, 5): ([0, 145, 255], []),
    (0x2106, 6): ([0, 31], [32, 255]),
    (0x2106, 7): ([0, 7], [8, 255]),
    (0x2106, 8): ([0, 2047], [2048, 65535]),
}


def objects(context: Context) -> None:
    """S20, S21: size, factory value and limits of the objects of J1939, in both modes."""
    for mode in (p.CANOPEN, p.J1939):
        with Node(context, {(0x2104, 1): 10}, mode=mode, name=f"mode{mode}") as session:
            for one in p.OBJECTS:
                value = session.upload(one.index, one.sub)
                if one.default is not None:
                    session.report.equal(f"S20 S21 mode {mode}, {one}: factory value", one.expected(), value)
                if not one.writable:
                    session.refused(
                        f"S20 mode {mode}, {one} is read-only", c.READ_ONLY, session.download, one.index, one.sub, value
                    )
            serial = session.get(0x1018, 4)
            session.report.equal(f"S21 mode {mode}, 2106h:09", serial & 0x1F_FFFF, session.get(0x2106, 9))
            for index, sub in ((0x2102, 1), (0x2104, 5), (0x2105, 5), (0x2106, 10)):
                session.refused(f"S20 mode {mode}, {index:04X}h:{sub:02X}", c.NO_SUB_INDEX, session.upload, index, sub)
            for index in (0x2100, 0x2101, 0x2103, 0x2107):
                session.refused(f"S20 mode {mode}, {index:04X}h", c.NO_OBJECT, session.upload, index, 0)
            if mode == p.CANOPEN:
                for key in ((0x2102, 0), (0x2104, 2), (0x2105, 4), (0x2106, 5)):
                    factory = p.TABLE[key].default
                    session.put(*key, 7 if key[0] == 0x2105 else 77)
                    session.report.equal(f"S65 {p.TABLE[key]} changed: ST0 bit 2", 0, session.get(0x3000, 1) & 4)
                    session.put(*key, factory)
                    session.report.equal(f"S65 {p.TABLE[key]} as delivered: ST0 bit 2", 4, session.get(0x3000, 1) & 4)
            for key, (good, bad) in LIMITS.items():
                for value in good:
                    session.accepted(f"S20 S21 mode {mode}, {p.TABLE[key]} = {value}", *key, value)
                codes = {c.INVALID_VALUE} if key[0] == 0x2104 else c.RANGE
                for value in bad:
                    session.refused(f"S20 S21 mode {mode}, {p.TABLE[key]} = {value}", codes, session.put, *key, value)
                session.reads(f"S20 S21 mode {mode}, {p.TABLE[key]}: the refused change nothing", *key, good[-1])


GROUPS = (both_ways, when, restart, restored, silence, canopen_deaf, bit_rate, objects)
