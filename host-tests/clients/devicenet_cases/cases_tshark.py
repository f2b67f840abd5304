"""Traffic with each service, object, attribute and error code, as Wireshark's dissectors for DeviceNet and CIP read it."""

import shutil
import subprocess
from pathlib import Path

from . import capture
from . import protocol as p
from .runner import Context

DISSECTOR = ("-d", "can.subdissector,devicenet")
# What the dissector calls the messages of this node.
MESSAGES = {
    p.DUPLICATE: "Duplicate MAC ID Check Messages",
    p.PORT: "Group 2 Only Unconnected Explicit Request Messages",
    p.POLL: "Master's I/O Poll Command/COS/Cyclic Messages",
    p.EXPLICIT: "Master's Explicit Request Messages",
    p.RESPONSE: "Slave's Explicit/Unconnected Response Messages",
    p.ACKNOWLEDGE: "Master's Change of State or Cyclic Acknowledge Message",
}
POLL_RESPONSE = "Slave's I/O Poll Response or COS/Cyclic Ack Message"
CHANGE_OF_STATE = "Slave's I/O Change of State or Cyclic Message"
# Shown as Open and Close of a connection in group 3.
OPEN_CLOSE = (p.ALLOCATE, p.RELEASE)


def traffic(context: Context) -> list[tuple[int, bytes]]:
    """Frames of a session with all objects and all error codes."""
    log = context.folder / "sensor.log"
    with context.session(log=log) as session:
        session.send(p.DUPLICATE, "00341201000000")
        session.connect(0x13, poll=0, cos=0)
        for _ in range(3):
            session.poll()
        session.send(p.ACKNOWLEDGE)
        for header in (0x0A, 0x4A):
            for kind, instance in (
                (1, 1),
                (3, 1),
                (4, 0x65),
                (4, 0x66),
                (4, 0x67),
                (5, 1),
                (5, 2),
                (5, 4),
                (0x2B, 1),
                (3, 0),
                (4, 0),
                (5, 0),
            ):
                for attribute in range(20):
                    if (kind, attribute) != (1, 7):
                        session.ask(f"{header:02X}0E{kind:02X}{instance:02X}{attribute:02X}")
            for attribute in range(0x70, 0x8A):
                session.ask(f"{header:02X}0E6501{attribute:02X}")
        session.get(p.IDENTITY, 1, 7)
        for data in (
            "1065018501 00",
            "1065018400",
            "106501710A00",
            "10650187 01",
            "106501730 3",
            "10650174 2300",
            "10650175 01",
            "100504090000",
            "1005041 10000",
            "102B01011000",
            "102B010201",
        ):
            session.ask("0A" + data.replace(" ", ""))
        for data in (
            "0E990101",
            "0E650201",
            "55650101",
            "0E650163",
            "10650172",
            "10650184FB",
            "10650184",
            "10650184FFFF",
            "05010102",
            "1065018165",
            "10650181FF",
            "0E0101",
            "1005020100",
        ):
            session.ask("0A" + data)
        session.put(p.CONNECTION, p.C_COS, 17, "C800")
        session.set(p.CONNECTION, p.C_COS, 9, "6400")
        for data in (
            "0B4B0301010B",
            "0A4B0301000A",
            "0A4B0301040A",
            "0A4B0301020A",
            "0A4C030100",
            "0A4C030104",
            "0A4C030120",
            "0A0E010101",
            "0A4C030113",
            "0A4C030101",
        ):
            session.ask(data, p.PORT)
        session.sleep(0.2)
    frames = capture.frames(log)
    context.report.within("frames in the log", 400, 5000, len(frames))
    return frames


def has_tshark(context: Context) -> bool:
    """Whether tshark is there."""
    return context.report.equal("tshark is installed", True, shutil.which("tshark") is not None)


def devicenet(context: Context) -> None:
    """The log itself: identifiers, MAC IDs, the duplicate MAC ID check."""
    if not has_tshark(context):
        return
    frames = traffic(context)
    names = [
        "devicenet.src_mac_id",
        "_ws.col.Info",
        "devicenet.dup_mac_id.rr",
        "devicenet.dup_mac_id.vendor",
        "devicenet.dup_mac_id.serial_number",
        "_ws.malformed",
    ]
    rows = capture.fields(context.folder / "sensor.log", names, *DISSECTOR)
    context.report.equal("number of frames", len(frames), len(rows))
    wrong, checks = [], []
    for (number, data), row in zip(frames, rows, strict=False):
        shown = row["_ws.col.Info"]
        if number == p.poll_response(p.FACTORY_MAC):
            expected = POLL_RESPONSE
        elif number == p.change_of_state(p.FACTORY_MAC):
            expected = CHANGE_OF_STATE
        else:
            expected = MESSAGES.get(number & 7) if number & 0x7F8 == p.group2(0, p.FACTORY_MAC) else None
        if shown != expected or row["devicenet.src_mac_id"] != str(p.FACTORY_MAC) or row["_ws.malformed"]:
            wrong.append((f"{number:03X}#{data.hex()}", row))
        if number == p.group2(p.DUPLICATE, p.FACTORY_MAC):
            checks.append(
                (
                    row["devicenet.dup_mac_id.rr"],
                    int(row["devicenet.dup_mac_id.vendor"], 0),
                    row["devicenet.dup_mac_id.serial_number"],
                )
            )
    context.report.equal("each frame has its message", [], wrong[:5])
    context.report.equal("duplicate MAC ID check: requests and the response", ["0", "0", "0", "1"], [rr for rr, _, _ in checks])
    own = {(vendor, serial) for n, (_, vendor, serial) in enumerate(checks) if n != 2}
    context.report.equal("vendor", [p.VENDOR], [vendor for vendor, _ in own])
    vendors = names_of_vendor(context.folder / "sensor.log")
    context.report.verdict("FRABA Posital GmbH (0x0162)" in vendors, "name of the vendor", "FRABA Posital GmbH (0x0162)", vendors)


def names_of_vendor(log: Path) -> set[str]:
    """The vendors as tshark shows them."""
    shown = subprocess.run(["tshark", "-n", "-r", str(log), *DISSECTOR, "-V"], capture_output=True, text=True, check=True).stdout
    return {line.partition("Vendor ID: ")[2] for line in shown.splitlines() if "Vendor ID: " in line}


def group3(context: Context) -> None:
    """The explicit messages with the identifier of group 3: header, service, fragments."""
    if not has_tshark(context):
        return
    ids = [p.group2(message, p.FACTORY_MAC) for message in (p.EXPLICIT, p.PORT, p.RESPONSE)]
    bodies = [data for number, data in traffic(context) if number in ids]
    bodies = [data for data in bodies if len(data) > 1 and (data[0] & 0x80 or data[1] & 0x7F not in OPEN_CLOSE)]
    log = capture.write_log(context.folder / "group3.log", [(0x600 | p.FACTORY_MAC, data) for data in bodies])
    names = [
        "devicenet.grp_msg3.frag",
        "devicenet.grp_msg3.xid",
        "devicenet.dest_mac_id",
        "devicenet.rr",
        "devicenet.service",
        "devicenet.fragment_type",
        "_ws.malformed",
    ]
    rows = capture.fields(log, names, *DISSECTOR)
    context.report.equal("number of frames", len(bodies), len(rows))
    wrong = []
    for data, row in zip(bodies, rows, strict=False):
        header = (data[0] >> 7, data[0] >> 6 & 1, data[0] & 0x3F)
        got = (truth(row["devicenet.grp_msg3.frag"]), truth(row["devicenet.grp_msg3.xid"]), int(row["devicenet.dest_mac_id"]))
        good = header == got and not row["_ws.malformed"]
        if header[0]:
            good = good and int(row["devicenet.fragment_type"] or "0", 0) in (data[1] >> 6, data[1] & 0xC0)
        elif row["devicenet.rr"]:
            good = (
                good
                and int(row["devicenet.rr"], 0) in (data[1] >> 7, data[1] & 0x80)
                and int(row["devicenet.service"], 0) == data[1] & 0x7F
            )
        else:
            good = False
        if not good:
            wrong.append((data.hex(), row))
    context.report.equal("each message has header, service and response bit", [], wrong[:5])


def truth(value: str) -> int:
    """A flag as tshark writes it."""
    return int(value in ("1", "True", "true"))


def cip(context: Context) -> None:
    """Requests and replies as EtherNet/IP: the CIP dissector names object, service and status; none is malformed."""
    if not has_tshark(context):
        return
    found = capture.pairs(traffic(context), p.FACTORY_MAC)
    found = [pair for pair in found if len(pair.request) >= 3]
    path = capture.write_capture(context.folder / "cip.pcap", found)
    names = [
        "cip.rr", "cip.sc", "cip.genstat", "cip.addstat", "cip.class", "cip.instance", "cip.attribute", "cip.id.vendor_id",
        "cip.id.device_type", "cip.id.product_name", "cip.id.major_rev", "_ws.malformed", "_ws.expert.severity",
    ]  # fmt: skip
    rows = capture.fields(path, names)
    report = context.report
    report.within("pairs", 200, 3000, len(found))
    report.equal("packets", 2 * len(found), len(rows))
    wrong, codes = [], set()
    for number, pair in enumerate(found):
        asked, answered = rows[2 * number], rows[2 * number + 1]
        service, kind, instance = pair.request[:3]
        expected = (0, service, kind, instance)
        got = tuple(int(asked[name] or "-1", 0) for name in ("cip.rr", "cip.sc", "cip.class", "cip.instance"))
        status = pair.reply[1] if pair.reply[0] == 0x94 else 0
        codes.add(status)
        seen = tuple(int(answered[name] or "-1", 0) for name in ("cip.rr", "cip.sc", "cip.genstat"))
        flag = seen[0] in (1, 0x80)
        if expected != got or not flag or seen[1:] != (service, status) or asked["_ws.malformed"] or answered["_ws.malformed"]:
            wrong.append((pair.request.hex(), pair.reply.hex(), asked, answered))
    report.equal("each request and reply as sent", [], wrong[:3])
    expected = {0, 2, 8, 9, 0x0B, 0x0C, 0x0E, 0x13, 0x14, 0x15, 0x16, 0x20}
    report.equal("all status codes", sorted(expected), sorted(codes))
    values = {name: {row[name] for row in rows if row[name]} for name in names if name.startswith("cip.id")}
    report.equal("identity: vendor", {p.VENDOR}, {int(one, 0) for one in values["cip.id.vendor_id"]})
    report.equal("identity: device type", {0}, {int(one, 0) for one in values["cip.id.device_type"]})
    report.equal("identity: product name", {context.subject.name}, values["cip.id.product_name"])


GROUPS = (devicenet, group3, cip)
