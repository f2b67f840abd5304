#!/usr/bin/env python3
"""Lets other programs for SAE J1939 talk with the virtual sensor ims360: can-j1939 as the other nodes on its bus, and cantools,
which reads its traffic with the database that the program `descriptors` writes.

    pip install -r requirements.txt
    python j1939_peers.py --virtual-sensor ../../target/release/virtual-sensor [--dbc ims360_j1939.dbc]

Prints one line per check and the count; the exit code is 1 if a check failed.
"""

import argparse
import sys
from pathlib import Path

from canopen_cases import runner
from canopen_cases.ims360_objects import IMS360
from j1939_cases import cases_dbc, cases_peer

GROUPS = {group.__name__: group for group in cases_peer.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    database = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    database.add_argument("--dbc", type=Path)
    found, sys.argv[1:] = database.parse_known_args()
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    groups = [GROUPS[name] for name in options.only or GROUPS]
    if found.dbc:
        groups.append(cases_dbc.Dbc(found.dbc.resolve()))
    return runner.run(options, arguments, groups, IMS360)


if __name__ == "__main__":
    sys.exit(main())
