"""Angle definitions, resolution, zero point and teach (chapters 8 and 9, J5, J8, J11)."""

from . import protocol as p
from . import scenes
from .runner import Context
from .session import Session

PERPENDICULAR, EULER, GIMBAL_X, GIMBAL_Y = range(4)

# The excavator of section 8.5: the attitude as the gimbal angles of its row, and both slopes of every definition in deg as
# printed in the table. None: undefined. Where the manual prints rounded degrees, the exact value is computed.
EXCAVATOR = {
    "position 1": ((0, 0), {PERPENDICULAR: (0, 0), EULER: (0, None), GIMBAL_X: (0, 0), GIMBAL_Y: (0, 0)}),
    "position 2": ((0, -30), {PERPENDICULAR: (0, -30), EULER: (30, 0), GIMBAL_X: (0, -30), GIMBAL_Y: (0, -30)}),
    "position 3": (
        (20.7048, -20.7048),
        {PERPENDICULAR: (20.7048, -20.7048), EULER: (30, 45), GIMBAL_X: (20.7048, -22.2077), GIMBAL_Y: (22.2077, -20.7048)},
    ),
    "positions 4 and 5": ((30, 0), {PERPENDICULAR: (30, 0), EULER: (30, 90), GIMBAL_X: (30, 0), GIMBAL_Y: (30, 0)}),
    "position 6": ((0, 30), {PERPENDICULAR: (0, 30), EULER: (30, 180), GIMBAL_X: (0, 30), GIMBAL_Y: (0, 30)}),
}


def near(
    session: Session, name: str, expected: tuple[float | None, ...], unit: float = 0.01, tolerance: float = 0.01
) -> None:
    """Compares both slopes (6110h and 6120h) with angles in deg; rounding may cause an error of one unit of the resolution."""
    got = [value * unit for value in session.settle()]
    good = all(want is None or abs(want - value) <= tolerance + 1e-9 for want, value in zip(expected, got, strict=True))
    session.report.verdict(good, name, expected, tuple(round(value, 4) for value in got))


def excavator(context: Context) -> None:
    """Every row and definition of the table in section 8.5."""
    for position, (tilt, rows) in EXCAVATOR.items():
        with context.session(scene=f"tilt={tilt[0]},{tilt[1]}") as session:
            for definition, expected in rows.items():
                session.put(0x2044, 0, definition)
                near(session, f"{position}, definition {definition}", expected, tolerance=0.015)
                name = f"{position}, definition {definition}: 16 and 32 bit"
                session.report.equal(name, session.slopes(wide=True), session.slopes())


def quadrants(context: Context) -> None:
    """2040h extends only the lateral Euler angle, to +-180 deg or 0 to 360 deg (section 9.6)."""
    for tilt, half, full in (("-30,0", -90, 270), ("30,0", 90, 90), ("-20,0.001", -90, 270), ("0,30", 180, 180)):
        with context.session(scene=f"tilt={tilt}") as session:
            session.put(0x2044, 0, EULER)
            for correction, wanted in ((1, half), (2, full)):
                session.put(0x2040, 0, correction)
                slope = max(abs(float(angle)) for angle in tilt.split(","))
                got = [value / 100 for value in session.settle()]
                error = abs((got[1] - wanted + 180) % 360 - 180) if abs(wanted) == 180 else abs(got[1] - wanted)
                good = abs(got[0] - slope) < 0.015 and error < 0.015
                session.report.verdict(good, f"tilt {tilt}, 2040h = {correction}", (slope, wanted), tuple(got))
            session.put(0x2044, 0, PERPENDICULAR)
            before = session.settle()
            for correction in (0, 2):
                session.put(0x2040, 0, correction)
                session.report.equal(f"tilt {tilt}: perpendicular angles with 2040h = {correction}", before, session.settle())


def shifted_direction(context: Context) -> None:
    """With a zero point, the direction stays within the range of 2040h."""
    for correction, wanted in ((1, 135), (2, 135)):
        with context.session(scene="tilt=30,0", store=context.store(f"direction{correction}")) as session:
            session.put(0x2044, 0, EULER)
            session.put(0x2040, 0, correction)
            session.download(0x1010, 1, p.SAVE)
            session.settle()
            session.put(0x2046, 0, 1)
            near(session, f"2040h = {correction}: zero", (0, 0))
            session.power_cycle(scene="tilt=-20.7048,20.7048")
            near(session, f"2040h = {correction}: turned by 135 deg", (0, wanted), tolerance=0.02)


def resolution(context: Context) -> None:
    """6000h scales both slopes; the 16-bit objects stay at their limits (J5)."""
    for x, y in ((12.345, -5.678), (-44.5, 44.5)):
        with context.session(scene=f"tilt={x},{y}") as session:
            for unit in (1, 10, 100, 1000):
                session.put(0x6000, 0, unit)
                near(session, f"tilt {x},{y} in {unit} x 0.001 deg", (x, y), unit / 1000, unit / 1000)
                limited = tuple(max(-32768, min(32767, value)) for value in session.slopes(wide=True))
                session.report.equal(f"tilt {x},{y} in {unit} x 0.001 deg: 16 bits", limited, session.slopes())
            session.put(0x6000, 0, 1)
            session.nmt(p.START)
            session.settle()
            wide = session.slopes(wide=True)
            session.send(p.SYNC)
            frames = {frame.id: frame.data for frame in session.collect(0.15)}
            limited = b"".join(p.encode(max(-32768, min(32767, value)), 2) for value in wide)
            session.report.equal(f"tilt {x},{y}: TPDO0 is also limited", limited, frames.get(0x18A))
            session.report.equal(f"tilt {x},{y}: TPDO1 is not limited", b"".join(p.encode(v, 4) for v in wide), frames.get(0x28A))


def zero_point(context: Context) -> None:
    """2046h: the position becomes 0, is kept, and can be undone (section 9.3, J11)."""
    with context.session(scene="tilt=10,-7", store=context.store()) as session:
        near(session, "before", (10, -7))
        session.put(0x2046, 0, 0)
        near(session, "2046h = 0: no change", (10, -7))
        session.put(0x2046, 0, 1)
        session.reads("2046h reads 1", 0x2046, 0, 1)
        near(session, "zero", (0, 0))
        session.put(0x2046, 0, 0)
        session.reads("2046h = 0 keeps it", 0x2046, 0, 1)
        near(session, "still zero", (0, 0))
        session.power_cycle(scene="tilt=25,3")
        session.reads("after a power cycle without a save: 2046h", 0x2046, 0, 1)
        near(session, "the offset is subtracted in another position", (15, 10))
        session.put(0x2046, 0, 1)
        near(session, "zero again, from the measured angle", (0, 0))
        session.put(0x2046, 0, 2)
        session.reads("2046h reads 2", 0x2046, 0, 2)
        near(session, "absolute again", (25, 3))
        session.power_cycle()
        near(session, "absolute after a power cycle", (25, 3))


def teach(context: Context) -> None:
    """2042h: a reference frame from the position; it is kept, undone, and refused if it does not exist (section 9.5, J8)."""
    at, then = (0.0, 30.0), [(-12.0, 10.0), (20.0, -5.0), (0.0, 0.0)]
    with context.session(scene=f"tilt={at[0]},{at[1]}", store=context.store()) as session:
        session.settle()
        session.put(0x2042, 0, 1)
        session.reads("2042h reads 1", 0x2042, 0, 1)
        near(session, "taught: level", (0, 0))
        session.put(0x2042, 0, 0)
        session.reads("2042h = 0 keeps it", 0x2042, 0, 1)
        for tilt in then:
            session.power_cycle(scene=f"tilt={tilt[0]},{tilt[1]}")
            g = scenes.taught(scenes.gravity(scenes.up(*tilt)), scenes.gravity(scenes.up(*at)))
            near(session, f"tilt {tilt} in the taught reference frame", scenes.perpendicular(g))
        session.put(0x2042, 0, 2)
        session.reads("2042h reads 2", 0x2042, 0, 2)
        near(session, "absolute again", then[-1])
    skewed = (-13.2, -29.3)
    with context.session(scene=f"tilt={skewed[0]},{skewed[1]}", store=context.store("example")) as session:
        session.settle()
        session.put(0x2042, 0, 1)
        near(session, "the first position in the example of the manual, taught", (0, 0))
        session.power_cycle(scene="tilt=-43.20,-21.50")
        near(session, "the exact second position in the example of the manual", (-30, 0), tolerance=0.02)
    with context.session(scene="tilt=90,0", store=context.store("upright")) as session:
        before = session.settle()
        code = session.abort_code(session.put, 0x2042, 0, 1)
        session.report.verdict(code >> 16 in (0x0609, 0x0800), "X along gravity: refused", "an abort", f"{code:08X}h")
        session.reads("X along gravity: 2042h", 0x2042, 0, 2)
        session.report.equal("X along gravity: nothing changed", before, session.settle())


def settings_together(context: Context) -> None:
    """Teach, zero point, definition and resolution at the same time."""
    at, now = (5.0, 12.0), (-8.0, 21.0)
    with context.session(scene=f"tilt={at[0]},{at[1]}", store=context.store()) as session:
        session.settle()
        session.put(0x2042, 0, 1)
        session.power_cycle(scene=f"tilt={now[0]},{now[1]}")
        session.put(0x6000, 0, 1)
        g = scenes.taught(scenes.gravity(scenes.up(*now)), scenes.gravity(scenes.up(*at)))
        near(session, "taught, 0.001 deg", scenes.perpendicular(g), 0.001, 0.002)
        session.put(0x2046, 0, 1)
        near(session, "taught and zero", (0, 0), 0.001, 0.002)
        session.put(0x2042, 0, 2)
        session.put(0x2046, 0, 2)
        near(session, "both undone", now, 0.001, 0.002)


GROUPS = (excavator, quadrants, shifted_direction, resolution, zero_point, teach, settings_together)
