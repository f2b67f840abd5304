#!/usr/bin/env python3
"""Reference vectors for the Kalman filter of accelerometer and gyroscope, computed in double precision.

    python3 generate_fusion.py

Writes fusion.csv beside itself; the output is the same every time. It needs only the standard library.

Each scene is a motion of a machine in six coordinates, as the parts measure it: acceleration in counts of 2^-14 g, at the time of
the row less DELAY; mean angular rate of the last sample period in counts of 1/64 deg/s, with bias and noise. The last two columns
are the angles of the filter in degrees: for 2 axes X and Y, for 1 axis angle and cross slope.
"""

import csv
import math
import random
from pathlib import Path

HERE = Path(__file__).resolve().parent
PERIOD = 0.005  # s
DELAY = 0.010799  # s, the age of the acceleration
UPDATE_RATE = 80  # Hz, the rate to which Q and R refer
COUNTS_PER_G = 2**14
COUNTS_PER_DPS = 64
MAX_BIAS_GAIN = 2.0**-13
MAX_BIAS = 2.0**-12  # rad in a sample period
G = 9.80665


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def add(a, b, factor=1.0):
    return [x + factor * y for x, y in zip(a, b)]


def seen_after(vector, rotation):
    """The coordinates of a fixed vector after the sensor has rotated by the rotation vector (Rodrigues)."""
    angle = math.sqrt(dot(rotation, rotation))
    if angle == 0:
        return vector
    axis = [-c / angle for c in rotation]
    across, along = cross(axis, vector), dot(axis, vector) * (1 - math.cos(angle))
    return [v * math.cos(angle) + a * math.sin(angle) + n * along for v, a, n in zip(vector, across, axis)]


def body_axes(yaw, pitch, roll):
    """The matrix from the fixed frame to the sensor: its columns are the fixed axes in the sensor."""
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (math.cos, math.sin))
    return [
        [cy * cp, sy * cp, -sp],
        [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
        [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
    ]


def angular_rate(attitude, time):
    """Body rates in rad/s of yaw, pitch, roll (functions of the time), by central differences."""
    h = 1e-5
    (_, pitch, roll) = attitude(time)
    yaw_rate, pitch_rate, roll_rate = (
        (after - before) / (2 * h) for before, after in zip(attitude(time - h), attitude(time + h))
    )
    return [
        roll_rate - yaw_rate * math.sin(pitch),
        pitch_rate * math.cos(roll) + yaw_rate * math.sin(roll) * math.cos(pitch),
        -pitch_rate * math.sin(roll) + yaw_rate * math.cos(roll) * math.cos(pitch),
    ]


def mean_rate(attitude, time):
    """The mean over the sample period before `time` (Simpson's rule)."""
    points = [angular_rate(attitude, time - PERIOD * part) for part in (0, 0.25, 0.5, 0.75, 1)]
    return [sum(w * p[i] for w, p in zip((1, 4, 2, 4, 1), points)) / 12 for i in range(3)]


def smooth(time, start, length):
    """From 0 to 1 within `length` seconds."""
    part = min(max((time - start) / length, 0), 1)
    return part - math.sin(2 * math.pi * part) / (2 * math.pi)


def shock(time, at, height):
    """A decaying oscillation of 25 Hz."""
    return height * math.exp(-(time - at) / 0.04) * math.sin(157 * (time - at)) if time > at else 0.0


def digging(time):
    pitch = -20 + 45 * smooth(time, 0.5, 0.6) - 60 * smooth(time, 1.6, 0.8) + 35 * smooth(time, 2.7, 0.5)
    attitude = [0.0, math.radians(pitch), math.radians(3 * math.sin(1.3 * time))]
    return attitude, [shock(time, 1.1, 6) + shock(time, 3.2, 9), 0.0, shock(time, 1.1, 4) + shock(time, 3.2, 5)]


def travelling(time):
    attitude = [0.05 * time, math.radians(4 + 2 * math.sin(5 * time)), math.radians(-6 + 3 * math.sin(3.1 * time + 1))]
    return attitude, [1.5 * smooth(time, 0.3, 1.0) - 1.5 * smooth(time, 2.4, 0.6), 0.8 * math.sin(9 * time), 2 * math.sin(31 * time)]


def slewing(time):
    """The turntable turns by 90 deg, at most 56 deg/s; the sensor is 3 m from the centre, and the boom is up by 25 deg."""
    yaw = math.radians(90) * smooth(time, 0.3, 3.2)
    rate = math.radians(90) / 3.2 * (1 - math.cos(2 * math.pi * min(max((time - 0.3) / 3.2, 0), 1)))
    centripetal = -3.0 * rate * rate
    attitude = [yaw, math.radians(-25), math.radians(1.5)]
    return attitude, [centripetal * math.cos(yaw), centripetal * math.sin(yaw), 0.0]


def swivel(time):
    """A bucket with a 1-axis sensor: the Z axis of the sensor is horizontal, and the angle passes 360 deg twice."""
    return [0.02 * math.sin(2 * time), math.radians(4), math.radians(400 * smooth(time, 0.3, 2.0) - 400 * smooth(time, 2.5, 1.2))], [
        shock(time, 2.3, 5), 0.0, shock(time, 2.3, 8)]


def shaking(time):
    """A machine at rest with its engine running, from power-up on: 0.5 g at 3 Hz."""
    return [0.0, math.radians(10), math.radians(-5)], [0.5 * G * math.cos(2 * math.pi * 3 * time), 0.0, 0.0]


def up_angles(axes, up):
    x, y, z = up
    if axes == 2:
        return math.atan2(-x, math.hypot(y, z)), math.atan2(y, math.hypot(x, z))
    return math.atan2(x, y), math.atan2(z, math.hypot(x, y))


def mounted(axes, vector):
    """A 1-axis sensor measures the roll about its Z axis: X, Y, Z of the machine are its Z, X, Y."""
    x, y, z = vector
    return [y, z, x] if axes == 1 else [x, y, z]


def gain(q, r):
    relation = r / q * (1 / PERIOD / UPDATE_RATE) ** 2
    return 2 / (1 + math.sqrt(1 + 4 * relation))


def rows(name, axes, scene, seconds, q, r, bias):
    noise = random.Random(name)
    steady = gain(q, r)
    up, estimate, rotations = None, [0.0] * 3, [[0.0] * 3] * 3
    for n in range(round(seconds / PERIOD)):
        now = n * PERIOD

        attitude, motion = scene(now - DELAY)
        axes_in_body = body_axes(*attitude)
        total = [motion[0] / G, motion[1] / G, 1 + motion[2] / G]
        force = mounted(axes, [dot(row, total) for row in axes_in_body])
        force = [round((f + noise.gauss(0, 0.0015)) * COUNTS_PER_G) for f in force]
        force = [min(max(f, -8 * COUNTS_PER_G), 8 * COUNTS_PER_G - 1) for f in force]

        rate = mounted(axes, [math.degrees(w) for w in mean_rate(lambda t: scene(t)[0], now)])
        rate = [round((w + b + noise.gauss(0, 0.05)) * COUNTS_PER_DPS) for w, b in zip(rate, bias)]

        measured = [f / COUNTS_PER_G for f in force]
        if up is None:
            up = measured
        # The mean of all samples, weighted by their numbers, until its gain meets the steady one. Then the bias is estimated.
        k = max(2 / (n + 2), steady)
        bias_gain = min(k * k / 4, MAX_BIAS_GAIN) if k == steady else 0.0
        rotation = [math.radians(w / COUNTS_PER_DPS) * PERIOD - b for w, b in zip(rate, estimate)]
        rotations = [rotation, *rotations[:2]]
        up = seen_after(up, rotation)
        weights = [min(max(DELAY / PERIOD - i, 0), 1) for i in range(3)]
        forward = [sum(w * r[i] for w, r in zip(weights, rotations)) for i in range(3)]
        measured = seen_after(measured, forward)
        estimate = [min(max(b, -MAX_BIAS), MAX_BIAS) for b in add(estimate, cross(up, measured), bias_gain)]
        up = add(up, add(measured, up, -1), k)

        angles = [f"{math.degrees(angle):.5f}" for angle in up_angles(axes, up)]
        yield name, axes, f"{q:g}", *force, *rate, *angles


SCENES = [
    ("digging", 2, digging, 4, 1e-3, (0.5, -0.3, 0.2)),
    ("travelling", 2, travelling, 3.5, 1e-4, (-0.4, 0.5, 0.1)),
    ("slewing", 2, slewing, 4, 1e-2, (0.2, 0.1, -0.5)),
    ("shaking", 2, shaking, 3.5, 1e-3, (0.1, -0.2, 0.1)),
    ("swivel", 1, swivel, 4, 1e-3, (0.1, 0.4, -0.5)),
]

with open(HERE / "fusion.csv", "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow("scene axes q ax ay az gx gy gz angle1_deg angle2_deg".split())
    for name, axes, scene, seconds, q, bias in SCENES:
        writer.writerows(rows(name, axes, scene, seconds, q, 10.0, bias))
