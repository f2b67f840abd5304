#!/usr/bin/env python3
"""Checks the virtual sensors of GEMAC's products against the manual, over slcan with python-can.

    pip install -r requirements.txt
    python gemac_check.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 if a check failed. The checks are independent of the implementation:
they are written from the sections and tables of the manual and from the decisions G1..G30 in core/src/model/gemac/README.md.
"""

import sys

from gemac import cases_bus, cases_cyclic, cases_measuring, cases_memory, cases_parameters, cases_protocol, runner
from gemac.protocol import PRODUCTS

MODULES = (cases_protocol, cases_parameters, cases_memory, cases_measuring, cases_cyclic, cases_bus)
GROUPS = {group.__name__: group for module in MODULES for group in module.GROUPS}
SLOW_GROUPS = {group.__name__: group for group in cases_cyclic.SLOW_GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options = runner.parser(__doc__.splitlines()[0], GROUPS, SLOW_GROUPS).parse_args()
    every = GROUPS | SLOW_GROUPS
    plan = [(product, every[name]) for product in options.model or PRODUCTS for name in options.only or GROUPS]
    return runner.run(options, plan)


if __name__ == "__main__":
    sys.exit(main())
