"""Angles, turn rates and accelerations against formulas in double precision (S30..S33)."""

import random
from collections.abc import Callable, Iterable
from pathlib import Path

from canopen_cases.runner import Context
from gemac import scenes

from . import protocol as p
from . import values as v
from .session import Node, quantized

CYCLIC = {(0x2104, sub): 40 for sub in (1, 2, 3, 4)}
NO_FILTER = {(0x3110, 1): 0}
HOLD = 0.5  # s for each position
FIRST = 1.0  # s until the sensor has its address
SETTLED = 0.3  # s after which the angle is constant

Position = tuple[tuple[float, float, float], tuple[float, float, float]]  # specific force in g, turn rate in deg/s


def scene(path: Path, positions: Iterable[Position]) -> Path:
    """A scene that holds each position."""
    lines, before = ["t_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps"], None
    for number, (force, turn) in enumerate(positions):
        at = FIRST + HOLD * number if number else 0.0
        row = ",".join(f"{one:.9f}" for one in (*force, *turn))
        if before:
            lines.append(f"{at:.4f},{before}")
        lines.append(f"{at + 0.0001:.4f},{row}")
        before = row
    path.write_text("\n".join(lines) + "\n")
    return path


def play(
    context: Context, name: str, positions: list[Position], wanted: Callable[[Position], dict[int, v.Wanted]], settings: dict
) -> None:
    """Plays the positions and checks the data of each group in each of them."""
    path = scene(context.folder / f"{name}.csv", positions)
    with Node(context, CYCLIC | NO_FILTER | settings, scene=path, name=name) as session:
        frames = session.tester.collect(FIRST + HOLD * len(positions) - session.now())
    for number, position in enumerate(positions):
        end = FIRST + HOLD * (number + 1)
        shown = f"{name} {number}, force {tuple(round(one, 4) for one in position[0])}, turn {position[1]}"
        for pgn, step in wanted(position).items():
            found = [one.data for one in frames if p.split(one).pgn == pgn and end - HOLD + SETTLED < one.at < end]
            wrong = [data.hex().upper() for data in found if not step.fits(data, quantized(context))]
            context.report.verdict(len(found) >= 4 and not wrong, f"S30..S33 {pgn}: {shown}", str(step), wrong or len(found))


def at_rest(context: Context, angle: float) -> Path:
    """A scene of a sensor with one axis."""
    return scenes.write(context.folder / f"rest{angle:.0f}.csv", [(0.0, scenes.one_axis_up(angle))])


STILL = (0.0, 0.0, 0.0)
TILTS = [
    (12.34, -5.0), (0.0, 0.0), (-89.5, 0.2), (30.0, 0.0), (0.0, 30.0), (-30.0, 0.0), (0.0, -30.0), (63.99, 0.0), (-63.99, 0.0),
    (64.4, 0.0), (64.6, 0.0), (-64.1, 0.0), (0.0, 64.4), (0.0, 64.6), (0.0, -64.1), (89.9, 0.0),
    (0.0, -89.9), (0.01, -0.01), (45.0, 45.0), (-44.0, 44.0),
]  # fmt: skip


def two_axes(context: Context) -> None:
    """S30..S33: pitch, roll and acceleration of a sensor with two axes."""
    generator = random.Random(61481)
    tilts = list(TILTS)
    while len(tilts) < 44:
        x, y = generator.uniform(-89, 89), generator.uniform(-89, 89)
        if abs(x) + abs(y) < 89 and min(abs(abs(one) - limit) for one in (x, y) for limit in (64.0, 64.51)) > 0.01:
            tilts.append((round(x, 3), round(y, 3)))

    def wanted(position: Position) -> dict[int, v.Wanted]:
        pitch, roll = scenes.two_axis_angles(position[0])
        return {p.SSI2: v.ssi2(pitch, roll), p.SSI: v.ssi(pitch, roll), p.ACCS: v.accs(position[0]), p.ARI: v.ari(0, 0, 0)}

    for part in range(2):
        positions = [(scenes.two_axis_up(*tilt), STILL) for tilt in tilts[part::2]]
        play(context, f"two{part}", positions, wanted, {})


def one_axis(context: Context) -> None:
    """S30: pitch is the angle in -180..180 deg; roll is not available; the pitch rate is that about Z."""
    angles = [0.0, 30.0, 270.0, 90.0, 12.34, 179.9, 180.1, 200.0, 64.4, 64.6, 359.99, 295.9, 296.1, 135.0, 225.0, 1.0]

    def wanted(position: Position) -> dict[int, v.Wanted]:
        angle = scenes.circular_difference(scenes.one_axis_angle(position[0]), 0.0)
        turn = position[1][2]
        return {
            p.SSI2: v.ssi2(angle, None),
            p.SSI: v.ssi(angle, None, turn, tolerance=2),
            p.ARI: v.ari(turn, 0.0, 0.0),
            p.ACCS: v.accs(position[0]),
        }

    turns = [(0.0, 0.0, 0.0), (3.0, -4.0, 20.0), (0.0, 0.0, -15.0), (10.0, 0.0, 0.0)]
    positions = [(scenes.one_axis_up(angle, 10.0 * (number % 3)), turns[number % 4]) for number, angle in enumerate(angles)]
    play(context, "one", positions, wanted, {(0x3120, 1): 0})


def rates(context: Context) -> None:
    """S32, S33: turn rates, each about its axis, with their signs and the ends of their ranges."""
    generator = random.Random(61482)
    level = scenes.two_axis_up(0.0, 0.0)
    turns = [
        (0.0, 0.0, 0.0), (0.0, 20.0, 0.0), (-15.0, 0.0, 0.0), (0.0, 0.0, 20.0), (0.0, -20.0, 0.0), (15.0, 0.0, 0.0), (0.0, 0.0, -15.0),
        (1.0, 2.0, 3.0), (0.0, 63.9, 0.0), (0.0, 64.45, 0.0), (0.0, 64.6, 0.0), (0.0, -63.9, 0.0), (0.0, -64.1, 0.0),
        (200.0, -200.0, 240.0), (-240.0, 100.0, -100.0),
    ]  # fmt: skip
    while len(turns) < 24:
        turns.append(tuple(round(generator.uniform(-60, 60), 2) for _ in range(3)))

    def wanted(position: Position) -> dict[int, v.Wanted]:
        x, y, z = position[1]
        return {p.ARI: v.ari(y, x, z), p.SSI: v.ssi(0.0, 0.0, y, tolerance=2), p.SSI2: v.ssi2(0.0, 0.0)}

    play(context, "turns", [(level, turn) for turn in turns], wanted, {})


def offsets(context: Context) -> None:
    """S30, S34..S36: zero offsets, the ends of the ranges, figures of merit, for pitch and roll each."""
    with Node(context, NO_FILTER, scene="tilt=12.34,-5") as session:
        cases = [
            (0, 0),
            (1, -1),
            (-1234, 500),
            (7765, 0),
            (7767, 0),
            (-10233, 0),
            (-10235, 0),
            (8766, 0),
            (0, 9501),
            (0, -8501),
            (0, 9499),
            (9000, 9000),
        ]
        cases += [
            (23965, 0),
            (23967, 0),
            (-26233, 0),
            (-26235, 0),
            (0, 25699),
            (0, 25701),
            (0, -24499),
            (0, -24501),
            (100000, -100000),
        ]
        cases += [(2**31 - 1, -(2**31)), (0, 0)]
        for long, lateral in cases:
            session.put(0x3210, 0, long)
            session.put(0x3220, 0, lateral)
            pitch, roll = 12.34 + long / 100, -5 + lateral / 100
            states = tuple(int(abs(angle) > 90.001) for angle in (pitch, roll))
            name = f"S30 S34 S35 S36 3210h = {long}, 3220h = {lateral}"
            session.becomes(f"{name}: SSI2", p.SSI2, v.ssi2(pitch, roll, states=states))
            session.becomes(f"{name}: SSI", p.SSI, v.ssi(pitch, roll, states=states))
        session.put(0x3200, 0, 3)
        data = session.ask(p.SSI2)
        pitch = int.from_bytes(data[:3], "little") / 32768 - 250
        session.report.within("S30 after auto zero: pitch in deg", -0.0051, 0.0051, pitch)
    with Node(context, NO_FILTER | {(0x3120, 1): 0}, scene=at_rest(context, 270.0), name="one") as session:
        for offset in (0, 9000, -9000, 18000, 36000, -36001, 12345, 2**31 - 1):
            session.put(0x3210, 0, offset)
            angle = scenes.circular_difference((27000 + offset) % 36000 / 100, 0.0)
            if abs(abs(angle) - 180) > 0.01:
                session.becomes(f"S30 one axis, 3210h = {offset}: SSI2", p.SSI2, v.ssi2(angle, None))
                session.becomes(f"S30 one axis, 3210h = {offset}: SSI", p.SSI, v.ssi(angle, None))
        session.put(0x3220, 0, 20000)
        session.put(0x3210, 0, 0)
        session.becomes("S61 one axis, 3220h has no effect", p.SSI2, v.ssi2(-90.0, None))


def printed(context: Context) -> None:
    """S30..S34: the bytes of the examples."""
    examples = [
        ("tilt=12.34,-5", {}, "852B8300807A33", "1A953C73007DC0"),
        ("tilt=0,0", {}, "00007D00007D33", "007D007D007DC0"),
        ("tilt=-89.5,0.2", {}, "0040509A197D33", "FFFF647D007DC3"),
        ("tilt=0,0", {(0x3210, 0): 10000}, "0000AF00007D37", "FFFF007D007DC3"),
        (at_rest(context, 270.0), {(0x3120, 1): 0}, "000050FFFFFFF3", "FFFFFFFF007DCF"),
        (at_rest(context, 30.0), {(0x3120, 1): 0}, "00008CFFFFFFF3", "98B7FFFF007DCC"),
    ]
    for number, (tilt, settings, slope2, slope) in enumerate(examples):
        with Node(context, settings, scene=tilt, name=str(number)) as session:
            session.wait(lambda frame: False, 0.5)
            for pgn, text in ((p.SSI2, slope2), (p.SSI, slope)):
                data = session.ask(pgn)
                wanted = v.printed(pgn == p.SSI2, bytes.fromhex(f"{text}FF"))
                name = f"S31 S32 {Path(tilt).stem}, {settings}, {pgn}, factory filter"
                session.report.verdict(wanted.fits(data, quantized(context)), name, f"{text}FF", data.hex().upper())
            if tilt == "tilt=0,0":
                session.report.equal("S33 ARI at rest", "007D007D007DC0FF", session.ask(p.ARI).hex().upper())
                session.becomes("S33 ACCS, level", p.ACCS, v.accs((0.0, 0.0, 1.0)))


GROUPS = (two_axes, one_axis, rates, offsets, printed)
