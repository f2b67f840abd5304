"""Finds the program `virtual-sensor`."""

import os
import shutil
from pathlib import Path

from .connection import BenchError

NAME = "virtual-sensor.exe" if os.name == "nt" else "virtual-sensor"


def find_program() -> str:
    """The program: PLUMBLINE_VIRTUAL_SENSOR, that of the package, one in PATH, or the newest in `target` of the project."""
    if named := os.environ.get("PLUMBLINE_VIRTUAL_SENSOR"):
        if not Path(named).is_file():
            raise BenchError(f"PLUMBLINE_VIRTUAL_SENSOR is {named}, which is not a file")
        return named
    package = Path(__file__).resolve().parent
    if (inside := package / "bin" / NAME).is_file():
        return str(inside)
    if found := shutil.which(NAME):
        return found
    built = [folder / "target" / profile / NAME for folder in package.parents for profile in ("release", "debug")]
    built = [program for program in built if program.is_file()]
    if not built:
        raise BenchError("there is no virtual-sensor: set PLUMBLINE_VIRTUAL_SENSOR, or build it with cargo build --release")
    return str(max(built, key=lambda program: program.stat().st_mtime))
