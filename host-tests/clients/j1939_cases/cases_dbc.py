"""cantools reads the live traffic of the sensor with the project's database `ims360_j1939.dbc`."""

from dataclasses import dataclass
from pathlib import Path

import cantools

from canopen_cases.runner import Context
from gemac import scenes

from .session import Node

# Tilt in deg and offsets in 0.01 deg: pitch and roll.
POSITIONS = ((12.34, -5.0, 0, 0), (0.0, 0.0, 0, 0), (-45.5, 20.25, 0, 0), (63.0, 1.0, 0, 0), (10.0, -10.0, 1000, -2000))
# The steps of SSI2, SSI and ACCS, half of them, and a bit for the angle itself.
FINE, COARSE, ACCELERATION = 0.0001, 0.0021, 0.011


@dataclass(frozen=True)
class Dbc:
    """The group of checks with a database."""

    path: Path

    __name__ = "dbc"

    def __call__(self, context: Context) -> None:
        """Angles, accelerations, figures of merit, latency and codes as cantools decodes them."""
        database = cantools.database.load_file(self.path, strict=True)
        for number, (x, y, long, lateral) in enumerate(POSITIONS):
            settings = {(0x3110, 1): 0, (0x3210, 0): long, (0x3220, 0): lateral}
            with Node(context, settings, scene=f"tilt={x},{y}", name=str(number)) as session:
                session.wait(lambda frame: False, 0.5)
                decoded = {name: decode(session, database, name) for name in ("SSI2", "SSI", "ARI", "ACCS", "DM1")}
            self.angles(context, f"{x}, {y}", decoded, (x + long / 100, y + lateral / 100), scenes.two_axis_up(x, y))
        with Node(context, {(0x3110, 1): 0, (0x3210, 0): 9500}, name="fault") as session:
            session.wait(lambda frame: False, 0.5)
            codes = decode(session, database, "DM1")
            expected = {"AmberWarningLamp": 1, "SuspectParameterNumber": 4976, "FailureModeIdentifier": 0, "OccurrenceCount": 1}
            context.report.equal("S37 DM1 in the database", expected, {name: codes.get(name) for name in expected})
            slope = decode(session, database, "SSI2")
            context.report.equal("S35 degraded", 1, slope["PitchAngleExRangeFigureOfMerit"])
            context.report.within("S30 95 deg", 94.999, 95.001, slope["PitchAngleExRange"])

    def angles(
        self, context: Context, name: str, decoded: dict, slopes: tuple[float, float], up: tuple[float, float, float]
    ) -> None:
        """Checks the decoded values of a position."""
        wanted = [
            ("SSI2", "PitchAngleExRange", slopes[0], FINE),
            ("SSI2", "RollAngleExRange", slopes[1], FINE),
            ("SSI", "PitchAngle", slopes[0], COARSE),
            ("SSI", "RollAngle", slopes[1], COARSE),
            ("SSI", "PitchRate", 0.0, COARSE),
            ("ARI", "PitchRateExRange", 0.0, COARSE),
            ("ACCS", "LateralAcceleration", up[1] * 9.80665, ACCELERATION),
            ("ACCS", "LongitudinalAcceleration", up[0] * 9.80665, ACCELERATION),
            ("ACCS", "VerticalAcceleration", up[2] * 9.80665, ACCELERATION),
            ("SSI2", "RollAndPitchExRangeMeasurementLatency", 0.0, 0.0),
            ("SSI2", "PitchAngleExRangeFigureOfMerit", 0, 0),
            ("SSI2", "RollAngleExRangeCompensation", 3, 0),
            ("DM1", "AmberWarningLamp", 0, 0),
        ]
        for message, signal, value, tolerance in wanted:
            context.report.within(f"{name}: {message}.{signal}", value - tolerance, value + tolerance, decoded[message][signal])


def decode(session: Node, database: cantools.database.Database, name: str) -> dict[str, float]:
    """Requests a message and decodes it as the database names it."""
    message = database.get_message_by_name(name)
    pgn = message.frame_id >> 8 & 0x3FFFF
    session.others.clear()
    session.tx(session.request(pgn))
    frame = session.wait_pgn(pgn)
    return database.decode_message(frame.id & 0x1FFF_FFFF, frame.data, decode_choices=False)
