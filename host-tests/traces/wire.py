"""The exact length of a CAN frame in bits (ISO 11898-1)."""

EXTENDED = 0x8000_0000  # bit 31 of an identifier: 29-bit format
INTERMISSION = 3

# CRC delimiter, acknowledge slot and delimiter, end of frame: without stuff bits.
TRAILER = 1 + 2 + 7
CRC_POLYNOMIAL = 0x4599


def bits_of(value: int, count: int) -> list[int]:
    """A number as bits, the highest first."""
    return [value >> shift & 1 for shift in reversed(range(count))]


def crc15(bits: list[int]) -> int:
    """The CRC of CAN over bits without stuff bits."""
    crc = 0
    for bit in bits:
        carry = bit ^ crc >> 14
        crc = crc << 1 & 0x7FFF
        if carry:
            crc ^= CRC_POLYNOMIAL
    return crc


def stuff_bits(bits: list[int]) -> int:
    """The number of stuff bits: after five equal bits an opposite one is inserted, which counts for the next five."""
    inserted, run, last = 0, 0, None
    for bit in bits:
        run = run + 1 if bit == last else 1
        last = bit
        if run == 5:
            inserted += 1
            last, run = 1 - bit, 1
    return inserted


def frame_bits(identifier: int, data: bytes, remote_dlc: int | None = None) -> int:
    """The length of a frame in bits, from start of frame to end of frame."""
    remote = remote_dlc is not None
    if identifier & EXTENDED:
        number = identifier & 0x1FFF_FFFF
        head = [0, *bits_of(number >> 18, 11), 1, 1, *bits_of(number & 0x3FFFF, 18), int(remote), 0, 0]
    else:
        head = [0, *bits_of(identifier, 11), int(remote), 0, 0]
    body = head + bits_of(remote_dlc if remote else len(data), 4)
    for byte in b"" if remote else data:
        body += bits_of(byte, 8)
    body += bits_of(crc15(body), 15)
    return len(body) + stuff_bits(body) + TRAILER
