"""Puts the program `virtual-sensor` into the package: that of PLUMBLINE_VIRTUAL_SENSOR, or the newest one in `target` of the project in whose
folder this file is. Without a program the package finds one when it is used; see `program.py`."""

import os
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

NAME = "virtual-sensor.exe" if os.name == "nt" else "virtual-sensor"


def program() -> Path | None:
    if named := os.environ.get("PLUMBLINE_VIRTUAL_SENSOR"):
        return Path(named)
    project = Path(__file__).resolve().parent / ".." / ".."
    target = Path(os.environ.get("CARGO_TARGET_DIR", project / "target"))
    built = [target / profile / NAME for profile in ("release", "debug")]
    built = [path for path in built if (project / "Cargo.toml").is_file() and path.is_file()]
    return max(built, key=lambda path: path.stat().st_mtime, default=None)


class WithProgram(build_py):
    def run(self) -> None:
        super().run()
        # An installation with -e uses the folder itself.
        if not self.editable_mode and (found := program()):
            folder = Path(self.build_lib, "plumbline_bench", "bin")
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy2(found, folder / NAME)


setup(cmdclass={"build_py": WithProgram})
