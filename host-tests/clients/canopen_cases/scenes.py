"""Motion of the sensor, and the expected angles (chapter 8)."""

import math
from pathlib import Path

from gemac.scenes import Vector, two_axis_up

up = two_axis_up
ROOM = 25.0


def gravity(vector: Vector) -> Vector:
    """The vector in the definitions of chapter 8; its signs follow from the excavator table."""
    return (-vector[0], vector[1], vector[2])


def perpendicular(g: Vector) -> tuple[float, float]:
    """Gravity against the planes YZ and XZ (section 8.1), in deg."""
    x, y, z = g
    return math.degrees(math.atan2(x, math.hypot(y, z))), math.degrees(math.atan2(y, math.hypot(x, z)))


def taught(g: Vector, at: Vector) -> Vector:
    """`g` in the reference frame that was taught with `at` (section 9.5)."""
    zb = unit(at)
    along = zb[0]
    xb = unit((1.0 - along * zb[0], -along * zb[1], -along * zb[2]))
    yb = (zb[1] * xb[2] - zb[2] * xb[1], zb[2] * xb[0] - zb[0] * xb[2], zb[0] * xb[1] - zb[1] * xb[0])
    return dot(xb, g), dot(yb, g), dot(zb, g)


def unit(v: Vector) -> Vector:
    """The vector of length 1."""
    length = math.sqrt(dot(v, v))
    return (v[0] / length, v[1] / length, v[2] / length)


def dot(a: Vector, b: Vector) -> float:
    """The scalar product."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def write(path: Path, rows: list[tuple[float, Vector]], temperatures: list[float] | None = None) -> Path:
    """Writes a scene file: time in s since the process started, specific force in g, temperature in degC."""
    lines = ["t_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c"]
    for (at, (x, y, z)), temperature in zip(rows, temperatures or [ROOM] * len(rows), strict=True):
        lines.append(f"{at:.6f},{x:.9f},{y:.9f},{z:.9f},0,0,0,{temperature}")
    path.write_text("\n".join(lines) + "\n")
    return path


def steps(path: Path, angles: list[tuple[float, float]]) -> Path:
    """A scene that holds each longitudinal angle from its time on."""
    rows: list[tuple[float, Vector]] = []
    for at, angle in angles:
        if rows:
            rows.append((at, rows[-1][1]))
            at += 0.001
        rows.append((at, up(angle, 0.0)))
    return write(path, rows)
