#!/usr/bin/env python3
"""Lets other programs for SAE J1939 talk with the virtual sensor ims360: can-j1939 as the other nodes on its bus.

    pip install -r requirements.txt
    python j1939_peers.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 if a check failed.
"""

import sys

from canopen_cases import runner
from canopen_cases.ims360_objects import IMS360
from j1939_cases import cases_peer

GROUPS = {group.__name__: group for group in cases_peer.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, [GROUPS[name] for name in options.only or GROUPS], IMS360)


if __name__ == "__main__":
    sys.exit(main())
