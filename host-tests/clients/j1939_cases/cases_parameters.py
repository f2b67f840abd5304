"""Parameters by proprietary A: every object, abort codes, segments and blocks, store, restart, several clients (S38)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from canopen_cases import ims360_block, ims360_dictionary, ims360_store
from canopen_cases import protocol as c
from canopen_cases.ims360_objects import COMMANDS
from canopen_cases.runner import Context
from canopen_cases.session import initiate

from . import protocol as p
from .session import AT_ONCE, START_TIME, J1939Context, Node

WORDS = [one for one in p.TABLE.values() if one.writable and (one.index, one.sub) not in COMMANDS]


def frames(context: Context) -> None:
    """S38: complete frames, to the bit, from several addresses."""
    with Node(context) as session:
        for name, request, answer in (
            ("u32", "4000100000000000", "430010009A010407"),
            ("u16", "4011310000000000", "4B113100D0070000"),
            ("u8", "4002210000000000", "4F02210080000000"),
            ("write u16", "2B113100401F0000", "6011310000000000"),
            ("it is in force", "4011310000000000", "4B113100401F0000"),
            ("write u8", "2F02210081000000", "6002210000000000"),
            ("write u32", "23103200FFFFFFFF", "6010320000000000"),
            ("it is in force", "4010320000000000", "43103200FFFFFFFF"),
            ("without a size", "2210320000000000", "6010320000000000"),
            ("no object", "40FE5F0000000000", "80FE5F0000000206"),
            ("no sub-index", "4000100100000000", "8000100111000906"),
            ("read-only", "2300100000000000", "8000100002000106"),
            ("write-only", "4000320000000000", "8000320001000106"),
            ("too long", "2311310000000000", "8011310012000706"),
            ("too short", "2F11310000000000", "8011310013000706"),
            ("value", "2B04210109000000", "8004210130000906"),
            ("SSI every 20 ms", "2B04210214000000", "6004210200000000"),
            ("and off", "2B04210200000000", "6004210200000000"),
            ("unknown command", "E000100000000000", "8000100001000405"),
            ("segment without a transfer", "6000000000000000", "8000000001000405"),
            ("segmented", "4008100000000000", "4108100006000000"),
            ("unused bytes are not looked at", "40001000FFFFFFFF", "430010009A010407"),
        ):
            for source in (p.ME, 0x00, 0xFD):
                got = session.after(p.shown(p.PROPRIETARY_A, source, bytes.fromhex(request), 0x80))
                session.report.equal(f"S38 {name} from {source:02X}h: {request}", [f"18EF{source:02X}80#{answer}"], got)
        session.put(0x2102, 0, 0x80)
        for name, line in {
            "7 bytes": "18EF8021#40001000000000",
            "4 bytes": "18EF8021#40001000",
            "no bytes": "18EF8021#",
            "to all": "18EFFF21#4000100000000000",
            "to another node": "18EF9021#4000100000000000",
            "to 254": "18EFFE21#4000100000000000",
            "a client's abort": "18EF8021#8000100000000008",
        }.items():
            session.expect(f"S38 {name}: no answer", line)
        session.expect("S38 with priority 0", "00EF8021#4000100000000000", "18EF2180#430010009A010407")
        session.expect("S38 with priority 7", "1CEF8021#4000100000000000", "18EF2180#430010009A010407")


def every(context: Context) -> None:
    """S38: every object of the dictionary: size, value, and what its access refuses."""
    with Node(context) as session:
        changed = {p.SWITCH: 1, (0x2104, 1): 0, (0x3000, 1): 1}
        for key, one in p.TABLE.items():
            if not one.readable:
                session.refused(f"S38 {one}: read", c.WRITE_ONLY, session.upload, *key)
                continue
            value = session.upload(*key)
            expected = one.expected(session.node)
            if key in changed:
                session.report.equal(f"S38 {one}: value", changed[key], c.decode(value))
            elif key not in ((0x1001, 0), (0x1003, 0)) and expected is not None:
                session.report.equal(f"S38 {one}: value", expected, value)
            elif one.size is not None:
                session.report.equal(f"S38 {one}: size", one.size, len(value))
            if not one.writable:
                session.refused(f"S38 {one}: write", c.READ_ONLY, session.download, *key, value[: one.size or 4])
        for one in WORDS:
            key = (one.index, one.sub)
            session.report.equal(
                f"S38 J30 {one} written back", 0, session.abort_code(session.download, *key, session.upload(*key))
            )
            if one.size > 1:
                session.refused(f"S38 {one}: a byte less", c.SHORT, session.download, *key, bytes(one.size - 1))
            if one.size < 4:
                session.refused(f"S38 {one}: a byte more", c.LONG, session.download, *key, bytes(one.size + 1))
            before = session.upload(*key)
            for size in (True, False):
                session.download_segments(*key, before, with_size=size)
            session.report.equal(f"S38 {one}: written in segments", before, session.upload(*key))


def limits(context: Context) -> None:
    """S38: the limits of CANopen's settings, the pairs of the filter and the identifiers; COB-IDs and mappings can be prepared."""
    with Node(context) as session:
        for key, (good, bad) in ims360_dictionary.LIMITS.items():
            for value in good:
                session.accepted(f"S38 {p.TABLE[key]} = {value}", *key, value)
            for value in bad:
                session.refused(f"S38 {p.TABLE[key]} = {value}", c.RANGE, session.put, *key, value)
            session.reads(f"S38 {p.TABLE[key]} is unchanged", *key, good[-1])
        ims360_dictionary.low_pass(session)
        ims360_dictionary.cob_ids(session)
        for index in (0x1005, 0x1014):
            session.report.equal(
                f"S38 S16 {index:04X}h as in pre-operational", 0, session.abort_code(session.put, index, 0, session.get(index))
            )
        for index in (0x1010, 0x1011):
            for sub in range(1, 5):
                session.refused(
                    f"S54 {index:04X}h:{sub:02X}, wrong signature", c.CANNOT_STORE, session.download, index, sub, b"SAVE"
                )
                session.report.equal(f"S54 {index:04X}h:{sub:02X} reads 1", 1, session.get(index, sub))


@dataclass(frozen=True)
class Over:
    """A group of the CANopen check, in J1939 mode."""

    group: Callable[[Context], None]

    @property
    def __name__(self) -> str:
        return f"canopen_{self.group.__name__}"

    def __call__(self, context: Context) -> None:
        self.group(J1939Context(**vars(context)))


def segments(context: Context) -> None:
    """S38: segmented transfers, their toggle bits, and what interrupts them."""
    with Node(context) as session:
        session.report.equal("S38 1008h in segments", b"IMS360", session.upload(0x1008))
        session.refused("S38 a segment after the last", c.UNKNOWN_COMMAND, session.exchange, b"\x60")
        session.exchange(initiate(0x40, 0x1008, 0))
        session.refused("S38 toggle 1 first", c.TOGGLE, session.exchange, b"\x70")
        session.refused("S38 the transfer has ended", c.UNKNOWN_COMMAND, session.exchange, b"\x60")
        session.exchange(initiate(0x21, 0x3210, 0, c.encode(4, 4)))
        session.refused("S38 download, toggle 1 first", c.TOGGLE, session.exchange, b"\x17" + c.encode(77, 4))
        session.reads("S38 nothing was written", 0x3210, 0, 0)
        session.exchange(initiate(0x21, 0x3210, 0, c.encode(4, 4)))
        session.exchange(b"\x07" + c.encode(-77, 4))
        session.reads("S38 written in one segment", 0x3210, 0, -77)
        session.refused("S38 size 5 for 4 bytes", c.LONG, session.exchange, initiate(0x21, 0x3210, 0, c.encode(5, 4)))
        session.exchange(initiate(0x21, 0x3210, 0, c.encode(4, 4)))
        session.refused("S38 size 4, sent 3", c.SHORT, session.exchange, b"\x09" + bytes(3))
        session.reads("S38 unchanged", 0x3210, 0, -77)
        # One transfer at a time; a new initiate from anyone starts afresh.
        session.exchange(initiate(0x40, 0x1008, 0))
        session.me = p.OTHER
        session.report.equal("S38 a new initiate of another node", 0x0704019A, session.get(0x1000))
        session.me = p.ME
        session.refused("S38 the first transfer is gone", c.UNKNOWN_COMMAND, session.exchange, b"\x60")
        session.exchange(initiate(0x40, 0x1008, 0))
        # No mark here: it would be a new initiate.
        session.tx(f"18EF80{p.OTHER:02X}#6000000000000000")
        refusal = f"18EF{p.OTHER:02X}80#8000000001000405"
        session.comes("S38 a segment of another node is refused to that node", refusal, AT_ONCE)
        session.report.equal("S38 the transfer goes on", b"\x03IMS360\0", session.exchange(b"\x60"))
        session.exchange(initiate(0x40, 0x1008, 0))
        session.send_to(0x80, b"\x80\x08\x10\x00\x00\x00\x00\x08")
        session.refused("S38 aborted by the client", c.UNKNOWN_COMMAND, session.exchange, b"\x60")


def stored(context: Context) -> None:
    """S38, S54: 1010h:01 and the groups, in J1939 mode; 2010h:01 restarts after its answer."""
    with Node(context) as session:
        values = {(0x2104, 2): 77, (0x3111, 0): 3333, (0x1017, 0): 1234, (0x2105, 3): 5, (0x2001, 0): 250_000}
        for key, value in values.items():
            session.put(*key, value)
        session.put(0x2001, 0, 125_000)
        values[0x2001, 0] = 125_000
        session.tx(p.shown(p.PROPRIETARY_A, p.ME, b"\x2f\x10\x20\x01\x01\0\0\0", 0x80))
        session.comes("S64 2010h:01: the answer first", "18EF2180#6010200100000000")
        session.comes("S64 2010h:01: then the claim", p.claim(), START_TIME)
        session.wait_online()
        session.report.equal("S38 not stored: factory values", [0, 2000, 0, 3], [session.get(*key) for key in list(values)[:4]])
        for key, value in values.items():
            session.put(*key, value)
        session.expect("S38 save", "18EF8021#2310100173617665", "18EF2180#6010100100000000")
        session.reset()
        session.report.equal("S38 stored, after 2010h:01", list(values.values()), [session.get(*key) for key in values])
        session.power_cycle()
        session.report.equal("S38 stored, after power off and on", list(values.values()), [session.get(*key) for key in values])
        for value in (0, 2, 255):
            session.refused(f"S64 2010h:01 = {value}", c.INVALID_VALUE, session.put, 0x2010, 1, value)
        session.expect("S38 still there", session.request(p.CLAIMED), p.claim())
        session.load(2)
        session.reset()
        session.report.equal(
            "S55 1011h:02 takes 1017h alone", [77, 3333, 0, 5], [session.get(*key) for key in list(values)[:4]]
        )
        session.reset()
        session.report.equal(
            "S55 without a save, the stored values are back",
            [77, 3333, 1234, 5],
            [session.get(*key) for key in list(values)[:4]],
        )


def name_and_address(context: Context) -> None:
    """S20, S21: 2102h and 2106h act after store and restart, not before."""
    with Node(context) as session:
        session.put(0x2102, 0, 0x44)
        name = replace(p.OURS, function=7, manufacturer=300)
        for key, value in name.settings().items():
            session.put(*key, value)
        session.expect("S21 nothing before the restart", session.request(p.CLAIMED), p.claim())
        frame = session.restarted()
        session.report.equal("S21 not stored", p.claim(), str(frame))
        session.wait_online()
        session.put(0x2102, 0, 0x44)
        for key, value in name.settings().items():
            session.put(*key, value)
        session.save(4)
        frame = session.restarted()
        session.report.equal("S20 S21 S54 stored by 1010h:04", p.claim(0x44, name.data), str(frame))
        session.address = 0x44
        session.wait_online()


GROUPS = (
    frames, every, limits, segments, stored, name_and_address,
    *map(Over, (ims360_dictionary.absent, ims360_dictionary.angles, ims360_dictionary.raw_values)),
    *map(Over, (*ims360_block.GROUPS, ims360_store.stored)),
)  # fmt: skip
