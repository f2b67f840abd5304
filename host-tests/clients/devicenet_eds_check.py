#!/usr/bin/env python3
"""Checks the DeviceNet data sheets of `descriptors` with eds-pie, and compares each parameter with the virtual sensor.

    pip install -r requirements.txt
    python devicenet_eds_check.py --descriptors PATH --virtual-sensor PATH

Prints one line per check and the count; the exit code is 1 if a check failed.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from devicenet_cases import cases_sheet, runner

GROUPS = {group.__name__: group for group in cases_sheet.GROUPS}


def main() -> int:
    """Writes the data sheets and runs the groups; returns the exit code."""
    parser = runner.parser(__doc__.splitlines()[0], GROUPS)
    parser.add_argument("--descriptors", type=Path, required=True, metavar="PATH", help="the program that writes the data sheets")
    options, arguments = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([options.descriptors.resolve(), "--out", folder], check=True, stdout=subprocess.DEVNULL)
        return runner.run(options, arguments, GROUPS, Path(folder))


if __name__ == "__main__":
    sys.exit(main())
