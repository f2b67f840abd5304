"""The transport protocol, sending: CTS windows, holds, retransmission, aborts, time-outs, several connections (S29)."""

from canopen_cases.runner import Context

from . import protocol as p
from .cases_request import texts
from .session import AT_ONCE, SILENCE, Node


class Transfer:
    """A connection that the sensor has opened to a node after a request."""

    def __init__(self, session: Node, pgn: int = p.ECU, me: int = p.ME) -> None:
        self.session, self.pgn, self.me, self.us = session, pgn, me, session.address
        self.text = texts(session)[pgn]
        self.count = (len(self.text) + 6) // 7
        self.request = session.request(pgn, source=me)

    def open(self, name: str) -> object:
        """Sends the request and checks the RTS."""
        self.session.others.clear()
        self.session.tx(self.request)
        return self.session.comes(f"{name}: RTS", p.rts(self.us, self.me, self.pgn, len(self.text)))

    def cts(self, count: int, first: int) -> str:
        """Clear to send."""
        return p.cts(self.me, self.us, self.pgn, count, first)

    def asked(self, name: str, count: int, first: int) -> bool:
        """Checks that exactly these packets are sent."""
        expected = [p.packet(self.us, self.me, self.text, number) for number in range(first, first + count)]
        return self.session.expect(name, self.cts(count, first), *expected)

    def end(self, name: str) -> None:
        """End of message, and nothing after it."""
        self.session.expect(f"{name}: end", p.end_of_message(self.me, self.us, self.pgn, len(self.text)))

    def abort(self, reason: int = p.TIMEOUT) -> str:
        """The abort of the sensor."""
        return p.abort(self.us, self.me, self.pgn, reason)

    def cancel(self) -> None:
        """Aborts it."""
        self.session.expect("S29 abort by the receiver: no answer", p.abort(self.me, self.us, self.pgn, p.TIMEOUT))


def windows(context: Context) -> None:
    """S29: exactly the packets that each CTS asks for, also again and backwards."""
    with Node(context) as session:
        one = Transfer(session)
        one.open("S29 one packet per CTS")
        for number in range(1, one.count + 1):
            one.asked(f"S29 one packet per CTS: {number}", 1, number)
        one.end("S29 one packet per CTS")
        one.open("S29 two per CTS")
        for number in range(1, one.count, 2):
            one.asked(f"S29 two per CTS: from {number}", min(2, one.count + 1 - number), number)
        if one.count % 2:
            one.asked("S29 two per CTS: the rest", 1, one.count)
        one.end("S29 two per CTS")
        one.open("S29 again")
        one.asked("S29 all", one.count, 1)
        one.asked("S29 all of them again", one.count, 1)
        one.asked("S29 retransmission of packet 2", 1, 2)
        one.asked("S29 retransmission of the last", 1, one.count)
        one.asked("S29 backwards: packet 1", 1, 1)
        one.asked("S29 and on", 2, 2)
        one.end("S29 again")
        one.open("S29 the middle first")
        one.asked("S29 the last first", 1, one.count)
        one.asked("S29 then the first two", 2, 1)
        one.end("S29 the middle first")


def strangers(context: Context) -> None:
    """S29: CTS of another node, for another group or beyond the end is ignored."""
    with Node(context) as session:
        one = Transfer(session)
        one.open("S29 strangers")
        us = one.us
        wrong = {
            "from another node": p.cts(p.OTHER, us, one.pgn, 1, 1),
            "for another group": p.cts(p.ME, us, p.COMPONENT, 1, 1),
            "to another node": p.cts(p.ME, 0x90, one.pgn, 1, 1),
            "to all": p.cts(p.ME, p.GLOBAL, one.pgn, 1, 1),
            "beyond the end": one.cts(1, one.count + 1),
            "far beyond the end": one.cts(1, 255),
            "packet 0": one.cts(1, 0),
            "of 7 bytes": one.cts(1, 1)[:-2],
            "end of message from another node": p.end_of_message(p.OTHER, us, one.pgn, len(one.text)),
            "end of message for another group": p.end_of_message(p.ME, us, p.COMPONENT, len(one.text)),
            "abort from another node": p.abort(p.OTHER, us, one.pgn, 3),
            "abort for another group": p.abort(p.ME, us, p.COMPONENT, 3),
        }  # fmt: skip
        for name, line in wrong.items():
            session.expect(f"S29 CTS {name} is ignored", line)
        one.asked("S29 after all of these, the connection is open", one.count, 1)
        one.end("S29 strangers")
        # A CTS that begins inside and ends beyond the end.
        for count, first in ((2, one.count), (one.count + 1, 1), (255, 1)):
            one.open(f"S29 CTS {count} from {first}")
            one.session.expect("S29 beyond the end: ignored", one.cts(count, first))
            one.cancel()
        session.expect("S29 end of message before the packets", [one.request], p.rts(us, p.ME, one.pgn, len(one.text)))
        got = session.after(p.end_of_message(p.ME, us, one.pgn, len(one.text)), one.cts(1, 1))
        session.report.verdict(
            got in ([], [p.packet(us, p.ME, one.text, 1)]), "S29 early end of message: ends it, or is ignored", "nothing", got
        )


def aborted(context: Context) -> None:
    """S29: the receiver aborts; nothing more is sent, and the next request starts anew."""
    with Node(context) as session:
        for reason in (1, 2, 3, 4, 7, 250):
            one = Transfer(session)
            one.open(f"S29 abort {reason}")
            one.asked("S29 a packet", 1, 1)
            session.expect(f"S29 abort {reason}: silence", p.abort(p.ME, one.us, one.pgn, reason))
            session.expect(f"S29 abort {reason}: CTS is ignored", one.cts(1, 2))
        one = Transfer(session)
        one.open("S29 after the aborts")
        one.asked("S29 after the aborts: all", one.count, 1)
        one.end("S29 after the aborts")
        # The connection also ends within a window.
        one.open("S29 abort within a window")
        session.tx(one.cts(one.count, 1), p.abort(p.ME, one.us, one.pgn, 3))
        got = session.after()
        session.report.verdict(len(got) <= one.count, "S29 abort within a window", "at most the window", got)
        session.silent("S29 nothing afterwards", 0.3)


def time_outs(context: Context) -> None:
    """S29: T3 = 1250 ms after RTS and after the last packet, T4 = 1050 ms after a hold."""
    with Node(context) as session:
        one = Transfer(session)
        rts = one.open("S29 T3")
        abort = session.next(4.0)
        session.report.equal("S29 T3: no CTS after RTS: abort 3", one.abort(), str(abort))
        session.took("S29 T3 after RTS", 1.25, abort.at - rts.at)
        session.expect("S29 T3: CTS after the abort is ignored", one.cts(1, 1))
        one.open("S29 T3 within")
        session.tx(one.cts(2, 1))
        session.next()
        last = session.next()
        abort = session.next(4.0)
        session.report.equal("S29 T3: no CTS after the packets: abort 3", one.abort(), str(abort))
        session.took("S29 T3 after the last packet", 1.25, abort.at - last.at)
        one.open("S29 T3 at the end")
        session.tx(one.cts(one.count, 1))
        for _ in range(one.count):
            last = session.next()
        abort = session.next(4.0)
        session.report.equal("S29 T3: no end of message: abort 3", one.abort(), str(abort))
        session.took("S29 T3 after the whole", 1.25, abort.at - last.at)
        one.open("S29 hold")
        since = session.now()
        session.tx(one.cts(0, 1))
        abort = session.next(4.0)
        session.report.equal("S29 T4: nothing after a hold: abort 3", one.abort(), str(abort))
        session.took("S29 T4", 1.05, abort.at - since)
        rts = one.open("S29 holds")
        for _ in range(4):
            session.silent("S29 hold: nothing is sent", 0.5)
            session.tx(one.cts(0, 1))
        one.asked("S29 after four holds, longer than T3 and T4 together", one.count, 1)
        session.tx(one.cts(0, 1))
        session.silent("S29 hold after the packets", 0.6)
        one.asked("S29 again", 1, one.count)
        one.end("S29 holds")
        rts = one.open("S29 ignored frames do not count")
        session.silent("S29 half of T3", 0.6)
        session.tx(p.cts(p.OTHER, one.us, one.pgn, 0, 1), one.cts(1, 200))
        abort = session.next(4.0)
        session.took("S29 a CTS that is ignored does not extend T3", 1.25, abort.at - rts.at)


def busy(source: int, asker: int, pgn: int) -> str:
    """Acknowledgement 3, "cannot respond"."""
    return p.shown(p.ACKNOWLEDGE, source, bytes([3, 0xFF, 0xFF, 0xFF, asker]) + p.pgn_bytes(pgn))


def together(context: Context) -> None:
    """S29: one BAM and two connections at a time; a third is told "cannot respond"."""
    with Node(context) as session:
        us = session.address
        one, two, three = Transfer(session, p.ECU, 0x21), Transfer(session, p.COMPONENT, 0x22), Transfer(session, p.ECU, 0x23)
        one.open("S29 the first")
        two.open("S29 the second")
        one.asked("S29 the first, packet 1", 1, 1)
        two.asked("S29 the second, packet 1", 1, 1)
        session.others.clear()
        session.tx(session.request(p.COMPONENT, p.GLOBAL, 0x24))
        session.comes("S29 a BAM beside them", p.bam(us, p.COMPONENT, len(two.text)))
        one.session.tx(one.cts(1, 2))
        found = [str(frame) for _ in range(two.count + 1) if (frame := session.next())]
        bam = [line for line in found if line.startswith("1CEBFF")]
        session.report.equal("S29 the BAM is whole", p.packets(us, p.GLOBAL, two.text), bam)
        session.report.equal(
            "S29 the first goes on meanwhile", [p.packet(us, 0x21, one.text, 2)], [line for line in found if line not in bam]
        )
        session.expect("S29 a third: cannot respond", three.request, busy(us, 0x23, p.ECU))
        one.asked("S29 the first, the rest", one.count - 2, 3)
        one.end("S29 the first")
        two.asked("S29 the second, the rest", two.count - 1, 2)
        two.end("S29 the second")
        again = Transfer(session, p.ECU, 0x23)
        again.open("S29 once more")
        again.asked("S29 once more", again.count, 1)
        again.end("S29 once more")
        # Two BAMs do not mix: the second request comes while the first one runs.
        session.tx(session.request(p.COMPONENT, p.GLOBAL), session.request(p.ECU, p.GLOBAL))
        lines = [str(session.next()) for _ in range(2 + one.count + two.count)]
        first = [p.bam(us, p.COMPONENT, len(two.text)), *p.packets(us, p.GLOBAL, two.text)]
        second = [p.bam(us, p.ECU, len(one.text)), *p.packets(us, p.GLOBAL, one.text)]
        session.report.equal("S29 two global requests: one BAM after the other", first + second, lines)
        # The same node asks for the same again: the connection goes on.
        one.open("S29 asked twice")
        session.expect("S29 the same request again: cannot respond", one.request, busy(us, 0x21, p.ECU))
        one.asked("S29 asked twice: all packets once", one.count, 1)
        one.end("S29 asked twice")


def one_for_each(context: Context) -> None:
    """S29: a node that has a connection and asks for another text is told "cannot respond"."""
    with Node(context) as session:
        one, two = Transfer(session, p.ECU), Transfer(session, p.COMPONENT)
        one.open("S29 the first text")
        session.expect("S29 the second text meanwhile: cannot respond", two.request, busy(one.us, p.ME, p.COMPONENT))
        one.asked("S29 the first text goes on", one.count, 1)
        one.end("S29 the first text")
        # A connection that nobody continues is free again after T3.
        one.open("S29 abandoned")
        session.wait(lambda frame: False, 1.26)
        session.others.clear()
        two.open("S29 after T3")
        two.asked("S29 after T3: all", two.count, 1)
        two.end("S29 after T3")


def lost_address(context: Context) -> None:
    """S23, S29: the address is lost in the middle of a transfer: nothing more from the old one."""
    with Node(context, {(0x2104, 1): 10}) as session:
        one = Transfer(session)
        one.open("S29 lost address")
        one.asked("S29 a packet", 1, 1)
        session.tx(session.request(p.COMPONENT, p.GLOBAL), p.claim(name=p.LOWER))
        claim = session.wait_pgn(p.CLAIMED, AT_ONCE)
        session.report.equal("S23 claimed at once", p.claim(0x81), str(claim))
        session.tx(one.cts(one.count, 1))
        frames = [frame for frame in session.tester.collect(1.6)]
        old = [str(frame) for frame in frames if p.split(frame).source == 0x80]
        session.report.equal("S23 nothing from the old address, neither packets nor BAM nor abort", [], old)
        early = [str(frame) for frame in frames if frame.at - claim.at < SILENCE[0]]
        session.report.equal("S22 nothing within the 250 ms", [], early)
        session.address = 0x81
        session.wait_online()
        again = Transfer(session)
        again.open("S29 from the new address")
        again.asked("S29 from the new address: all", again.count, 1)
        again.end("S29 from the new address")


GROUPS = (windows, strangers, aborted, time_outs, together, one_for_each, lost_address)
