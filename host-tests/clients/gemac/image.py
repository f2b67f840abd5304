"""Finds the images in the memory file of a virtual sensor, to damage them.

An image is 'P', version 01h, model u16, sequence u32, length u16, the payload, zeros to a multiple of four bytes and the
CRC-32 of all that; numbers are little-endian, erased memory reads FFh.
"""

import zlib
from dataclasses import dataclass
from pathlib import Path

HEADER = 10


@dataclass(frozen=True)
class Image:
    """Where a whole image lies."""

    offset: int
    size: int
    sequence: int


def find(path: Path) -> list[Image]:
    """All whole images in a memory file, the newest last."""
    memory = path.read_bytes()
    images = []
    for offset in range(0, len(memory) - HEADER, 4):
        if memory[offset : offset + 2] != b"P\x01":
            continue
        length = int.from_bytes(memory[offset + 8 : offset + 10], "little")
        body = (HEADER + length + 3) // 4 * 4
        crc = memory[offset + body : offset + body + 4]
        if len(crc) == 4 and zlib.crc32(memory[offset : offset + body]) == int.from_bytes(crc, "little"):
            sequence = int.from_bytes(memory[offset + 4 : offset + 8], "little")
            images.append(Image(offset, body + 4, sequence))
    return sorted(images, key=lambda image: image.sequence)


def flip(path: Path, position: int, mask: int = 0x01) -> None:
    """Flips bits of one byte of a memory file."""
    memory = bytearray(path.read_bytes())
    memory[position] ^= mask
    path.write_bytes(memory)


def cut_off(path: Path, image: Image, kept: int) -> None:
    """Erases an image from `kept` bytes on, as a power cut during the save leaves it; negative: counted from its end."""
    kept %= image.size
    memory = bytearray(path.read_bytes())
    memory[image.offset + kept : image.offset + image.size] = b"\xff" * (image.size - kept)
    path.write_bytes(memory)
