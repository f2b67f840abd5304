#!/usr/bin/env python3
"""Lets Wireshark's dissector for J1939 read a whole session of the virtual sensor ims360.

    pip install -r requirements.txt
    python j1939_tshark.py --virtual-sensor ../../target/release/virtual-sensor

Needs tshark. Prints one line per check and the count; the exit code is 1 if a check failed.
"""

import sys

from canopen_cases import runner
from canopen_cases.ims360_objects import IMS360
from j1939_cases import cases_tshark

GROUPS = {group.__name__: group for group in cases_tshark.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, [GROUPS[name] for name in options.only or GROUPS], IMS360)


if __name__ == "__main__":
    sys.exit(main())
