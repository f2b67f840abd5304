#!/usr/bin/env python3
"""Checks what the virtual sensors is1 and is2 measure, from outside: scenes go in, angles come out over slcan.

    pip install -r requirements.txt
    python measure_check.py --virtual-sensor ../../target/release/virtual-sensor

Attitudes over the whole sphere, step and frequency response of both filters, vibration, the turn through 0/360 deg and zero
offsets, each against the closed formula. Prints one line per check and the count; the exit code is 1 when one failed.
"""

import sys

from gemac import cases_response, runner

MODELS = {
    "is1": cases_response.BOTH_GROUPS + cases_response.ONE_AXIS_GROUPS,
    "is2": cases_response.BOTH_GROUPS + cases_response.TWO_AXIS_GROUPS,
}
GROUPS = list(dict.fromkeys(group.__name__ for groups in MODELS.values() for group in groups))


def main() -> int:
    """Runs the groups; the exit code."""
    options = runner.parser(__doc__.splitlines()[0], GROUPS).parse_args()
    plan = [
        (model, group)
        for model, groups in MODELS.items()
        if model in (options.model or MODELS)
        for group in groups
        if group.__name__ in (options.only or GROUPS)
    ]
    return runner.run(options, plan)


if __name__ == "__main__":
    sys.exit(main())
