"""Angles over the bus: polling, sync, zero adjustment, limits (sections 9.2, 9.5.2, 9.9)."""

from . import protocol as p
from . import scenes
from .context import Context
from .session import Session

OFF = p.filter_value(25000, 0)


def scene(first: float, second: float) -> str:
    """A scene at rest: X and Y, or angle and cross slope."""
    return f"tilt={first},{second}"


def angles(context: Context) -> None:
    """Polled angles at rest (9.9.1): unsigned 0..35999 or signed -9000..9000, within one digit."""
    one = [(10.65, 0), (0, 0), (359.99, 0), (180, 20), (270, -30), (90, 44)]
    two = [(12.34, -5.67), (-12.34, 5.67), (60, 20), (-80, 0), (0, 80), (0, -80), (-0.01, 0.01)]
    for pose in one if context.product.axes == 1 else two:
        with context.session(scene=scene(*pose)) as session:
            got = session.settle()
            exact = tuple(round(100 * value) for value in pose[: session.product.axes])
            near = got is not None and all(abs(scenes.circular_difference(g / 100, t / 100)) < 0.0101 for g, t in zip(got, exact))
            session.report.verdict(near, f"tilt={pose}", f"{exact} +-1", got)
            if got:
                session.reply(f"tilt={pose}: complete reply", b"\x00", session.angles_reply(got))


def zero(context: Context) -> None:
    """Written and automatic zero offsets; a 1-axis type wraps, a 2-axis type clamps (9.2, 9.10.6, G7)."""
    pose = (350.5, 10) if context.product.axes == 1 else (60, -20)
    with context.session(scene=scene(*pose), store=context.store()) as session:
        session.accept(p.FILTER, OFF)
        measured = session.settle()
        if measured is None:
            session.report.verdict(False, "angles", "a reply", None)
            return
        for axis in range(session.product.axes):
            check_offsets(session, measured, axis)
            check_automatic(session, measured, axis)
        # SAVE keeps the offset; without SAVE it is lost.
        session.acknowledged("SAVE the offsets", b"\x50SAVE")
        session.power_down()
        session.power_up()
        session.settle()
        session.read(session.product.offset(0), "the automatic offset was saved")
        session.reply("angles after the power cycle are zero", b"\x00", session.angles_reply(measured))


def check_offsets(session: Session, measured: tuple[int, ...], axis: int) -> None:
    """Checks written offsets."""
    parameter = session.product.offset(axis)
    one_axis = session.product.axes == 1
    for offset in (1, 950, 949, 18000, 35999, 0) if one_axis else (1, -1, 2999, 3001, 9000, -9000, 0):
        session.accept(parameter, p.u16(offset))
        session.reply(f"angles with {parameter.name} {offset}", b"\x00", session.angles_reply(measured))


def check_automatic(session: Session, measured: tuple[int, ...], axis: int) -> None:
    """The request without data: the negative measured angle becomes the offset."""
    parameter = session.product.offset(axis)
    for name, before in (("", 0), (" with an older offset", 777)):
        session.accept(parameter, p.u16(before))
        session.values[parameter] = session.automatic_offset(measured[axis])
        session.acknowledged(f"automatic {parameter.name}{name}", bytes([parameter.write]))
        session.read(parameter, f"automatic {parameter.name}{name}: the offset")
        session.reply(f"automatic {parameter.name}{name}: the angles", b"\x00", session.angles_reply(measured))


def limits(context: Context) -> None:
    """SensorError at the limits: 45 deg cross slope on 1 axis, 85 deg on 2 axes (G18, G19, G29)."""
    x, y, both = p.SENSOR_X_ERROR, p.SENSOR_Y_ERROR, p.SENSOR_X_ERROR | p.SENSOR_Y_ERROR
    if context.product.axes == 1:
        error = p.SENSOR_ERROR
        poses = [((angle, cross), 0) for angle in (0, 123) for cross in (0, 44.9, -44.9)]
        poses += [((angle, cross), error) for angle in (0, 300) for cross in (45.1, -45.1, 70)]
        poses += [((angle, 0), 0) for angle in (90, 180, 270)]
    else:
        poses = [((0, 0), 0), ((84.9, 0), 0), ((-84.9, 0), 0), ((0, 84.9), 0), ((0, -84.9), 0)]
        poses += [((85.1, 0), x), ((-85.1, 0), x), ((0, 85.1), y), ((0, -85.1), y), ((45, 44), 0)]
    for pose, bits in poses:
        with context.session(scene=scene(*pose)) as session:
            session.settle()
            frame = session.tester.request(session.set_id, b"\x02")
            session.sensor_bits = bits
            session.report.equal(f"status at {pose}", f"301#02{session.status:02X}", str(frame))
    if context.product.axes == 2:
        check_judged_without_offset(context, x)
        rows = [(0.0, (0.0, 0.0, 3.0)), (1.0, (0.0, 0.0, 3.0))]
        path = scenes.write(context.folder / "clipped.csv", rows)
        with context.session(scene=path) as session:
            session.settle()
            frame = session.tester.request(session.set_id, b"\x02")
            good = frame is not None and frame.data[1] & both != 0
            session.report.verdict(good, "accelerometer at the end of its range", "SensorError", frame)


def check_judged_without_offset(context: Context, error: int) -> None:
    """The measured angle is judged, not the reported one (G24)."""
    with context.session(scene="tilt=80,0") as session:
        session.settle()
        session.accept(p.ZERO_OFFSET_X, p.u16(9000))
        session.acknowledged("80 deg reported as 90 deg: no error", b"\x02")
    with context.session(scene="tilt=87,0") as session:
        session.sensor_bits = error
        measured = session.settle()
        session.accept(p.ZERO_OFFSET_X, p.u16(-8700))
        session.acknowledged("87 deg reported as 0 deg: error", b"\x02")
        session.report.within("87 deg with offset", 8699, 8701, measured[0] if measured else -1)


def live(context: Context) -> None:
    """SensorError is set and cleared with the attitude, without reading the status (9.5.2)."""
    level = scenes.one_axis_up(30) if context.product.axes == 1 else scenes.two_axis_up(0, 0)
    beyond = scenes.one_axis_up(30, 60) if context.product.axes == 1 else scenes.two_axis_up(0, -88)
    error = p.SENSOR_ERROR if context.product.axes == 1 else p.SENSOR_Y_ERROR
    rows = scenes.plateaus([(0.0, level), (0.8, beyond), (1.6, level)])
    path = scenes.write(context.folder / "live.csv", rows)
    with context.session(scene=path) as session:
        started = session.sensor.started
        session.accept(p.FILTER, OFF)
        for at, bits in ((0.6, 0), (1.5, error), (2.3, 0)):
            while session.now() - started < at:
                session.sleep(0.01)
            session.sensor_bits = bits
            frame = session.tester.request(session.set_id, b"\x00")
            got = f"{frame.data[1]:02X}" if frame else None
            session.report.equal(f"status at {at} s", f"{session.status:02X}", got)
        session.acknowledged("status at the end", b"\x02")


def sync(context: Context) -> None:
    """A sync frame without data is answered like a poll, with data it is ignored (9.9.2, G11)."""
    pose = (123.4, 5) if context.product.axes == 1 else (12.3, -4.5)
    with context.session(scene=scene(*pose), store=context.store()) as session:
        measured = session.settle() or ()

        def answered(name: str, value: int | None = None) -> None:
            session.tester.send(session.sync_id)
            expected = session.angles_reply(measured, value)
            frame = session.tester.receive()
            got = str(frame).split("#")[-1]
            session.report.equal(name, expected.hex().upper(), got)

        for _ in range(3):
            answered("sync")
        for size in range(1, 9):
            session.ignored(f"sync with {size} data bytes", session.sync_id, bytes(size))
        session.accept(p.CYCLIC_TIME, p.u16(65535))
        session.accept(p.CYCLIC_MODE, b"\x01")
        answered("sync in cyclic mode: reply with the counter (G4)", 0)
        session.accept(p.CYCLIC_MODE, b"\x00")
        answered("sync after cyclic mode")
        session.accept(p.SYNC_ID, p.u32(p.EXTENDED | 0x1555_5555))
        session.save()
        answered("the old sync id is in force until the restart")
        session.reset()
        answered("29-bit sync id")
        session.ignored("the old sync id", 0x100)
        for size in (1, 8):
            session.ignored(f"29-bit sync with {size} data bytes", session.sync_id, bytes(size))
        session.ignored("remote 29-bit sync", session.sync_id, remote=True, dlc=0)


GROUPS = (angles, zero, limits, live, sync)
