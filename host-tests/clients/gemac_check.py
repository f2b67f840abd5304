#!/usr/bin/env python3
"""Checks the virtual sensors is1, is2, is1d and is2d against GEMAC's manual, from outside: over slcan with python-can.

    pip install -r requirements.txt
    python gemac_check.py --virtual-sensor ../../target/release/virtual-sensor

Prints one line per check and the count; the exit code is 1 when one failed. Nothing here knows how the sensor is made: what is
expected comes from the manual's sections and tables, and G1..G30 name the decisions where the manual is open.
"""

import argparse
import sys
import tempfile
import traceback
from pathlib import Path

from gemac import cases_bus, cases_cyclic, cases_measuring, cases_memory, cases_parameters, cases_protocol
from gemac.context import Context
from gemac.protocol import MODELS
from gemac.report import Report

MODULES = (cases_protocol, cases_parameters, cases_memory, cases_measuring, cases_cyclic, cases_bus)
GROUPS = {group.__name__: group for module in MODULES for group in module.GROUPS}
SLOW_GROUPS = {group.__name__: group for group in cases_cyclic.SLOW_GROUPS}


def arguments() -> argparse.Namespace:
    """The command line."""
    listing = ", ".join(GROUPS) + "; only on request: " + ", ".join(SLOW_GROUPS)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog=f"Groups: {listing}.")
    parser.add_argument("--virtual-sensor", type=Path, required=True, metavar="PATH", help="the program to check")
    parser.add_argument("--model", action="append", choices=list(MODELS), help="only this model (repeatable)")
    parser.add_argument(
        "--only", action="append", choices=[*GROUPS, *SLOW_GROUPS], metavar="GROUP", help="only this group (repeatable)"
    )
    return parser.parse_args()


def main() -> int:
    """Runs the groups; the exit code."""
    options = arguments()
    report = Report()
    binary = options.virtual_sensor.resolve()
    for model in options.model or MODELS:
        for name in options.only or GROUPS:
            report.subject = f"{model} {name}"
            with tempfile.TemporaryDirectory() as folder:
                try:
                    (GROUPS | SLOW_GROUPS)[name](Context(report, binary, MODELS[model], Path(folder)))
                except Exception as error:  # one broken group must not hide the others
                    place = traceback.extract_tb(error.__traceback__)[-1]
                    report.verdict(False, "group", "to run through", f"{error!r} at {place.name}:{place.lineno}")
    return report.close()


if __name__ == "__main__":
    sys.exit(main())
