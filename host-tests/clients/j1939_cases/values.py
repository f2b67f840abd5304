"""Process data in double precision: what the sensor must send for an angle, a rate or an acceleration (S30..S36).

SSI2    pitch 3 bytes, roll 3 bytes, byte 7: compensation, figure of merit of pitch, the same of roll; latency
SSI     pitch, roll, pitch rate, 2 bytes each, byte 7: figures of merit of pitch, roll, rate, compensation; latency
ARI     pitch, roll and yaw rate, 2 bytes each, byte 7 and 8
ACCS    lateral, longitudinal, vertical acceleration, 2 bytes each, byte 7 and 8
"""

import math
from dataclasses import dataclass

GOOD, DEGRADED, ERROR, NOT_AVAILABLE = 0, 1, 2, 3
COMPENSATION = 3
GRAVITY = 9.80665
GYRO_GAIN = 0.0012
QUANTIZED = 0.02  # deg and deg/s; the simulated part has 16 bits


@dataclass(frozen=True)
class Scale:
    """Resolution, offset and size in bytes of a value."""

    per_bit: float
    offset: float
    size: int

    @property
    def highest(self) -> int:
        """The highest raw value that is a measured one: FAFFh or FAFFFFh."""
        return 0xFB << 8 * (self.size - 1)

    def raw(self, value: float | None) -> int | None:
        """The raw value, or None if it cannot be sent (S34)."""
        if value is None:
            return None
        number = math.floor((value - self.offset) / self.per_bit + 0.5)
        return number if 0 <= number < self.highest else None


FINE = Scale(1 / 32768, -250, 3)
COARSE = Scale(0.002, -64, 2)
RATE = Scale(1 / 128, -250, 2)
ACCELERATION = Scale(0.01, -320, 2)


@dataclass(frozen=True)
class Wanted:
    """Expected data: values with their scales, byte 7 and, if it is compared, byte 8. A raw value may differ by `tolerance`, and a
    turn rate by the gain of the simulated part."""

    values: tuple[tuple[Scale, float | None], ...]
    quality: int
    last: frozenset[int] | None = None
    tolerance: int = 1

    def allowed(self, place: int, quantized: bool) -> float:
        """The greatest difference of a raw value."""
        scale, value = self.values[place]
        gain = GYRO_GAIN * abs(value or 0.0) / scale.per_bit if scale == RATE or (scale == COARSE and place == 2) else 0.0
        return self.tolerance + gain + (QUANTIZED / scale.per_bit if quantized and scale != ACCELERATION else 0.0)

    def fits(self, data: bytes, quantized: bool = False) -> bool:
        """Whether received data is as expected; `quantized` by the part that a firmware image reads."""
        if len(data) != 8 or data[6] != self.quality or (self.last is not None and data[7] not in self.last):
            return False
        at = 0
        for place, (scale, value) in enumerate(self.values):
            got = int.from_bytes(data[at : at + scale.size], "little")
            raw = scale.raw(value)
            missing = (1 << 8 * scale.size) - 1
            if got != missing if raw is None else abs(got - raw) > self.allowed(place, quantized) or got >= scale.highest:
                return False
            at += scale.size
        return True

    def __str__(self) -> str:
        parts = [
            "FF" * scale.size if (raw := scale.raw(value)) is None else raw.to_bytes(scale.size, "little").hex().upper()
            for scale, value in self.values
        ]
        last = ".." if self.last is None else "/".join(f"{one:02X}" for one in sorted(self.last))
        return f"{''.join(parts)}{self.quality:02X}{last}"


def merit(scale: Scale, value: float | None, state: int) -> int:
    """The figure of merit: not available before degraded before good."""
    return NOT_AVAILABLE if scale.raw(value) is None else state


def ssi2(
    pitch: float | None, roll: float | None, *, states: tuple[int, int] = (0, 0), last: frozenset[int] | None = None
) -> Wanted:
    """SSI2 (S31). `states` are the figures of merit of values that can be sent."""
    first, second = merit(FINE, pitch, states[0]), merit(FINE, roll, states[1])
    quality = COMPENSATION | first << 2 | COMPENSATION << 4 | second << 6
    return Wanted(((FINE, pitch), (FINE, roll)), quality, last, 2)


def ssi(
    pitch: float | None,
    roll: float | None,
    rate: float = 0.0,
    *,
    states: tuple[int, int] = (0, 0),
    last: frozenset[int] | None = None,
    tolerance: int = 1,
) -> Wanted:
    """SSI (S32)."""
    quality = (
        merit(COARSE, pitch, states[0]) | merit(COARSE, roll, states[1]) << 2 | merit(COARSE, rate, 0) << 4 | COMPENSATION << 6
    )
    return Wanted(((COARSE, pitch), (COARSE, roll), (COARSE, rate)), quality, last, tolerance)


def three(scale: Scale, values: tuple[float, float, float]) -> Wanted:
    """ARI and ACCS (S33): figures of merit as in SSI, byte 8 FFh."""
    quality = COMPENSATION << 6
    for place, value in enumerate(values):
        quality |= merit(scale, value, 0) << 2 * place
    return Wanted(tuple((scale, value) for value in values), quality, frozenset({0xFF}))


def ari(pitch: float, roll: float, yaw: float) -> Wanted:
    """ARI: the rates about Y, X, Z of a sensor with two axes."""
    return three(RATE, (pitch, roll, yaw))


def accs(up: tuple[float, float, float]) -> Wanted:
    """ACCS: Y, X, Z of the specific force in g."""
    return three(ACCELERATION, (up[1] * GRAVITY, up[0] * GRAVITY, up[2] * GRAVITY))


def latency(kind: int, milliherz: int) -> frozenset[int]:
    """Byte 8 of the slope messages (S35): the delay at DC in 0.5 ms. Both the printed constant and the exact one are right."""
    exact = 8 * math.sqrt(2 ** (1 / 8) - 1) if kind == 2 else sum(2 * math.cos((2 * i + 1) * math.pi / 16) for i in range(4))
    printed = 383.0 if kind == 2 else 816.0
    if kind == 0:
        return frozenset({0})
    found = set()
    for delay in (printed * 1000 / milliherz, exact * 1000 / (2 * math.pi) * 1000 / milliherz):
        rounded = math.floor(delay / 0.5 + 0.5)
        # A delay that is above 125 ms before it is rounded, and not afterwards, can be sent either way.
        found |= {0xFF} if rounded > 250 else {rounded, 0xFF} if delay > 125 else {rounded}
    return frozenset(found)


def printed(fine: bool, data: bytes) -> Wanted:
    """The bytes of an example of SSI2 (`fine`) or SSI. At -89.5 deg, the roll angle of 0.2 deg is 0.1 of a bit below the border of
    rounding, so a difference of one bit is right."""
    scales = (FINE, FINE) if fine else (COARSE, COARSE, COARSE)
    values, at = [], 0
    for scale in scales:
        raw = int.from_bytes(data[at : at + scale.size], "little")
        values.append((scale, raw * scale.per_bit + scale.offset if raw < scale.highest else None))
        at += scale.size
    return Wanted(tuple(values), data[6], frozenset({data[7]}))
