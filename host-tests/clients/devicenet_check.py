#!/usr/bin/env python3
"""Checks the virtual sensors tiltix080 and tiltix360 against POSITAL's manual and DeviceNet, over slcan with python-can.

    pip install -r requirements.txt
    python devicenet_check.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 if a check failed. The checks are independent of the implementation:
they are written from the manual, from the rules of a DeviceNet Group 2 Only slave, and from the decisions T1..T30 in
core/src/model/tiltix/README.md.
"""

import sys

from devicenet_cases import (
    cases_acknowledge,
    cases_angle,
    cases_connections,
    cases_explicit,
    cases_fragments,
    cases_fuzz,
    cases_io,
    cases_network,
    cases_objects,
    cases_port,
    cases_reset,
    cases_scaling,
    cases_store,
    cases_timeouts,
    cases_vanish,
    runner,
)

# The modules with the longest groups come first.
MODULES = (
    cases_timeouts,
    cases_vanish,
    cases_store,
    cases_reset,
    cases_fragments,
    cases_network,
    cases_port,
    cases_explicit,
    cases_objects,
    cases_angle,
    cases_scaling,
    cases_connections,
    cases_io,
    cases_acknowledge,
    cases_fuzz,
)
GROUPS = {f"{module.__name__.rpartition('cases_')[2]}.{group.__name__}": group for module in MODULES for group in module.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, GROUPS)


if __name__ == "__main__":
    sys.exit(main())
