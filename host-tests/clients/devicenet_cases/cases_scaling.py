"""Inversion, scaling, presets, differential offsets, diagnostic values, and what a change of the resolution does to values."""

from . import protocol as p
from .runner import Context
from .session import Session

# Operating parameter, preset value, preset enable, offset, differential offset, diagnostic value and slope of an axis.
LONG = (0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x72)
LATERAL = (0x7B, 0x7C, 0x7D, 0x7E, 0x7F, 0x80, 0x7A)
INVERT, SCALE = 1, 2


class Axis:
    """The attributes of one axis, and the slope that they must give."""

    def __init__(self, session: Session, ids: tuple[int, ...], measured: int) -> None:
        self.session, self.measured = session, measured
        self.operating, self.preset, self.enable, self.offset, self.differential, self.diagnostic, self.slope = ids
        self.name = "long" if ids is LONG else "lateral"
        self.resolution = 10
        # Operating parameter, offset and differential offset in steps of the resolution.
        self.mode = self.stored_offset = self.added = 0

    def wrap(self, value: int, resolution: int) -> int:
        """A sum as a word (T10)."""
        subject = self.session.subject
        return value % subject.units(resolution) if subject.circular else value

    def physical(self) -> int:
        """The measured angle with inversion, in steps of the resolution."""
        sign = -1 if self.mode & INVERT else 1
        return p.half_away(sign * self.measured * 10, self.resolution)

    def expected(self) -> tuple[int, int]:
        """Slope and diagnostic value."""
        added = self.stored_offset + self.added if self.mode & SCALE else 0
        sign = -1 if self.mode & INVERT else 1
        fine = sign * self.measured + added * self.resolution // 10
        return self.wrap(self.physical() + added, self.resolution), self.wrap(fine, 10)

    def put(self, attribute: int, value: int) -> None:
        """Sets an attribute."""
        self.session.put_angle(attribute, value)

    def set_mode(self, mode: int) -> None:
        """Sets the operating parameter."""
        self.put(self.operating, mode)
        self.mode = mode

    def set_preset(self, value: int) -> None:
        """Sets the preset value and triggers it."""
        self.put(self.preset, value)
        self.put(self.enable, 0)
        self.put(self.enable, 1)
        self.stored_offset = self.wrap(value - self.physical(), self.resolution)

    def set_differential(self, value: int) -> None:
        """Sets the differential offset."""
        self.put(self.differential, value)
        self.added = value

    def check(self, what: str) -> None:
        """Checks the offset, the slope and the diagnostic value."""
        session = self.session
        got = (session.angle(self.offset), session.angle(self.slope), session.angle(self.diagnostic))
        session.report.equal(f"{self.name}, {what}: offset, slope, diagnostic", (self.stored_offset, *self.expected()), got)


def axes(session: Session) -> tuple[Axis, Axis]:
    """Both axes."""
    return Axis(session, LONG, session.subject.long), Axis(session, LATERAL, session.subject.lateral)


def operating(context: Context) -> None:
    """Inversion and scaling on both axes, each independent of the other."""
    with context.session() as session:
        session.connect()
        both = axes(session)
        for resolution in p.RESOLUTIONS:
            session.put_angle(0x71, resolution)
            steps = 10_000 // resolution
            for axis in both:
                axis.resolution = resolution
                axis.set_differential(steps)
            for long_mode in range(4):
                for lateral_mode in range(4):
                    both[0].set_mode(long_mode)
                    both[1].set_mode(lateral_mode)
                    for axis in both:
                        axis.check(f"resolution {resolution}, parameters {long_mode} and {lateral_mode}")
            data = session.get(p.ASSEMBLY, 0x67, 3)
            expected = session.words(both[0].expected()[0], both[1].expected()[0])
            session.report.equal(f"resolution {resolution}: assembly", expected, data)
            for axis in both:
                axis.set_mode(0)
                axis.set_differential(0)


def presets(context: Context) -> None:
    """The preset: 0 -> 1 takes over (T12, T13), at each resolution, with and without inversion and scaling."""
    with context.session() as session:
        session.connect()
        both = axes(session)
        for resolution in p.RESOLUTIONS:
            session.put_angle(0x71, resolution)
            low, high = session.subject.limits(resolution)
            for axis in both:
                axis.resolution = resolution
                axis.stored_offset = session.angle(axis.offset)
                for mode in (0, SCALE, SCALE | INVERT, INVERT, SCALE):
                    axis.set_mode(mode)
                    for preset in (0, high, low, high // 2):
                        axis.set_preset(preset)
                        axis.check(f"resolution {resolution}, parameter {mode}, preset {preset}")
                        if mode & SCALE:
                            session.report.equal(f"{axis.name}: slope is the preset", preset, session.angle(axis.slope))
                axis.set_mode(SCALE)
                axis.set_preset(0)
                axis.set_mode(0)


def triggers(context: Context) -> None:
    """Only the transition from 0 to 1 takes over; what the attribute reads back."""
    with context.session() as session:
        session.connect()
        for axis in axes(session):
            report, name = session.report, axis.name
            axis.set_mode(SCALE)
            axis.put(axis.preset, 500)
            axis.check("preset value alone changes nothing")
            axis.put(axis.enable, 0)
            axis.check("0 -> 0")
            axis.set_preset(500)
            axis.check("0 -> 1")
            report.equal(f"{name}: reads back 1", 1, session.angle(axis.enable))
            axis.put(axis.preset, 700)
            axis.put(axis.enable, 1)
            axis.check("1 -> 1 does nothing")
            axis.put(axis.enable, 0)
            axis.check("1 -> 0 does nothing")
            report.equal(f"{name}: reads back 0", 0, session.angle(axis.enable))
            report.equal(f"{name}: preset enable 2", "94" + p.INVALID_VALUE, session.set_angle(axis.enable, 2))
            axis.check("2 is refused")
            axis.set_preset(700)
            axis.check("0 -> 1 again")
            axis.set_differential(30)
            axis.check("differential offset")
            axis.set_preset(700)
            axis.check("preset again: preset plus differential offset")
            report.equal(f"{name}: 730", 730, session.angle(axis.slope))
            axis.set_mode(SCALE | INVERT)
            axis.check("inversion keeps the offset")
            axis.set_preset(700)
            axis.check("preset with inversion")
            axis.set_mode(0)
            axis.check("scaling off: measured angle")
            axis.set_mode(SCALE)
            axis.check("scaling on again")


def differentials(context: Context) -> None:
    """Differential offsets over the whole range, positive and negative; the 360 model goes on across 360 deg (T10)."""
    with context.session() as session:
        session.connect()
        both = axes(session)
        for resolution in p.RESOLUTIONS:
            session.put_angle(0x71, resolution)
            low, high = session.subject.limits(resolution)
            for axis in both:
                axis.resolution = resolution
                axis.set_mode(SCALE)
                values = {low, low // 2, -1, 1, 0, high // 3, high // 2, high - 1, high}
                turn = session.subject.units(resolution) - axis.physical()
                values |= {turn - 1, turn, turn + 1}
                for value in sorted(value for value in values if low <= value <= high):
                    axis.set_differential(value)
                    axis.check(f"resolution {resolution}, differential offset {value}")
                axis.set_differential(0)


def conversions(context: Context) -> None:
    """A change of the resolution converts and rounds the stored values (T14)."""
    angle_ids = (0x74, 0x77, 0x7C, 0x7F)
    with context.session() as session:
        session.connect()
        values = [0, 1, 4, 5, 6, 14, 15, 49, 50, 1234, 1235, 1244, 1245, 1250, 1251, 7949, 7950, 7999, 8000]
        values += [12345, 32767, 32768, 35949] if session.subject.circular else [-one for one in values[1:]]
        for value in values:
            for path in ((100, 10), (1000, 10), (100, 1000, 100, 10)):
                for attribute in angle_ids:
                    session.put_angle(attribute, value)
                convert(session, angle_ids, value, path)
        if session.subject.circular:
            # 359.96 deg is 0 at 0.1 deg.
            for value, path in ((35996, (100, 10)), (35950, (1000, 10)), (35999, (100, 1000, 10))):
                for attribute in angle_ids:
                    session.put_angle(attribute, value)
                convert(session, angle_ids, value, path)
        for value in (0, 1, 4, 5, 14, 15, 45, 49, 50, 149, 150, 199, 200):
            for path in ((100, 10), (1000, 10), (100, 1000, 10)):
                session.put_angle(0x88, value)
                convert(session, (0x88,), value, path)


def convert(session: Session, attributes: tuple[int, ...], value: int, path: tuple[int, ...]) -> None:
    """Changes the resolution from 10 along a path and checks the stored values."""
    subject, now, before = session.subject, value, 10
    expected, got = [], []
    for resolution in path:
        session.put_angle(0x71, resolution)
        now = p.half_away(now * before, resolution)
        if subject.circular and 0x88 not in attributes:
            now %= subject.units(resolution)
        expected.append(now)
        found = {session.angle(attribute) for attribute in attributes}
        got.append(found.pop() if len(found) == 1 else found)
        before = resolution
    what = "COS delta" if 0x88 in attributes else "presets and differential offsets"
    session.report.equal(f"{what} {value}, resolutions {path}", expected, got)


def offsets_follow(context: Context) -> None:
    """A change of the resolution converts the offset of a preset, and the slope with it."""
    with context.session() as session:
        session.connect()
        for axis in axes(session):
            axis.set_mode(SCALE)
            for preset in (0, 4567):
                axis.set_preset(preset)
                axis.check(f"preset {preset}")
                offset = axis.stored_offset
                for resolution in (100, 1000, 10):
                    session.put_angle(0x71, resolution)
                    offset = axis.wrap(p.half_away(offset * axis.resolution, resolution), resolution)
                    axis.resolution, axis.stored_offset = resolution, offset
                    axis.check(f"preset {preset}, then resolution {resolution}")


def limits_after_conversion(context: Context) -> None:
    """The limits converted to another resolution stay within the new limits."""
    with context.session() as session:
        session.connect()
        for resolution in p.RESOLUTIONS:
            for other in p.RESOLUTIONS:
                for end in (0, 1):
                    session.put_angle(0x71, resolution)
                    session.put_angle(0x74, session.subject.limits(resolution)[end])
                    session.put_angle(0x71, other)
                    low, high = session.subject.limits(other)
                    session.report.within(f"limit {end} of resolution {resolution} at {other}", low, high, session.angle(0x74))


GROUPS = (operating, presets, triggers, differentials, conversions, offsets_follow, limits_after_conversion)
