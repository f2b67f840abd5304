"""The two filters of the manual (section 9.1) in continuous time, as the reference for measurements.

Butterworth of order 8, and critically damped of order 8: eight equal poles, placed so that the filter has -3 dB at the cut-off
frequency.
"""

import cmath
import math

ORDER = 8
BUTTERWORTH = 1
CRITICALLY_DAMPED = 2

# One of the eight equal low-passes, relative to the cut-off frequency.
_SPREAD = math.sqrt(2 ** (1 / ORDER) - 1)


def gain_db(kind: int, cutoff: float, frequency: float) -> float:
    """Gain at a frequency in Hz."""
    ratio = frequency / cutoff
    if kind == BUTTERWORTH:
        return -10 * math.log10(1 + ratio ** (2 * ORDER))
    return -10 * ORDER * math.log10(1 + (ratio * _SPREAD) ** 2)


def step(kind: int, cutoff: float, time: float) -> float:
    """The response to a unit step, `time` in s after it."""
    if time <= 0:
        return 0.0
    omega = 2 * math.pi * cutoff
    if kind == CRITICALLY_DAMPED:
        x = omega / _SPREAD * time
        term, total = 1.0, 1.0
        for order in range(1, ORDER):
            term *= x / order
            total += term
        return 1.0 - math.exp(-x) * total
    poles = [omega * cmath.exp(1j * math.pi * (2 * n + ORDER + 1) / (2 * ORDER)) for n in range(ORDER)]
    value = 1.0 + 0j
    for pole in poles:
        residue = omega**ORDER / pole
        for other in poles:
            if other is not pole:
                residue /= pole - other
        value += residue * cmath.exp(pole * time)
    return value.real
