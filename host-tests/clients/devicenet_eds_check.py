#!/usr/bin/env python3
"""Checks the DeviceNet data sheets that `descriptors` has written with eds-pie, and compares each parameter with the virtual sensor.

    pip install -r requirements.txt
    python devicenet_eds_check.py --sheets FOLDER --virtual-sensor PATH

Prints one line per check and the count; the exit code is 1 if a check failed.
"""

import sys
from pathlib import Path

from devicenet_cases import cases_sheet, runner

GROUPS = {group.__name__: group for group in cases_sheet.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    parser = runner.parser(__doc__.splitlines()[0], GROUPS)
    parser.add_argument("--sheets", type=Path, required=True, metavar="FOLDER", help="the folder with the data sheets")
    options, arguments = parser.parse_known_args()
    return runner.run(options, arguments, GROUPS, options.sheets.resolve())


if __name__ == "__main__":
    sys.exit(main())
