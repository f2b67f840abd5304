"""Finds the records in the store file of a virtual sensor, to damage them.

A record is 'P', version 01h, product u16, sequence u32, length u16, the payload, zeros to a multiple of four bytes and the
CRC-32 of all these bytes. Numbers are little-endian; erased memory reads FFh.
"""

import zlib
from dataclasses import dataclass
from pathlib import Path

HEADER = 10


@dataclass(frozen=True)
class Record:
    """The position of a complete record."""

    offset: int
    size: int
    sequence: int


def find(path: Path) -> list[Record]:
    """All complete records in a store file, the newest last."""
    memory = path.read_bytes()
    records = []
    for offset in range(0, len(memory) - HEADER, 4):
        if memory[offset : offset + 2] != b"P\x01":
            continue
        length = int.from_bytes(memory[offset + 8 : offset + 10], "little")
        body = (HEADER + length + 3) // 4 * 4
        crc = memory[offset + body : offset + body + 4]
        if len(crc) == 4 and zlib.crc32(memory[offset : offset + body]) == int.from_bytes(crc, "little"):
            sequence = int.from_bytes(memory[offset + 4 : offset + 8], "little")
            records.append(Record(offset, body + 4, sequence))
    return sorted(records, key=lambda record: record.sequence)


def flip(path: Path, position: int, mask: int = 0x01) -> None:
    """Flips bits of one byte of a store file."""
    memory = bytearray(path.read_bytes())
    memory[position] ^= mask
    path.write_bytes(memory)


def cut_off(path: Path, record: Record, kept: int) -> None:
    """Erases a record after `kept` bytes, like a power cut during the save; negative: counted from the end of the record."""
    kept %= record.size
    memory = bytearray(path.read_bytes())
    memory[record.offset + kept : record.offset + record.size] = b"\xff" * (record.size - kept)
    path.write_bytes(memory)
