"""Motion of the sensor as CSV rows of specific force, and the expected angles."""

import math
from pathlib import Path

Vector = tuple[float, float, float]


def one_axis_up(angle: float, cross: float = 0.0) -> Vector:
    """The up vector in the coordinates of a 1-axis sensor at `angle` deg with the cross slope `cross` deg (G18)."""
    a, c = math.radians(angle), math.radians(cross)
    return (math.sin(a) * math.cos(c), math.cos(a) * math.cos(c), math.sin(c))


def two_axis_up(x: float, y: float) -> Vector:
    """The up vector in the coordinates of a 2-axis sensor with the perpendicular angles `x` and `y` deg, Z up (G19)."""
    sx, sy = math.sin(math.radians(x)), math.sin(math.radians(y))
    return (-sx, sy, math.sqrt(max(0.0, 1.0 - sx * sx - sy * sy)))


def one_axis_angle(up: Vector) -> float:
    """The angle of a 1-axis sensor, 0 <= angle < 360 deg (G18)."""
    return math.degrees(math.atan2(up[0], up[1])) % 360.0


def two_axis_angles(up: Vector) -> tuple[float, float]:
    """The angles X and Y of a 2-axis sensor in deg: gravity against the planes perpendicular to the axes (G19)."""
    gx, gy, gz = -up[0], up[1], up[2]
    return (
        math.degrees(math.atan2(gx, math.hypot(gy, gz))),
        math.degrees(math.atan2(gy, math.hypot(gx, gz))),
    )


def write(path: Path, rows: list[tuple[float, Vector]]) -> Path:
    """Writes a scene file: time in s since the process started, specific force in g; linear between rows, the last one held."""
    lines = ["t_s,ax_g,ay_g,az_g"]
    lines += [f"{t:.6f},{ax:.9f},{ay:.9f},{az:.9f}" for t, (ax, ay, az) in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def plateaus(steps: list[tuple[float, Vector]]) -> list[tuple[float, Vector]]:
    """Rows that hold each vector from its time on; a change takes 0.1 ms."""
    rows: list[tuple[float, Vector]] = []
    for start, vector in steps:
        if rows:
            rows.append((start, rows[-1][1]))
            start += 0.0001
        rows.append((start, vector))
    return rows


def circular_difference(a: float, b: float) -> float:
    """a - b on the circle of 360 deg, -180..180."""
    return (a - b + 180.0) % 360.0 - 180.0
