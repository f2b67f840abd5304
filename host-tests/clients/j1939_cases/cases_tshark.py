"""A whole session, as Wireshark's dissector for J1939 reads it: priority, group and addresses of every frame."""

import shutil
from collections import Counter

from canopen_cases.runner import Context
from devicenet_cases import capture

from . import protocol as p
from .cases_commanded import by_bam, command
from .cases_request import texts
from .session import Node

DISSECTOR = ("-d", "can.subdissector,j1939")
NAMES = [
    "can.id",
    "j1939.priority",
    "j1939.pgn",
    "j1939.src_addr",
    "j1939.dst_addr",
    "j1939.group_extension",
    "data.data",
    "_ws.malformed",
]


def dissector(context: Context) -> None:
    """Each frame of a session as it was composed; none is malformed."""
    report = context.report
    if not shutil.which("tshark"):
        report.verdict(False, "tshark", "installed", "not found")
        return
    log = context.folder / "session.log"
    with Node(context, {(0x2104, sub): 50 for sub in (1, 2, 3, 4)} | {(0x3110, 1): 0}, log=log) as session:
        everything(session)
        session.power_down()
    lines = [line.split(" ", 2) for line in log.read_text().splitlines()]
    frames = [
        (number, data.split()[0]) for _, _, text in lines for number, _, data in [text.partition("#")] if len(number) == 8
    ]
    # The transport protocol and 11-bit frames are read too; the log without the direction is what tshark can read.
    path = context.folder / "read.log"
    path.write_text(
        "".join(f"{stamp} can0 {text.split()[0]}\n" for stamp, _, text in lines if len(text.partition("#")[0]) == 8)
    )
    rows = capture.fields(path, NAMES, *DISSECTOR)
    report.equal("number of frames", len(frames), len(rows))
    report.verdict(len(frames) > 300, "a whole session", "> 300 frames", len(frames))
    wrong, groups = [], Counter()
    for (number, data), row in zip(frames, rows, strict=False):
        value = int(number, 16)
        parts = p.Identifier(value >> 26, value >> 24 & 3, 0, 0, value & 0xFF)
        kind, specific = value >> 16 & 0xFF, value >> 8 & 0xFF
        pgn = parts.page << 16 | kind << 8 | (specific if kind >= 240 else 0)
        target = specific if kind < 240 else 255
        groups[pgn] += 1
        expected = (parts.priority, pgn, parts.source, target)
        got = tuple(int(row[name] or "-1", 0) for name in ("j1939.priority", "j1939.pgn", "j1939.src_addr"))
        aim = int(row["j1939.dst_addr"] or "255", 0)
        if (*got, aim) != expected or row["_ws.malformed"]:
            wrong.append((number, data, row))
    report.equal("priority, group, source and destination of each frame", [], wrong[:5])
    names = {
        p.REQUEST: "requests", p.ACKNOWLEDGE: "acknowledgements", p.CLAIMED: "claims", p.TP_CM: "TP.CM", p.TP_DT: "TP.DT",
        p.PROPRIETARY_A: "parameters", p.SSI: "SSI", p.SSI2: "SSI2", p.ARI: "ARI", p.ACCS: "ACCS", p.DM1: "DM1", p.SOFTWARE: "software",
    }  # fmt: skip
    for pgn, name in names.items():
        report.verdict(groups[pgn] > 0, f"{name} in the session", "some", groups[pgn])
    report.equal("no other groups", set(), set(groups) - set(names) - {65262})


def everything(session: Node) -> None:
    """Every kind of frame."""
    for pgn in (p.CLAIMED, *p.PROCESS, p.DM1, p.SOFTWARE, 65262):
        for to in (0x80, p.GLOBAL):
            session.after(session.request(pgn, to))
    for pgn, text in texts(session).items():
        if len(text) > 8:
            session.after(session.request(pgn))
            session.after(p.cts(p.ME, 0x80, pgn, (len(text) + 6) // 7, 1))
            session.after(p.end_of_message(p.ME, 0x80, pgn, len(text)))
            session.tx(session.request(pgn, p.GLOBAL))
            session.wait(lambda frame: False, 0.5)
    session.put(0x3210, 0, 9500)
    session.put(0x3220, 0, 9500)
    session.wait(lambda frame: False, 1.5)
    session.after(p.claim(name=p.HIGHER))
    session.upload(0x1008)
    session.tx(*by_bam(command(0xA0)))
    session.wait(lambda frame: False, 0.5)
    session.address = 0xA0
    session.wait_online()
    session.tx(p.claim(0xA0, p.LOWER))
    session.wait(lambda frame: False, 0.5)


GROUPS = (dissector,)
