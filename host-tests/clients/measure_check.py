#!/usr/bin/env python3
"""Checks the measurements of the virtual sensors is1 and is2: it writes scenes and reads the angles over slcan.

    pip install -r requirements.txt
    python measure_check.py --virtual-sensor ../../target/release/virtual-sensor

Attitudes over the full sphere, step and frequency response of both filters, vibration, the turn through 0/360 deg and zero
offsets, each against its formula. Prints one line per check and the count; the exit code is 1 if a check failed.
"""

import sys

from gemac import cases_response, runner

PRODUCTS = {
    "is1": cases_response.BOTH_GROUPS + cases_response.ONE_AXIS_GROUPS,
    "is2": cases_response.BOTH_GROUPS + cases_response.TWO_AXIS_GROUPS,
}
GROUPS = list(dict.fromkeys(group.__name__ for groups in PRODUCTS.values() for group in groups))


def main() -> int:
    """Runs the groups; returns the exit code."""
    options = runner.parser(__doc__.splitlines()[0], GROUPS).parse_args()
    plan = [
        (product, group)
        for product, groups in PRODUCTS.items()
        if product in (options.model or PRODUCTS)
        for group in groups
        if group.__name__ in (options.only or GROUPS)
    ]
    return runner.run(options, plan)


if __name__ == "__main__":
    sys.exit(main())
