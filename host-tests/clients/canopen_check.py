#!/usr/bin/env python3
"""Checks the virtual sensor jn2101 against ifm's manual and CiA 301, over slcan with python-can and python-canopen.

    pip install -r requirements.txt
    python canopen_check.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 if a check failed. The checks are independent of the implementation:
they are written from the sections of the manual, from CiA 301 and from the decisions J1..J33 in core/src/model/jn2101/README.md.
"""

import sys

from canopen_cases import (
    cases_angles,
    cases_dictionary,
    cases_emergency,
    cases_fuzz,
    cases_identity,
    cases_master,
    cases_measuring,
    cases_monitoring,
    cases_network,
    cases_pdo,
    cases_sdo,
    cases_store,
    cases_tools,
    runner,
)

MODULES = (
    cases_network,
    cases_dictionary,
    cases_sdo,
    cases_pdo,
    cases_emergency,
    cases_monitoring,
    cases_store,
    cases_identity,
    cases_angles,
    cases_measuring,
    cases_master,
    cases_tools,
    cases_fuzz,
)
GROUPS = {group.__name__: group for module in MODULES for group in module.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, [GROUPS[name] for name in options.only or GROUPS])


if __name__ == "__main__":
    sys.exit(main())
