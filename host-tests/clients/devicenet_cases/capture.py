"""Files for tshark: a candump log with other identifiers, and requests and replies as EtherNet/IP in a capture file.

capture file     global header, then for each packet: header, Ethernet, IPv4, UDP, encapsulation, two items, CIP
encapsulation    command u16, length u16, session u32, status u32, context 8 bytes, options u32, interface u32, timeout u16
items            count u16; type u16, length u16 (null address); type u16, length u16, data (unconnected data)
CIP request      service, path words, 20 class 24 instance [30 attribute], data
CIP reply        service | 80, 00, general status, additional words, additional status u16..., data
"""

import re
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

from . import protocol as p

LINE = re.compile(r"\(\d+\.\d{6}\) \S+ ([0-9A-F]{3})#([0-9A-F]*)")
SEND_RR_DATA, PORT, CLIENT_PORT = 0x006F, 44818, 50000
NULL_ADDRESS, UNCONNECTED_DATA = 0x0000, 0x00B2


@dataclass(frozen=True)
class Pair:
    """A request and its reply without headers."""

    request: bytes
    reply: bytes


def frames(log: Path) -> list[tuple[int, bytes]]:
    """Identifier and data of each line of a log."""
    return [(int(number, 16), bytes.fromhex(data)) for number, data in LINE.findall(log.read_text())]


def write_log(path: Path, lines: list[tuple[int, bytes]]) -> Path:
    """Writes a log in the format of `candump -L`."""
    rows = (f"({1.7e9 + 0.001 * n:.6f}) can0 {number:03X}#{data.hex().upper()}\n" for n, (number, data) in enumerate(lines))
    path.write_text("".join(rows))
    return path


def pairs(lines: list[tuple[int, bytes]], mac: int) -> list[Pair]:
    """The requests and replies in a log, with the fragments of replies put together."""
    found, request, reply = [], b"", b""
    for number, data in lines:
        if number in (p.group2(p.EXPLICIT, mac), p.group2(p.PORT, mac)):
            if data and not data[0] & 0x80:
                request = data[1:]
        elif number == p.group2(p.RESPONSE, mac) and request and len(data) > 1:
            if not data[0] & 0x80:
                found.append(Pair(request, data[1:]))
            elif data[1] & 0xC0 != 0xC0:
                reply = (reply if data[1] & 0xC0 else b"") + data[2:]
                if data[1] & 0xC0 == 0x80:
                    found.append(Pair(request, reply))
    return found


def cip(pair: Pair) -> tuple[bytes, bytes]:
    """Request and reply as CIP has them."""
    service, kind, instance, rest = pair.request[0], pair.request[1], pair.request[2], pair.request[3:]
    path = bytes([0x20, kind, 0x24, instance])
    if service in (p.GET, p.SET) and rest:
        path += bytes([0x30, rest[0]])
        rest = rest[1:]
    request = bytes([service, len(path) // 2]) + path + rest
    if pair.reply[0] != 0x94:
        return request, bytes([pair.reply[0], 0, 0, 0]) + pair.reply[1:]
    general, additional = pair.reply[1], pair.reply[2]
    words = b"" if additional == 0xFF else struct.pack("<H", additional)
    return request, bytes([service | 0x80, 0, general, len(words) // 2]) + words


def ethernet_ip(data: bytes, number: int, client: bool) -> bytes:
    """A packet that carries a CIP request (from the client) or reply."""
    items = struct.pack("<HHHHH", 2, NULL_ADDRESS, 0, UNCONNECTED_DATA, len(data)) + data
    body = struct.pack("<IH", 0, 0) + items
    message = struct.pack("<HHIIQI", SEND_RR_DATA, len(body), 1, 0, number, 0) + body
    ports = (CLIENT_PORT, PORT) if client else (PORT, CLIENT_PORT)
    udp = struct.pack(">HHHH", *ports, 8 + len(message), 0) + message
    hosts = (b"\x0a\0\0\x01", b"\x0a\0\0\x02")
    source, target = hosts if client else hosts[::-1]
    ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, source, target) + udp
    return b"\x02\0\0\0\0\x02\x02\0\0\0\0\x01\x08\0" + ip


def write_capture(path: Path, found: list[Pair]) -> Path:
    """Writes pairs as a capture file."""
    out = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)]
    for number, pair in enumerate(found):
        for client, data in zip((True, False), cip(pair), strict=True):
            packet = ethernet_ip(data, number + 1, client)
            out.append(struct.pack("<IIII", 1_700_000_000 + number, 0 if client else 1000, len(packet), len(packet)) + packet)
    path.write_bytes(b"".join(out))
    return path


def fields(path: Path, names: list[str], *options: str) -> list[dict[str, str]]:
    """Fields of each packet as tshark reads them."""
    command = ["tshark", "-n", "-r", str(path), *options, "-T", "fields", "-E", "separator=/t", "-E", "occurrence=f"]
    for name in names:
        command += ["-e", name]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [dict(zip(names, line.split("\t"), strict=True)) for line in done.stdout.splitlines()]
