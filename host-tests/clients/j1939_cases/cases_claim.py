"""Addresses: the claim at the start, contention, the order of addresses, and a node that cannot claim (S21..S24)."""

from dataclasses import replace

from canopen_cases.runner import Context

from . import protocol as p
from .session import AT_ONCE, SILENCE, START_TIME, Node

RANDOM = (0.0, 0.157)  # 0..153 ms, and the frame
CANNOT = 0xFE


def names(context: Context) -> None:
    """S21: the claim has each field at its place."""
    fields = {
        "as delivered": p.OURS,
        "not capable": replace(p.OURS, capable=0),
        "industry group": replace(p.OURS, industry=5),
        "vehicle system instance": replace(p.OURS, system_instance=9),
        "vehicle system": replace(p.OURS, system=85),
        "function": replace(p.OURS, function=42),
        "function instance": replace(p.OURS, function_instance=21),
        "ECU instance": replace(p.OURS, ecu_instance=5),
        "manufacturer": replace(p.OURS, manufacturer=1365),
        "all ones": p.Name(1, 7, 15, 127, 255, 31, 7, 2047),
        "all zeros": p.Name(0, 0, 0, 0, 0, 0, 0, 0),
    }
    before = p.OURS
    with Node(context) as session:
        for name, value in fields.items():
            for key, setting in value.settings().items():
                session.put(*key, setting)
            session.expect(f"S21 {name}: not before the restart", session.request(p.CLAIMED), p.claim(name=before.data))
            session.save()
            session.report.equal(f"S21 {name}: the claim after the restart", p.claim(name=value.data), str(session.restarted()))
            before = value
            session.wait_online()
            session.expect(
                f"S26 {name}: the answer to a request", session.request(p.CLAIMED, p.GLOBAL), p.claim(name=value.data)
            )


def start(context: Context) -> None:
    """S22: the claim, 250 ms of silence, then the cyclic groups; for every address."""
    for address in (128, 0, 25, 127, 200, 247, 248, 253):
        settings = {(0x2102, 0): address, (0x2104, 1): 10, (0x2104, 4): 10}
        with Node(context, settings, name=f"at{address}") as session:
            session.restart()
            claim = session.wait_pgn(p.CLAIMED, START_TIME)
            session.report.equal(f"S22 address {address}: the claim", p.claim(address), str(claim))
            following = session.wait(lambda frame: True)
            session.report.within(f"S22 address {address}: silence after the claim", *SILENCE, following.at - claim.at)
            found = session.all_of(p.SSI2, 0.5)
            sources = {p.split(frame).source for frame in found}
            session.report.equal(f"S22 address {address}: SSI2 from it", {address}, sources)


def alone(context: Context) -> None:
    """S22: the 250 ms begin when the claim is acknowledged: on a bus without other nodes it stays pending."""
    with Node(context, {(0x2104, 1): 10}) as session:
        for seconds in (0.0, 0.2, 2.0):
            session.power_down()
            session.power_up(boot=False, alone=seconds)
            first = session.wait(lambda frame: True, START_TIME)
            following = session.wait(lambda frame: True)
            session.report.equal(f"S22 alone for {seconds} s: the claim comes first", p.claim(), str(first))
            session.report.within(f"S22 alone for {seconds} s: then silence", *SILENCE, following.at - first.at)


CONTENDING = "claim with a higher NAME"


def waiting(context: Context) -> None:
    """S22: within the 250 ms, only a request for the claim is answered."""
    with Node(context, {(0x2104, 1): 10}) as session:
        answers = {
            "global request for the claim": (session.request(p.CLAIMED, p.GLOBAL), [p.claim()]),
            "request for the claim to us": (session.request(p.CLAIMED), [p.claim()]),
            "request for the claim from 254": (session.request(p.CLAIMED, p.GLOBAL, p.NULL), [p.claim()]),
            "request for SSI2": (session.request(p.SSI2), []),
            "request for DM1": (session.request(p.DM1), []),
            "request for component": (session.request(p.COMPONENT), []),
            "unknown request": (session.request(65262), []),
            "SDO": ("18EF8021#4018100100000000", []),
            CONTENDING: (p.claim(name=p.HIGHER), [p.claim()]),
        }
        for name, (line, expected) in answers.items():
            for after in (0.0, 0.1, 0.24):
                session.restart()
                last = session.wait_pgn(p.CLAIMED, START_TIME)
                session.sleep(after)
                session.others.clear()
                session.tx(line)
                # The end of the silence is DM1 or process data.
                first = session.wait(session.cyclic)
                got = [str(frame) for frame in session.others]
                session.report.equal(f"S22 within the 250 ms, after {after} s: {name}", expected, got)
                if name == CONTENDING and session.others:
                    last = session.others[-1]
                session.report.within(f"S22 S23 {name} after {after} s: the silence", *SILENCE, first.at - last.at)
                session.wait(lambda frame: False, 0.02)


def contention(context: Context) -> None:
    """S23: higher, lower and own NAME, and claims of other addresses."""
    with Node(context) as session:
        session.expect("S23 higher NAME: our claim again", p.claim(name=p.HIGHER), p.claim())
        session.expect("S23 highest NAME", p.claim(name=b"\xff" * 8), p.claim())
        for count in (2, 5):
            lines = [p.claim(name=p.other_name(n, capable=1)[:5] + b"\xff\xff\xff") for n in range(count)]
            got = session.after(*lines)
            session.report.within(f"S23 {count} higher NAMEs: our claim", 1, count, len(got))
            session.report.equal(f"S23 {count} higher NAMEs: nothing but our claim", {p.claim()}, set(got))
        session.expect("S23 our own NAME at our address is ignored", p.claim())
        session.expect("S23 another node claims another address", p.claim(0x90, p.LOWER))
        session.expect("S23 our NAME at another address", p.claim(0x91))
        session.expect("S24 another node cannot claim", p.claim(CANNOT, p.LOWER))
        session.expect("S23 short claim is ignored", p.claim(name=p.LOWER[:7]))
        session.expect("S23 empty claim is ignored", p.claim(name=b""))
        session.tx(p.claim(name=p.LOWER))
        frame = session.wait_pgn(p.CLAIMED, AT_ONCE)
        session.report.equal("S23 lower NAME: the next address", p.claim(0x81), str(frame))
        following = session.tester.collect(0.8)
        left = {p.split(one).source for one in following}
        session.report.equal("S23 nothing more from the old address", {0x81}, left)
        session.report.within("S23 the 250 ms begin anew", *SILENCE, following[0].at - frame.at)
        session.address = 0x81
        session.expect("S23 answers at the new address", session.request(p.CLAIMED), p.claim(0x81))
        session.reads("S23 2102h does not follow a contention", 0x2102, 0, p.PREFERRED)
        session.expect("S23 a request to the old address is for somebody else", session.request(65262, p.PREFERRED))
        session.expect("S23 SDO to the old address", "18EF8021#4018100100000000")
        session.address = p.PREFERRED
        session.report.equal("S23 the next start tries the preferred address", p.claim(), str(restart_at(session, 0x81)))


def restart_at(session: Node, address: int) -> object:
    """Restarts the node at this address, and waits for its first claim."""
    session.address, before = address, session.address
    frame = session.restarted()
    session.address = before
    session.wait_online()
    return frame


def lose(session: Node, name: bytes = p.LOWER) -> int | None:
    """A lower NAME takes the present address; returns the address of the next claim."""
    session.tx(p.claim(session.address, name))
    frame = session.wait_pgn(p.CLAIMED, AT_ONCE)
    if frame is None:
        return None
    session.address = p.split(frame).source
    return session.address


def order(context: Context) -> None:
    """S23: upwards in 128..247 without the addresses that were heard, after 247 from 128 on."""
    with Node(context) as session:
        session.tx(*(p.claim(address, p.other_name(address)) for address in (0x81, 0x82, 0x84, 0x30, 248)))
        steps = [lose(session) for _ in range(3)]
        session.report.equal("S23 addresses that were heard are skipped", [0x83, 0x85, 0x86], steps)
    for preferred, expected in (
        (246, [247, 128, 129]),
        (247, [128, 129]),
        (0, [128, 129]),
        (127, [128]),
        (50, [128]),
        (248, [128]),
        (253, [128, 129]),
    ):
        with Node(context, {(0x2102, 0): preferred}, name=f"order{preferred}") as session:
            steps = [lose(session) for _ in expected]
            session.report.equal(f"S23 from the preferred address {preferred}", expected, steps)
    with Node(context, {(0x2102, 0): 130}, name="around") as session:
        session.tx(*(p.claim(address, p.other_name(address)) for address in range(131, 248)))
        session.sleep(0.2)
        session.report.equal("S23 131..247 taken: 128", 128, lose(session))
        session.report.equal("S23 and 129", 129, lose(session))
        session.address = CANNOT
        session.tx(p.claim(129, p.LOWER))
        frame = session.wait_pgn(p.CLAIMED, RANDOM[1])
        session.report.equal("S24 all addresses taken: cannot claim", p.claim(CANNOT), str(frame))
    with Node(context, name="restarted") as session:
        session.tx(*(p.claim(address, p.other_name(address)) for address in (0x81, 0x82)))
        session.report.equal("S23 heard: next", 0x83, lose(session))
        session.wait_online()
        session.restart()
        session.address = p.PREFERRED
        session.wait_pgn(p.CLAIMED, START_TIME)
        session.wait_online()
        session.report.equal("S23 heard since the start only: next after a restart", 0x81, lose(session))
    with Node(context, name="race") as session:
        session.restart()
        session.wait_pgn(p.CLAIMED, START_TIME)
        steps = [lose(session) for _ in range(5)]
        session.report.equal("S23 a lower NAME within the 250 ms, again and again", [0x81, 0x82, 0x83, 0x84, 0x85], steps)
        session.wait_online()
        session.expect("S23 the last address is kept", session.request(p.CLAIMED), p.claim(0x85))


def back_to_back(context: Context) -> None:
    """S23: the next address is claimed by another node before our own claim of it has left: it is not taken."""
    for count in (1, 2, 3):
        with Node(context, name=f"next{count}") as session:
            taken = [p.claim(p.PREFERRED + step, p.other_name(step)) for step in range(1, count + 1)]
            session.tx(p.claim(name=p.LOWER), *taken)
            session.wait(lambda frame: False, 1.0)
            found = [p.split(frame).source for frame in session.others if p.split(frame).pgn == p.DM1]
            expected = p.PREFERRED + count + 1
            session.report.equal(
                f"S23 lost, and the next {count} claimed at once: the address in the end",
                expected,
                found[-1] if found else None,
            )


def incapable(context: Context) -> None:
    """S24: not capable and lost: cannot claim, after 0..153 ms, then silence."""
    ours = replace(p.OURS, capable=0)
    lower, higher = replace(ours, function=1).data, replace(ours, function=200).data
    log = context.folder / "cannot.log"
    with Node(context, ours.settings() | {(0x2104, 1): 20}, log=log) as session:
        session.expect("S23 not capable, higher NAME: our claim again", p.claim(name=higher), p.claim(name=ours.data))
        session.tx(p.claim(name=lower))
        frame = session.wait_pgn(p.CLAIMED, RANDOM[1])
        session.report.equal("S24 not capable, lower NAME: cannot claim", p.claim(CANNOT, ours.data), str(frame))
        session.tester.collect_until_quiet(0.06, 1.0)
        session.dead("S24 then silence: no SSI2, no DM1", 1.3)
        cannot = p.claim(CANNOT, ours.data)
        for name, line, expected in (
            ("global request for the claim", session.request(p.CLAIMED, p.GLOBAL), [cannot]),
            ("request for the claim to 254", session.request(p.CLAIMED, p.NULL), [cannot]),
            ("request for the claim from 254", session.request(p.CLAIMED, p.GLOBAL, p.NULL), [cannot]),
            ("request for the claim to the old address", session.request(p.CLAIMED, p.PREFERRED), []),
            ("request for SSI2, global", session.request(p.SSI2, p.GLOBAL), []),
            ("request for SSI2 to 254", session.request(p.SSI2, p.NULL), []),
            ("request for component, global", session.request(p.COMPONENT, p.GLOBAL), []),
            ("unknown request to 254", session.request(65262, p.NULL), []),
            ("SDO to 254", "18EFFE21#4018100100000000", []),
            ("SDO to the old address", "18EF8021#4018100100000000", []),
            ("claim of the old address", p.claim(name=higher), []),
            ("RTS to 254", p.rts(p.ME, p.NULL, p.COMPONENT, 20), []),
        ):
            session.tester.collect_until_quiet(0.2, 1.0)
            session.tx(line)
            got = [str(one) for one in session.tester.collect(0.6 if expected else 0.3)]
            session.report.equal(f"S24 cannot claim: {name}", expected, got)
        for _ in range(12):
            session.tx(session.request(p.CLAIMED, p.GLOBAL))
            session.wait_text(cannot, RANDOM[1])
        session.tester.close()
        session.sensor.kill()
    delays = answered(log.read_text(), f"{p.identifier(p.REQUEST, p.ME):08X}", cannot)
    session.report.within("S24 number of delays", 12, 20, len(delays))
    session.report.within("S24 shortest delay", *RANDOM, min(delays))
    session.report.within("S24 longest delay", *RANDOM, max(delays))
    session.report.verdict(
        max(delays) - min(delays) > 0.02, "S24 the delays are random", "> 20 ms apart", [round(one, 3) for one in delays]
    )


def answered(text: str, asked: str, answer: str) -> list[float]:
    """The times between requests and answers in a log."""
    found, since = [], None
    for line in text.splitlines():
        stamp, _, frame = line.split(" ", 2)
        at = float(stamp.strip("()"))
        if frame.startswith(asked):
            since = at
        elif frame.split()[0] == answer and since is not None:
            found.append(at - since)
            since = None
    return found


def at_once(context: Context) -> None:
    """S24: not capable, and the address is taken at the very start; S22 the loser has sent nothing but claims."""
    ours = replace(p.OURS, capable=0)
    with Node(context, ours.settings() | {(0x2104, 1): 10}) as session:
        session.restart()
        claim = session.wait_pgn(p.CLAIMED, START_TIME)
        session.others.clear()
        session.tx(p.claim(name=bytes(8)))
        cannot = session.wait_pgn(p.CLAIMED)
        session.report.equal("S24 lost within the 250 ms", p.claim(CANNOT, ours.data), str(cannot))
        session.report.within("S24 cannot claim within 0..153 ms", *RANDOM, cannot.at - claim.at)
        session.report.equal("S22 nothing in between", [], [str(frame) for frame in session.others])
        session.dead("S24 silence", 0.5)
        # The only exit besides Commanded Address is a new start.
        session.online = False
        session.power_cycle()
        frame = session.wait_pgn(p.CLAIMED, START_TIME)
        session.report.equal("S23 the next start tries again", p.claim(name=ours.data), str(frame))


def both_higher(context: Context) -> None:
    """S23: two nodes claim an address again and again; ours keeps it against each higher NAME."""
    with Node(context, {(0x2104, 1): 10}) as session:
        for number in range(40):
            session.others.clear()
            session.tx(p.claim(name=p.other_name(number, capable=1)[:5] + bytes([200, 0, 0x80])))
            answer = session.wait_pgn(p.CLAIMED, AT_ONCE)
            if str(answer) != p.claim():
                session.report.equal(f"S23 defence {number}", p.claim(), str(answer))
                break
        session.report.equal("S23 defences", 39, number)
        found = session.all_of(p.SSI2, 1.5)
        session.report.within("S23 SSI2 goes on after a defence: frames in 1.5 s", 149, 151, len(found))


GROUPS = (names, start, alone, waiting, contention, order, back_to_back, incapable, at_once, both_higher)
