"""Attitudes, step and frequency response of the filters, vibration, wrap-around (9.1, 9.2, 9.9.1)."""

import cmath
import math
import random
from collections.abc import Callable
from functools import partial

from . import filters, scenes
from . import protocol as p
from .context import Context
from .session import Session, counter, decode_angles

SEED = 36000
PERIOD = 0.010  # of the recordings, in s
OFF = p.filter_value(25000, 0)

Recording = list[tuple[int, tuple[int, ...], float]]


def sphere(count: int) -> list[scenes.Vector]:
    """Directions spread evenly over the sphere (Fibonacci's spiral)."""
    golden = math.pi * (3 - math.sqrt(5))
    points = []
    for n in range(count):
        z = 1 - (2 * n + 1) / count
        radius = math.sqrt(1 - z * z)
        points.append((radius * math.cos(golden * n), radius * math.sin(golden * n), z))
    return points


def attitudes(context: Context) -> None:
    """150 attitudes over the full sphere, filter off: within one digit of 0.01 deg."""
    lead, dwell, share = 0.6, 0.3, 5
    directions = sphere(150)
    runs = []
    for part in range(share):
        chosen = directions[part::share]
        rows = scenes.plateaus([(0.0, chosen[0])] + [(lead + dwell * n, d) for n, d in enumerate(chosen) if n])
        path = scenes.write(context.folder / f"sphere{part}.csv", rows)
        runs.append((context.session(scene=path), chosen))
    worst = 0.0
    try:
        for session, _ in runs:
            session.tester.request(session.set_id, b"\x27" + OFF)
        for n in range(len(directions) // share):
            for session, chosen in runs:
                due = session.sensor.started + lead + dwell * (n + 0.85)
                session.sleep(max(0.0, due - session.now()))
                worst = max(worst, check_attitude(session, chosen[n]))
    finally:
        for session, _ in runs:
            session.power_down()
    context.report.within("150 attitudes: worst difference in deg", 0, 0.0101, worst)


def check_attitude(session: Session, up: scenes.Vector) -> float:
    """Checks one attitude; returns the difference in deg."""
    exact = (scenes.one_axis_angle(up),) if session.product.axes == 1 else scenes.two_axis_angles(up)
    got = session.angles()
    if got is None:
        session.report.verdict(False, f"attitude {up}", exact, None)
        return 360.0
    if session.product.axes == 1:
        difference = abs(scenes.circular_difference(got[0] / 100, exact[0]))
    else:
        difference = max(abs(g / 100 - t) for g, t in zip(got, exact, strict=True))
    name = f"up = ({up[0]:+.4f}, {up[1]:+.4f}, {up[2]:+.4f})"
    shown = tuple(round(value, 4) for value in exact)
    session.report.verdict(difference <= 0.0101, name, f"{shown} deg +-0.01", tuple(g / 100 for g in got))
    return difference


def record(session: Session, setting: bytes, until: float) -> tuple[Recording, float]:
    """Sets the filter and records cyclic frames until `until` s of the scene. Returns (counter, angles, host time) of each
    frame and the time at which cyclic mode was switched on.

    The counter is the clock of the sensor, so the transmission time of a frame has no effect.
    """
    session.tester.request(session.set_id, b"\x27" + setting)
    session.tester.request(session.set_id, b"\x25" + p.u16(round(1000 * PERIOD)))
    reply = session.tester.request(session.set_id, b"\x26\x01")
    frames = session.tester.collect(session.sensor.started + until - session.now())
    recording = []
    for frame in frames:
        number = counter(session.product, frame.data)
        if number is not None:
            recording.append((number, decode_angles(session.product, frame.data), frame.at))
    return recording, reply.at if reply else 0.0


def step_response(context: Context) -> None:
    """A step of 30 deg: the complete curve, overshoot, final value (figure 15)."""
    at, height = 1.5, 30.0
    low, high = scenes.two_axis_up(0, 0), scenes.two_axis_up(height, 0)
    path = scenes.write(context.folder / "step.csv", scenes.plateaus([(0.0, low), (at, high)]))
    for kind, name, cutoff in (
        (filters.CRITICALLY_DAMPED, "critically damped", 2.0),
        (filters.CRITICALLY_DAMPED, "critically damped", 8.0),
        (filters.BUTTERWORTH, "Butterworth", 2.0),
    ):
        with context.session(scene=path) as session:
            setting = p.filter_value(round(1000 * cutoff), kind)
            recording, switched_on = record(session, setting, at + 1.0 + 4.0 / cutoff)
            check_step(session, f"{name} {cutoff:g} Hz", recording, switched_on, partial(filters.step, kind, cutoff))


def check_step(session: Session, name: str, recording: Recording, switched_on: float, unit: Callable[[float], float]) -> None:
    """Compares a recorded step with the exact one; only the time of the step is fitted."""
    report, at, height = session.report, 1.5, 30.0
    sine, cosine = math.sin(math.radians(height)), math.cos(math.radians(height))

    def exact(seconds: float) -> float:
        s = unit(seconds)
        return math.degrees(math.atan2(sine * s, 1 + (cosine - 1) * s))

    points = [(PERIOD * number, values[0] / 100) for number, values, _ in recording]
    if len(points) < 100:
        report.verdict(False, f"{name}: recording", "100 frames or more", len(points))
        return

    def error(origin: float) -> float:
        return sum((exact(t - origin) - angle) ** 2 for t, angle in points)

    expected_origin = session.sensor.started + at - switched_on
    origin = min((expected_origin + 0.001 * n for n in range(-20, 160, 4)), key=error)
    origin = min((origin + 0.0005 * n for n in range(-10, 11)), key=error)
    report.within(f"{name}: delay without the filter, with the process start, in s", -0.01, 0.12, origin - expected_origin)
    worst = max(abs(exact(t - origin) - angle) for t, angle in points)
    report.within(f"{name}: worst difference from the curve in deg", 0, 0.012 * height, worst)
    angles = [angle for _, angle in points]
    report.within(f"{name}: final value in deg", height - 0.0101, height + 0.0101, angles[-1])
    peak = max(exact(0.002 * n) for n in range(1500))
    if "damped" in name:
        report.within(f"{name}: peak in deg, no overshoot", height - 0.0101, height + 0.0101, max(angles))
        steps = [b - a for a, b in zip(angles, angles[1:], strict=False)]
        report.within(f"{name}: smallest step in deg, never negative", -0.0101, height, min(steps))
    else:
        report.within(f"{name}: peak in deg", peak - 0.1, peak + 0.1, max(angles))


TONES = {0.5: 0.05, 1.0: 0.05, 2.0: 0.05, 3.0: 0.2, 4.0: 0.4}  # Hz: g


def frequency_response(context: Context) -> None:
    """Gain of both filters with 2 Hz cut-off, from 0.5 to 4 Hz (figure 15)."""
    rows = []
    for n in range(6000):
        t = 0.002 * n
        pull = sum(size * math.sin(2 * math.pi * f * t) for f, size in TONES.items())
        rows.append((t, (-pull, 0.0, 1.0)))
    path = scenes.write(context.folder / "tones.csv", rows)
    for kind, name in ((filters.CRITICALLY_DAMPED, "critically damped"), (filters.BUTTERWORTH, "Butterworth")):
        with context.session(scene=path) as session:
            recording, _ = record(session, p.filter_value(2000, kind), 11.5)
            check_tones(session, kind, name, recording)


def check_tones(session: Session, kind: int, name: str, recording: Recording) -> None:
    """Checks the amplitudes in the last eight seconds, which are complete periods of every tone."""
    report, count = session.report, round(8.0 / PERIOD)
    last = recording[-count:]
    if len(last) < count or last[-1][0] - last[0][0] != count - 1:
        report.verdict(False, f"{name}: recording", f"{count} frames without a gap", len(last))
        return
    # With Y at 0 and 1 g along Z, the tangent of X is the filtered acceleration.
    pulls = [math.tan(math.radians(values[0] / 100)) for _, values, _ in last]
    for frequency, size in TONES.items():
        turn = -2j * math.pi * frequency * PERIOD
        amplitude = abs(sum(pull * cmath.exp(turn * n) for n, pull in enumerate(pulls))) * 2 / count
        expected = filters.gain_db(kind, 2.0, frequency)
        slack = 0.05 if expected > -10 else 0.4
        got = 20 * math.log10(max(amplitude, 1e-9) / size)
        report.within(f"{name} 2 Hz: gain at {frequency:g} Hz in dB", expected - slack, expected + slack, got)


def vibration(context: Context) -> None:
    """0.5 g of 20 Hz at 45 deg must not bias the angle: the filter works on the acceleration, not on the angle."""
    up = scenes.one_axis_up(45) if context.product.axes == 1 else scenes.two_axis_up(45, 0)
    for axis, name in enumerate("XYZ"):
        rows = []
        for n in range(4000):
            shaken = list(up)
            shaken[axis] += 0.5 * math.sin(2 * math.pi * 20 * 0.001 * n)
            rows.append((0.001 * n, tuple(shaken)))
        path = scenes.write(context.folder / f"shaken{axis}.csv", rows)
        with context.session(scene=path) as session:
            recording, _ = record(session, p.FILTER.factory, 3.8)
            settled = [values[0] / 100 for _, values, _ in recording[-150:]]
            mean = sum(settled) / max(1, len(settled))
            session.report.within(f"0.5 g of 20 Hz along {name}: mean in deg", 44.99, 45.01, mean)
            far = max((abs(angle - 45) for angle in settled), default=360)
            session.report.within(f"0.5 g of 20 Hz along {name}: worst in deg", 0, 0.0301, far)


def wrap_around(context: Context) -> None:
    """A 1-axis sensor around 0/360 deg: noise is averaged on the circle, a slow turn has no jumps."""
    report, generator = context.report, random.Random(SEED)
    rows = [(0.005 * n, scenes.one_axis_up(generator.gauss(0, 0.3))) for n in range(1400)]
    with context.session(scene=scenes.write(context.folder / "noise.csv", rows)) as session:
        recording, _ = record(session, p.FILTER.factory, 6.8)
        angles = [scenes.circular_difference(values[0] / 100, 0) for _, values, _ in recording[100:]]
        report.within("0.3 deg of noise at 0: worst in deg", 0, 0.25, max((abs(a) for a in angles), default=360))
        report.within("0.3 deg of noise at 0: mean in deg", -0.04, 0.04, sum(angles) / max(1, len(angles)))
        both = min(angles, default=0) < 0 < max(angles, default=0)
        report.verdict(both, "0.3 deg of noise at 0: on both sides", "yes", both)
    path = scenes.write(context.folder / "turn.csv", [(0.002 * n, scenes.one_axis_up(355 + 0.01 * n)) for n in range(1001)])
    for offset in (0, 18000, 35999):
        with context.session(scene=path) as session:
            session.tester.request(session.set_id, b"\x28" + p.u16(offset))
            recording, _ = record(session, p.FILTER.factory, 2.9)
            angles = [values[0] / 100 for _, values, _ in recording]
            steps = [abs(scenes.circular_difference(b, a)) for a, b in zip(angles, angles[1:], strict=False)]
            report.within(f"turn through 0 with offset {offset}: longest step in deg", 0, 0.2, max(steps, default=360))
            end = (365 + offset / 100) % 360
            last = angles[-1] if angles else 180.0
            difference = abs(scenes.circular_difference(last, end))
            report.within(f"turn through 0 with offset {offset}: end, difference in deg", 0, 0.0101, difference)


def moving_offset(context: Context) -> None:
    """A zero offset only shifts the curve; a 2-axis sensor clamps at 90 deg (G7)."""
    rows = scenes.plateaus([(0.0, scenes.two_axis_up(-70, 0)), (1.0, scenes.two_axis_up(70, 0))])
    path = scenes.write(context.folder / "swing.csv", rows)
    curves = {}
    for offset in (0, 4000, -9000):
        with context.session(scene=path) as session:
            session.tester.request(session.set_id, b"\x28" + p.u16(offset))
            recording, _ = record(session, p.FILTER.factory, 2.9)
            curves[offset] = [values[0] for _, values, _ in recording]
    for offset, curve in curves.items():
        ends = [max(-9000, min(9000, pose + offset)) for pose in (-7000, 7000)]
        got = [curve[0], curve[-1]] if curve else []
        good = len(got) == 2 and all(abs(g - e) <= 1 for g, e in zip(got, ends, strict=True))
        context.report.verdict(good, f"swing from -70 to 70 deg with offset {offset}", f"{ends} +-1", got)
        outside = [value for value in curve if not -9000 <= value <= 9000]
        context.report.equal(f"swing with offset {offset}: values outside +-9000", [], outside)


BOTH_GROUPS = (attitudes, vibration)
TWO_AXIS_GROUPS = (step_response, frequency_response, moving_offset)
ONE_AXIS_GROUPS = (wrap_around,)
