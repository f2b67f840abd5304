#!/usr/bin/env python3
"""Lets Wireshark's dissectors for DeviceNet and CIP read the traces of the sensors tiltix080 and tiltix360.

    python devicenet_tshark.py --traces ../traces

Needs tshark. The traces are replayed against the sensors byte by byte. Three files are read: the frames
as they are; explicit messages with the identifier of a group 3 message, because the dissector decodes only those; requests and
responses as EtherNet/IP, for the CIP dissector. Prints one line per check; the exit code is 1 if a check failed.

    capture file     global header, then for each packet: header, Ethernet, IPv4, UDP, encapsulation, two items, CIP
    encapsulation    command u16, length u16, session u32, status u32, context 8 bytes, options u32, interface u32, timeout u16
    items            count u16; type u16, length u16 (null address); type u16, length u16, data (unconnected data)
    CIP request      service, path words, 20 class 24 instance [30 attribute], data
    CIP response     service | 80, 00, general status, additional words, additional status u16..., data
"""

import argparse
import re
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

LINE = re.compile(r"\([\d.]+\) can0 ([0-9A-F]{3})#([0-9A-F]*) ([TR])")
DISSECTOR = ("-d", "can.subdissector,devicenet")
VENDOR = 354
# The messages of group 2 (bits 2..0 of the identifier; bits 8..3 are the MAC ID), as the dissector names them.
ACKNOWLEDGE, RESPONSE, EXPLICIT, POLL, PORT, DUPLICATE = range(2, 8)
MESSAGES = {
    DUPLICATE: "Duplicate MAC ID Check Messages",
    PORT: "Group 2 Only Unconnected Explicit Request Messages",
    POLL: "Master's I/O Poll Command/COS/Cyclic Messages",
    EXPLICIT: "Master's Explicit Request Messages",
    RESPONSE: "Slave's Explicit/Unconnected Response Messages",
    ACKNOWLEDGE: "Master's Change of State or Cyclic Acknowledge Message",
}
# The messages of the sensor in group 1 (bits 9..6).
GROUP_1 = {
    0x3C0: "Slave's I/O Poll Response or COS/Cyclic Ack Message",
    0x340: "Slave's I/O Change of State or Cyclic Message",
}
GET, SET, ALLOCATE, RELEASE, ERROR = 0x0E, 0x10, 0x4B, 0x4C, 0x94
CODES = {0, 0x02, 0x08, 0x09, 0x0B, 0x0C, 0x0E, 0x13, 0x14, 0x15, 0x16, 0x20}


class Checks:
    """Prints and counts the results of checks."""

    failed = 0

    def equal(self, name: str, expected: object, got: object) -> None:
        """Checks that two values are equal."""
        self.failed += expected != got
        print("ok    " if expected == got else "FAILED", f"{name}: {got!r}", "" if expected == got else f"instead of {expected!r}")


def frames(traces: Path, product: str) -> list[tuple[int, bytes]]:
    """Identifier and data of the frames in the traces of a product. Frames without a meaning for a node are left out."""
    text = "".join(path.read_text() for path in sorted(traces.glob(f"{product}-*.log")))
    found = [(int(number, 16), bytes.fromhex(data)) for number, data, _ in LINE.findall(text)]
    return [(number, data) for number, data in found if meaning(number) and (data or number & 7 in (POLL, ACKNOWLEDGE))]


def meaning(number: int) -> str | None:
    """The name of a message in the dissector, if the sensor knows it."""
    return GROUP_1.get(number & 0x7C0) if number < 0x400 else MESSAGES.get(number & 7) if number < 0x600 else None


def mac_id(number: int) -> int:
    """The MAC ID in an identifier."""
    return number & 0x3F if number < 0x400 else number >> 3 & 0x3F


def write_log(path: Path, lines: list[tuple[int, bytes]]) -> Path:
    """Writes a log in the format of `candump -L`."""
    rows = (f"({1.7e9 + 0.001 * n:.6f}) can0 {number:03X}#{data.hex().upper()}\n" for n, (number, data) in enumerate(lines))
    path.write_text("".join(rows))
    return path


def fields(path: Path, names: list[str], *options: str) -> list[dict[str, str]]:
    """Fields of each packet as tshark reads them."""
    command = ["tshark", "-n", "-r", str(path), *options, "-T", "fields", "-E", "separator=/t", "-E", "occurrence=f"]
    for name in names:
        command += ["-e", name]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [dict(zip(names, line.split("\t"), strict=True)) for line in done.stdout.splitlines()]


def check_frames(checks: Checks, lines: list[tuple[int, bytes]], log: Path) -> None:
    """The frames as they are: messages, MAC IDs, the duplicate MAC ID check."""
    check = "devicenet.dup_mac_id."
    names = ["devicenet.src_mac_id", "_ws.col.Info", "_ws.malformed", check + "rr", check + "vendor", check + "serial_number"]
    rows = fields(write_log(log, lines), names, *DISSECTOR)
    wrong, own = [], set()
    for (number, data), row in zip(lines, rows, strict=True):
        shown = (row["_ws.col.Info"], row["devicenet.src_mac_id"], row["_ws.malformed"])
        if shown != (meaning(number), str(mac_id(number)), ""):
            wrong.append((f"{number:03X}#{data.hex()}", shown))
        if number & 7 == DUPLICATE and number >= 0x400:
            vendor, serial = int.from_bytes(data[1:3], "little"), int.from_bytes(data[3:7], "little")
            found = [int(row[check + name] or "-1", 0) for name in ("rr", "vendor", "serial_number")]
            if found[0] not in (data[0] >> 7, data[0] & 0x80) or found[1:] != [vendor, serial]:
                wrong.append((f"{number:03X}#{data.hex()}", found))
            own.add(vendor)
    checks.equal(f"{len(lines)} frames have their messages", [], wrong[:5])
    text = subprocess.run(["tshark", "-n", "-r", str(log), *DISSECTOR, "-V"], capture_output=True, text=True, check=True).stdout
    checks.equal("the vendor is known", True, VENDOR in own and "Vendor ID: FRABA Posital GmbH (0x0162)" in text)


def check_group_3(checks: Checks, lines: list[tuple[int, bytes]], log: Path) -> None:
    """The explicit messages with an identifier of group 3: header, service, fragments."""
    explicit = [data for number, data in lines if number >= 0x400 and number & 7 in (RESPONSE, EXPLICIT, PORT) and len(data) > 1]
    # Allocate and release are shown as open and close of a connection in group 3.
    bodies = [data for data in explicit if data[0] & 0x80 or data[1] & 0x7F not in (ALLOCATE, RELEASE)]
    group_3 = "devicenet.grp_msg3."
    names = [group_3 + "frag", group_3 + "xid", "devicenet.dest_mac_id", "devicenet.rr", "devicenet.service"]
    names += ["devicenet.fragment_type", "_ws.malformed"]
    rows = fields(write_log(log, [(0x63F, data) for data in bodies]), names, *DISSECTOR)
    wrong = []
    for data, row in zip(bodies, rows, strict=True):
        fragment, xid, mac, response, service, kind = (number(row[name]) for name in names[:6])
        good = (fragment, xid, mac) == (data[0] >> 7, data[0] >> 6 & 1, data[0] & 0x3F) and not row["_ws.malformed"]
        if fragment:
            good = good and (kind or 0) in (data[1] >> 6, data[1] & 0xC0)
        else:
            good = good and response in (data[1] >> 7, data[1] & 0x80) and service == data[1] & 0x7F
        if not good:
            wrong.append((data.hex(), row))
    checks.equal(f"{len(bodies)} explicit messages have header, service and response bit", [], wrong[:5])


def number(text: str) -> int | None:
    """A number or a flag as tshark writes it."""
    return {"": None, "True": 1, "False": 0}[text] if text in ("", "True", "False") else int(text, 0)


def pairs(lines: list[tuple[int, bytes]]) -> list[tuple[bytes, bytes]]:
    """The requests and their responses without headers. The fragments of a response are put together."""
    found, request, response = [], b"", b""
    for identifier, data in lines:
        if identifier < 0x400 or len(data) < 2:
            continue
        if identifier & 7 in (EXPLICIT, PORT) and not data[0] & 0x80:
            request = data[1:]
        elif identifier & 7 == RESPONSE and len(request) >= 3:
            if not data[0] & 0x80:
                # After a fragmented request, the request is not known.
                if data[1] == ERROR or data[1] & 0x7F == request[0]:
                    found.append((request, data[1:]))
                request = b""
            elif data[1] & 0xC0 != 0xC0:
                response = (response if data[1] & 0xC0 else b"") + data[2:]
                if data[1] & 0xC0 == 0x80:
                    found.append((request, response))
                    request = b""
    return found


def cip(request: bytes, response: bytes) -> tuple[bytes, bytes]:
    """Request and response as CIP has them."""
    service, kind, instance, rest = request[0], request[1], request[2], request[3:]
    path = bytes([0x20, kind, 0x24, instance])
    if service in (GET, SET) and rest:
        path, rest = path + bytes([0x30, rest[0]]), rest[1:]
    asked = bytes([service, len(path) // 2]) + path + rest
    if response[0] != ERROR:
        return asked, bytes([response[0], 0, 0, 0]) + response[1:]
    general, additional = response[1], response[2]
    words = b"" if additional == 0xFF else struct.pack("<H", additional)
    return asked, bytes([service | 0x80, 0, general, len(words) // 2]) + words


def ethernet_ip(data: bytes, number: int, client: bool) -> bytes:
    """A packet that carries a CIP request (from the client) or response."""
    items = struct.pack("<HHHHH", 2, 0, 0, 0xB2, len(data)) + data
    body = struct.pack("<IH", 0, 0) + items
    message = struct.pack("<HHIIQI", 0x6F, len(body), 1, 0, number, 0) + body
    ports = (50000, 44818) if client else (44818, 50000)
    udp = struct.pack(">HHHH", *ports, 8 + len(message), 0) + message
    hosts = (b"\x0a\0\0\x01", b"\x0a\0\0\x02")
    source, target = hosts if client else hosts[::-1]
    ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, source, target) + udp
    return b"\x02\0\0\0\0\x02\x02\0\0\0\0\x01\x08\0" + ip


def check_cip(checks: Checks, product: str, lines: list[tuple[int, bytes]], capture: Path) -> None:
    """Requests and responses as EtherNet/IP: the CIP dissector names object, service and status."""
    found = pairs(lines)
    out = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)]
    for at, pair in enumerate(found):
        for client, data in zip((True, False), cip(*pair), strict=True):
            packet = ethernet_ip(data, at + 1, client)
            out.append(struct.pack("<IIII", 1_700_000_000 + at, 0 if client else 1000, len(packet), len(packet)) + packet)
    capture.write_bytes(b"".join(out))
    names = ["cip.rr", "cip.sc", "cip.genstat", "cip.class", "cip.instance", "cip.id.vendor_id", "cip.id.device_type"]
    names += ["cip.id.product_name", "_ws.malformed"]
    rows = fields(capture, names)
    wrong, codes = [], set()
    for (request, response), asked, answered in zip(found, rows[::2], rows[1::2], strict=True):
        status = response[1] if response[0] == ERROR else 0
        codes.add(status)
        got = [number(asked[name]) for name in ("cip.rr", "cip.sc", "cip.class", "cip.instance")]
        seen = [number(answered[name]) for name in ("cip.sc", "cip.genstat")]
        good = got == [0, *request[:3]] and seen == [request[0], status] and number(answered["cip.rr"]) in (1, 0x80)
        if not good or asked["_ws.malformed"] or answered["_ws.malformed"]:
            wrong.append((request.hex(), response.hex(), asked, answered))
    checks.equal(f"{len(found)} requests and responses are those of CIP", [], wrong[:3])
    checks.equal("all status codes", CODES, codes)
    for name, value in (("vendor_id", VENDOR), ("device_type", 0)):
        checks.equal(name, {value}, {number(row[f"cip.id.{name}"]) for row in rows if row[f"cip.id.{name}"]})
    shown = {row["cip.id.product_name"] for row in rows if row["cip.id.product_name"]}
    checks.equal("product name", {f"INCLINOMETER {product[-3:]} degree"}, shown)


def main() -> int:
    """Runs the checks; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--traces", type=Path, required=True)
    traces, checks = parser.parse_args().traces, Checks()
    with tempfile.TemporaryDirectory() as folder:
        for product in ("tiltix080", "tiltix360"):
            lines = frames(traces, product)
            check_frames(checks, lines, Path(folder) / "frames.log")
            check_group_3(checks, lines, Path(folder) / "group3.log")
            check_cip(checks, product, lines, Path(folder) / "cip.pcap")
    return int(checks.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
