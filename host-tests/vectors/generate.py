#!/usr/bin/env python3
"""Reference vectors for the measurement path, computed independently of the firmware.

    pip install numpy scipy mpmath
    python3 generate.py

Writes the CSV files beside itself; the output is the same every time. Angles are computed with 40 digits (mpmath), step
responses with scipy's Butterworth design and filter routine, frequency responses from the closed form of the prototypes.
"""

import csv
from pathlib import Path

import mpmath as mp
import numpy as np
import scipy.signal

HERE = Path(__file__).resolve().parent
RATE = 200  # Hz, the sampling rate of the firmware
ONE_G = 2**26
ORDER = 8
mp.mp.dps = 40

CYCLE_RATE = 1428  # Hz, the program cycles of the TILTIX
# Weights of the recursive filter in 1/1000 and sizes of the moving average
OUTPUT_FILTERS = [(900, 0), (990, 0), (999, 0), (0, 100), (0, 250), (999, 50), (900, 250)]

# Cut-off frequencies in mHz
CUTOFFS = {"butterworth": [100, 500, 2000, 8000, 25000], "critical": [100, 500, 2000, 8000]}


def write(name, header, rows):
    with open(HERE / name, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def degrees(radians):
    return mp.nstr(radians * 180 / mp.pi, 14)


def atan2_rows():
    points = []
    for m in (1, 7, 1000, 2**17, 2**24 - 1, 2**24, 2**24 + 1, 2**28, 2**30, 2**31 - 1):
        for d in (-1, 0, 1):
            for a, b in ((m, m + d), (m, d), (d, m)):
                points += [(s * a, t * b) for s in (1, -1) for t in (1, -1)]
    for radius in (2**12, 2**18, 2**28):
        for theta in np.linspace(0, 2 * np.pi, 181):
            points.append((int(round(radius * np.sin(theta))), int(round(radius * np.cos(theta)))))
    for y, x in dict.fromkeys(points):
        if (y or x) and max(abs(y), abs(x)) < 2**31:
            yield y, x, degrees(mp.atan2(y, x))


def up_vectors():
    special = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 1, 1), (1, -1, 1), (-1, 1, -1)]
    special += [(1e-6, 0, 1), (0, 1e-6, 1), (1, 1e-6, 0), (1, 0, 1e-4), (1e-7, 1, 1e-7), (-1e-5, 1e-5, -1)]
    random = np.random.default_rng(9).normal(size=(400, 3))
    for vector in [np.array(v, float) for v in special] + list(random):
        yield [int(v) for v in np.rint(vector / np.linalg.norm(vector) * ONE_G)]


def angle_rows():
    """X and Y of a 2-axis sensor, angle and cross slope of a 1-axis one."""
    for up in up_vectors():
        x, y, z = [mp.mpf(v) for v in up]
        gx, gy, gz = -x, y, z
        perpendicular_x = mp.atan2(gx, mp.sqrt(gy**2 + gz**2))
        perpendicular_y = mp.atan2(gy, mp.sqrt(gx**2 + gz**2))
        rotation = mp.atan2(x, y) % (2 * mp.pi) if x or y else mp.mpf(0)
        cross_slope = mp.asin(z / mp.sqrt(x**2 + y**2 + z**2))
        yield [*up, *map(degrees, (perpendicular_x, perpendicular_y, rotation, cross_slope))]


def sections(kind, cutoff):
    """The digital filter as second-order sections, bilinear transform with prewarping."""
    fc = cutoff / 1000
    if kind == "butterworth":
        return scipy.signal.butter(ORDER, fc, fs=RATE, output="sos")
    # Eight equal poles, each with a cut-off frequency higher than that of the filter by this factor.
    g = np.tan(np.pi * fc / RATE) / np.sqrt(2 ** (1 / ORDER) - 1)
    zero_gain, pole = g / (1 + g), (1 - g) / (1 + g)
    one = np.array([zero_gain, zero_gain]), np.array([1, -pole])
    return np.tile(np.concatenate([np.convolve(one[0], one[0]), np.convolve(one[1], one[1])]), (ORDER // 2, 1))


def step_rows():
    for kind, cutoffs in CUTOFFS.items():
        for cutoff in cutoffs:
            samples = 6 * RATE * 1000 // cutoff
            response = scipy.signal.sosfilt(sections(kind, cutoff), np.ones(samples))
            for n in range(0, samples, max(1, samples // 240)):
                yield kind, cutoff, n, f"{response[n]:.10f}"


def overshoot_rows():
    for cutoff in CUTOFFS["butterworth"]:
        samples = 10 * RATE * 1000 // cutoff
        response = scipy.signal.sosfilt(sections("butterworth", cutoff), np.ones(samples))
        yield cutoff, f"{response.max() - 1:.8f}"


def response_rows():
    """Magnitude in dB of the analogue prototypes at the prewarped frequency."""
    for kind, cutoffs in CUTOFFS.items():
        for cutoff in cutoffs:
            fc = mp.mpf(cutoff) / 1000
            frequencies = [float(f"{v:.6g}") for v in np.geomspace(float(fc) / 30, min(99, float(fc) * 3), 40)]
            for frequency in sorted({*frequencies, float(fc)}):
                ratio = mp.tan(mp.pi * mp.mpf(repr(frequency)) / RATE) / mp.tan(mp.pi * fc / RATE)
                if kind == "butterworth":
                    power = 1 + ratio ** (2 * ORDER)
                else:
                    power = (1 + ratio**2 * (mp.mpf(2) ** (mp.mpf(1) / ORDER) - 1)) ** ORDER
                yield kind, cutoff, frequency, mp.nstr(-10 * mp.log10(power), 12)


def output_filter_rows():
    """A step of 100 behind a recursive filter and a moving average, at the end of each reading of 1428 / RATE program cycles."""
    for weight, size in OUTPUT_FILTERS:
        w = weight / 1000
        response = scipy.signal.lfilter([1 - w], [1, -w], np.full(3 * CYCLE_RATE, 100.0))
        if size:
            response = scipy.signal.lfilter(np.ones(size) / size, [1], response)
        for reading in range(1, 3 * RATE):
            yield weight, size, reading, f"{response[reading * CYCLE_RATE // RATE - 1]:.8f}"


write("atan2.csv", ["y", "x", "deg"], atan2_rows())
write("angles.csv", ["ux", "uy", "uz", "x_deg", "y_deg", "rotation_deg", "cross_slope_deg"], angle_rows())
write("steps.csv", ["filter", "cutoff_mhz", "sample", "response"], step_rows())
write("overshoot.csv", ["cutoff_mhz", "overshoot"], overshoot_rows())
write("responses.csv", ["filter", "cutoff_mhz", "frequency_hz", "magnitude_db"], response_rows())
write("output_filter.csv", ["weight", "size", "reading", "response"], output_filter_rows())
