"""Boot-up, identity, every code, refused requests, ignored frames, sticky errors (sections 9.5 to 9.7)."""

from . import protocol as p
from .context import Context
from .session import FOREIGN, Session


def boot(context: Context) -> None:
    """Two boot-up messages after the first frame (9.6, G21)."""
    report = context.report
    first_frames = {
        "a poll": lambda s: s.tester.send(s.set_id, bytes([p.ANGLES])),
        "a foreign frame": lambda s: s.tester.send(FOREIGN, b"\x01\x02"),
        "a sync frame": lambda s: s.tester.send(s.sync_id),
        "a foreign remote frame": lambda s: s.tester.send(FOREIGN, remote=True, dlc=0),
        "a foreign 29-bit frame": lambda s: s.tester.send(p.EXTENDED | 0x1234, b""),
    }
    for name, send in first_frames.items():
        with context.session(wake=False) as session:
            session.quiet("silent until the first frame", 0.15)
            send(session)
            got = [str(frame) for frame in session.tester.collect(0.25)]
            report.equal(f"{name} is not answered, two boot-up messages", session.boot_up(), got)
            session.reply("then a poll", bytes([p.ANGLES]), session.angles_reply(zeros(session)))


def zeros(session: Session) -> tuple[int, ...]:
    """The angles of a level sensor."""
    return (0,) * session.product.axes


def identity(context: Context) -> None:
    """Product, revision, serial number, version (tables 16 and 18, G5, G20)."""
    product = context.product
    with context.session() as session:
        number = bytes([p.PRODUCT, session.status]) + p.u32(product.product_number) + p.u16(p.REVISION)
        serial = bytes([p.SERIAL, session.status]) + p.u32(p.SERIAL_NUMBER) + product.version
        session.reply("03h product number and revision", bytes([p.PRODUCT]), number)
        session.reply("04h serial number and software version", bytes([p.SERIAL]), serial)
        session.reply("FFh alive", bytes([p.BOOT]), session.boot_message())
        session.quiet("only one alive message")


def codes(context: Context) -> None:
    """Every function select code: the valid reads as in table 18, all others are refused (G9)."""
    with context.session() as session:
        session.acknowledged("02h status", bytes([p.STATUS]))
        angles = session.angles_reply(zeros(session))
        session.reply("00h angles", bytes([p.ANGLES]), angles)
        for parameter in session.product.parameters:
            session.read(parameter, f"{parameter.read:02X}h {parameter.name}")
        for code in sorted(set(range(256)) - session.product.codes):
            session.errors |= p.CMD_ERROR
            session.acknowledged(f"invalid code {code:02X}h", bytes([code]))
            session.read_status(f"status after {code:02X}h")
        session.acknowledged("status without errors again", bytes([p.STATUS]))
        for code in (0x01, 0x05, 0x30, 0x41, 0xFE):
            session.refuse(f"invalid code {code:02X}h with seven data bytes", bytes([code]) + b"SAVELOA")
        if session.product.axes == 1:
            session.refuse("19h on a 1-axis type", b"\x19")
            session.refuse("29h on a 1-axis type", b"\x29\x01\x00")
            session.refuse("29h without data on a 1-axis type", b"\x29")


def short(context: Context) -> None:
    """Requests with too few data bytes are refused, for every possible length (9.5.2 CmdParamError)."""
    with context.session() as session:
        for parameter in session.product.parameters:
            # A zero offset without any data is the automatic zero adjustment (9.2).
            automatic = parameter.name.startswith("Zero Offset")
            for size in range(1 if automatic else 0, parameter.size):
                value = p.u32(0x0101_0101)[:size]
                name = f"{parameter.write:02X}h with {size} of {parameter.size} bytes"
                session.refuse(name, bytes([parameter.write]) + value)
        for code, signature in ((p.LOAD, p.LOAD_SIGNATURE), (p.SAVE, p.SAVE_SIGNATURE)):
            for size in range(4):
                session.refuse(f"{code:02X}h {signature[:size]!r}", bytes([code]) + signature[:size])
            for wrong in (signature.lower(), signature[::-1], signature[:3] + b"\x00", b"SALO"):
                session.refuse(f"{code:02X}h {wrong!r}", bytes([code]) + wrong)


def extra(context: Context) -> None:
    """Further data bytes are discarded (9.5.1)."""
    with context.session() as session:
        for size in range(1, 8):
            more = bytes(range(0xA1, 0xA1 + size))
            session.acknowledged(f"02h with {size} more", bytes([p.STATUS]) + more)
            angles = session.angles_reply(zeros(session))
            session.reply(f"00h with {size} more", bytes([p.ANGLES]) + more, angles)
            for parameter in session.product.parameters:
                session.read(parameter, f"{parameter.read:02X}h with {size} more", more)
        new = {
            p.SET_ID: p.u32(0x345),
            p.REPLY_ID: p.u32(0x346),
            p.SYNC_ID: p.u32(0x347),
            p.BAUD_RATE: b"\x06",
            p.BUS_OFF_RECOVERY: b"\x01",
            p.CYCLIC_TIME: p.u16(40000),
            p.CYCLIC_MODE: b"\x00",
            p.FILTER: p.filter_value(2500, 1),
        }
        for parameter in session.product.parameters:
            more = b"\xee" * (7 - parameter.size)
            value = new.get(parameter, p.u16(17))
            session.accept(parameter, value, f"{parameter.name} with {len(more)} more", more)


def framing(context: Context) -> None:
    """Frames without data, remote frames and the other identifier format (G10, G11, G26, 9.5)."""
    with context.session() as session:
        session.errors |= p.CMD_ERROR
        session.ignored("a request without data (but CmdParamError)", session.set_id)
        session.errors = 0
        for dlc in (0, 1, 8):
            session.ignored(f"remote request, DLC {dlc}", session.set_id, remote=True, dlc=dlc)
        for dlc in (0, 4):
            session.ignored(f"remote sync, DLC {dlc}", session.sync_id, remote=True, dlc=dlc)
        session.ignored("remote reply id", session.reply_id, remote=True, dlc=8)
        session.ignored("a frame on the reply id", session.reply_id, b"\x02")
        session.ignored("invalid code on the reply id", session.reply_id, b"\x01")
        for name, data in (("poll", b"\x00"), ("invalid code", b"\x01"), ("no data", b"")):
            session.ignored(f"{name} on the 29-bit set id", p.EXTENDED | session.set_id, data)
            session.ignored(f"{name} on another id", 0x302, data)
        # The 29-bit identifier with the same first eleven bits.
        session.ignored("29-bit id with the same base", p.EXTENDED | session.set_id << 18, b"\x00")
        session.ignored("29-bit sync id", p.EXTENDED | session.sync_id)
        session.ignored("29-bit sync id with the same base", p.EXTENDED | session.sync_id << 18)
        session.quiet("no late frame")


def sticky(context: Context) -> None:
    """CmdParamError stays until the status is read with 02h (9.5.2, G17)."""
    with context.session() as session:
        session.errors |= p.CMD_ERROR
        session.acknowledged("an error", b"\x2f")
        session.reply("set in the reply to a poll", b"\x00", session.angles_reply(zeros(session)))
        for parameter in session.product.parameters:
            session.read(parameter)
        session.accept(p.CYCLIC_TIME, p.u16(251))
        session.accept(p.CYCLIC_TIME, p.u16(250))
        session.reply("set in alive", b"\xff", session.boot_message())
        session.tester.send(session.sync_id)
        session.report.equal(
            "set in the reply to sync",
            f"301#{session.angles_reply(zeros(session)).hex().upper()}",
            str(session.tester.receive()),
        )
        session.acknowledged("still set after a second error", b"\x2f")
        session.read_status("set in the reply to 02h")
        session.read_status("cleared by 02h")
        session.reply("poll without errors", b"\x00", session.angles_reply(zeros(session)))


def alive(context: Context) -> None:
    """FFh: alive message, RESET, and FFh with other data (G14, G26)."""
    with context.session() as session:
        session.reply("DLC 1", b"\xff", session.boot_message())
        wrong = [p.RESET_SIGNATURE[:size] for size in range(1, 5)]
        wrong += [b"reset", b"RESES", b"XESET", b"RESEt", b"RESE\x00", b"\x00" * 7, b" RESET"]
        for data in wrong:
            session.errors |= p.CMD_ERROR
            session.reply(f"{data!r}", b"\xff" + data, session.boot_message())
            session.read_status(f"status after {data!r}")
        session.quiet("no restart")
        for more in (b"", b"!", b"\x00\xff"):
            session.errors |= p.CMD_ERROR
            session.acknowledged("an error before RESET", b"\x2f")
            session.tester.send(session.set_id, b"\xffRESET" + more)
            session.errors = 0
            session.quiet(f"RESET with {len(more)} more bytes: silent, new detection (G27)", 0.15)
            session.check_wake("two boot-up messages, errors cleared")
            session.acknowledged("status after RESET", bytes([p.STATUS]))
        session.quiet("only two boot-up messages")


GROUPS = (boot, identity, codes, short, extra, framing, sticky, alive)
