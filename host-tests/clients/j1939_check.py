#!/usr/bin/env python3
"""Checks the virtual sensor ims360 as a node of SAE J1939, over slcan with python-can.

    pip install -r requirements.txt
    python j1939_check.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 if a check failed. The checks are independent of the implementation:
they are written from J1939-21, J1939-73 and J1939-81, and from the decisions S17..S39 in core/src/model/ims360/J1939.md.
"""

import sys

from canopen_cases import runner
from canopen_cases.ims360_objects import IMS360
from j1939_cases import (
    cases_claim,
    cases_commanded,
    cases_cyclic,
    cases_fuzz,
    cases_parameters,
    cases_request,
    cases_switch,
    cases_transport,
    cases_trouble,
    cases_values,
)

MODULES = (
    cases_switch,
    cases_claim,
    cases_commanded,
    cases_request,
    cases_transport,
    cases_values,
    cases_cyclic,
    cases_trouble,
    cases_parameters,
    cases_fuzz,
)
GROUPS = {f"{module.__name__.rpartition('cases_')[2]}.{group.__name__}": group for module in MODULES for group in module.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, [GROUPS[name] for name in options.only or GROUPS], IMS360)


if __name__ == "__main__":
    sys.exit(main())
