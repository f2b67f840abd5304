"""Filter, self-test, temperature, heating and terminating resistor (sections 9.2, 9.4, 9.7 to 9.10)."""

from . import protocol as p
from . import scenes
from .runner import Context

STEP_AT = 3.5  # s after the start of the process
FILTERS = {0: "off", 1: "10 Hz", 2: "5 Hz", 3: "1 Hz", 4: "0.5 Hz"}
# The output of a linear-phase low-pass reaches half of a step after its delay and settles within a few periods of its cut-off.
SETTLED = {0: 0.15, 1: 0.5, 2: 0.9, 3: 3.5, 4: 6.5}


def step(context: Context, setting: int) -> tuple[float, float]:
    """The times in s until half of a step from 0 to 20 deg and until its end."""
    scene = scenes.steps(context.folder / f"step{setting}.csv", [(0.0, 0.0), (STEP_AT, 20.0)])
    with context.session(scene=scene) as session:
        session.put(0x2043, 0, setting)
        session.put(0x1800, 5, 5)
        session.put(0x1800, 2, 254)
        session.put(0x1801, 2, 253)
        session.nmt(p.START)
        started = session.sensor.started
        samples = [(f.at - started - STEP_AT, p.decode(f.data[:2], True)) for f in session.collect(
            started + STEP_AT + SETTLED[setting] + 1.0 - session.now(), p.TPDO0
        )]
        name = FILTERS[setting]
        before = {value for at, value in samples if -0.2 < at < -0.05}
        session.report.equal(f"{name}: exact before the step", {0}, before)
        after = {value for at, value in samples if at > SETTLED[setting]}
        session.report.equal(f"{name}: exact {SETTLED[setting]} s after it", {2000}, after)
        # Times from the first change on, because the start time of the scene is not known exactly.
        begun = next((at for at, value in samples if value != 0), 0.0)
        half = next((at for at, value in samples if value >= 1000), 99.0) - begun
        settled = max((at for at, value in samples if value != 2000), default=begun) - begun
        session.report.within(f"{name}: highest value in 0.01 deg", 2000, 2300, max(value for _, value in samples))
        return half, settled


def filters_fast(context: Context) -> None:
    """Off, 10 Hz and 5 Hz: the step response of each is slower than the one before."""
    order(context, (0, 1, 2))


def filters_slow(context: Context) -> None:
    """5 Hz, 1 Hz and 0.5 Hz: the step response of each is slower than the one before."""
    order(context, (2, 3, 4))


def order(context: Context, settings: tuple[int, ...]) -> None:
    """Measures the step response of these filters; each must be slower than the one before."""
    found = [step(context, setting) for setting in settings]
    for (half, settled), (slower, later), setting in zip(found, found[1:], settings[1:], strict=False):
        context.report.within(f"{FILTERS[setting]}: half of the step later than {half:.3f} s", half, 9.0, slower)
        context.report.within(f"{FILTERS[setting]}: settled later than {settled:.3f} s", settled, 9.0, later)


def vibration(context: Context) -> None:
    """The filter removes a vibration of 20 Hz, which is measured without the filter."""
    rows = [(n / 400, scenes.up(5.0 + 3.0 * (n % 20 < 10), 0.0)) for n in range(400 * 9)]
    scene = scenes.write(context.folder / "vibration.csv", rows)
    with context.session(scene=scene) as session:
        for setting, low, high in ((0, 200, 400), (4, 0, 10)):
            session.put(0x2043, 0, setting)
            session.sleep(2.5 if setting else 0.5)
            values = []
            for _ in range(100):
                values.append(session.get(0x6010))
                session.sleep(0.007)
            session.report.within(f"{FILTERS[setting]}: peak to peak in 0.01 deg", low, high, max(values) - min(values))
            session.nmt(p.ENTER_PRE_OPERATIONAL)


def self_test(context: Context) -> None:
    """4004h: about 2 s, then both axes (J6)."""
    with context.session() as session:
        session.reads("before: the flag", 0x4004, 1, 0)
        session.put(0x4004, 1, 1)
        begun = session.now()
        session.reads("during the test: the flag", 0x4004, 1, 1)
        while session.get(0x4004, 1) == 1 and session.now() < begun + 5:
            session.sleep(0.02)
        session.report.within("duration in s", 1.5, 2.6, session.now() - begun)
        session.reads("the flag is reset", 0x4004, 1, 0)
        session.report.equal("both axes work", 0b110, session.get(0x4004, 2) & 0b110)
        session.report.equal("the angles have not changed", (0, 0), session.settle())
        session.accepted("4004h:01h = 0 starts nothing", 0x4004, 1, 0)


def cell_temperature(context: Context) -> None:
    """4080h in 0.1 degC, updated every 200 ms (J7)."""
    level = scenes.up(0, 0)
    rows = [(0.0, level), (3.0, level), (3.05, level)]
    scene = scenes.write(context.folder / "warm.csv", rows, [-12.5, -12.5, 48.3])
    with context.session(scene=scene) as session:
        session.put(0x2041, 0, 0)
        session.reads("-12.5 degC", 0x4080, 0, -125)
        session.sleep(max(0.0, session.sensor.started + 4.0 - session.now()))
        session.reads("48.3 degC", 0x4080, 0, 483)


def heating(context: Context) -> None:
    """2041h and 4081h: power with a cold cell, none if the heater is off or the cell is hot."""
    level = scenes.up(0, 0)
    for name, degrees, heats in (("cold", -20.0, True), ("hot", 80.0, False)):
        scene = scenes.write(context.folder / f"{name}.csv", [(0.0, level)], [degrees])
        with context.session(scene=scene) as session:
            session.sleep(1.0)
            power = session.get(0x4081)
            wanted = "more than 0 mW" if heats else "0 mW"
            session.report.verdict((power > 0) == heats, f"{name}: heating on", wanted, f"{power} mW")
            session.put(0x2041, 0, 0)
            session.sleep(0.5)
            session.reads(f"{name}: heating off, mW", 0x4081, 0, 0)
            session.put(0x2041, 0, 1)
            session.sleep(1.0)
            power = session.get(0x4081)
            session.report.verdict((power > 0) == heats, f"{name}: on again", wanted, f"{power} mW")


def resistor(context: Context) -> None:
    """2045h: the terminating resistor; it is on at the factory."""
    with context.session(store=context.store()) as session:
        session.accepted("off", 0x2045, 0, 0)
        session.report.equal("the bus still works", 0x4019A, session.get(0x1000))
        session.download(0x1010, 1, p.SAVE)
        session.power_cycle()
        session.reads("kept by a save", 0x2045, 0, 0)
        session.accepted("on", 0x2045, 0, 1)


GROUPS = (filters_fast, filters_slow, vibration, self_test, cell_temperature, heating, resistor)
