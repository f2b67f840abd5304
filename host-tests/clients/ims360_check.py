#!/usr/bin/env python3
"""Checks the virtual sensor ims360 against SIKO's manual and CiA 301 and 305, with python-can and python-canopen.

    pip install -r requirements.txt
    python ims360_check.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 if a check failed. The checks are independent of the implementation:
they are written from the sections of the manual, from CiA 301 and 305, and from the decisions in core/src/model/ims360/README.md.
"""

import sys

from canopen_cases import (
    ims360_block,
    ims360_dictionary,
    ims360_emergency,
    ims360_lss,
    ims360_master,
    ims360_pdo,
    ims360_store,
    runner,
)
from canopen_cases.ims360_objects import IMS360

MODULES = (
    ims360_dictionary,
    ims360_pdo,
    ims360_store,
    ims360_emergency,
    ims360_lss,
    ims360_block,
    ims360_master,
)
GROUPS = {group.__name__: group for module in MODULES for group in module.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, [GROUPS[name] for name in options.only or GROUPS], IMS360)


if __name__ == "__main__":
    sys.exit(main())
