"""Runs groups of checks for products and prints the count."""

import argparse
import itertools
import tempfile
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from .context import Context
from .harness import Program
from .protocol import PRODUCTS
from .report import Report

Group = Callable[[Context], None]


def parser(description: str, groups: Iterable[str], on_request: Iterable[str] = ()) -> argparse.ArgumentParser:
    """The parser of the command line."""
    listing = ", ".join(groups)
    if slow := ", ".join(on_request):
        listing += f"; only on request: {slow}"
    options = argparse.ArgumentParser(description=description, epilog=f"Groups: {listing}.")
    options.add_argument("--virtual-sensor", type=Path, required=True, metavar="PATH", help="the program to check")
    options.add_argument(
        "--images", type=Path, metavar="FOLDER", help="check the firmware images in this folder (named as the products)"
    )
    options.add_argument("--model", action="append", choices=list(PRODUCTS), help="only this product (repeatable)")
    options.add_argument(
        "--only", action="append", choices=[*groups, *on_request], metavar="GROUP", help="only this group (repeatable)"
    )
    options.add_argument("--jobs", type=int, default=2, metavar="N", help="groups at the same time (default: 2)")
    return options


def run(options: argparse.Namespace, plan: list[tuple[str, Group]]) -> int:
    """Runs (product, group) pairs and prints every check in the order of the plan; returns the exit code."""
    passed = failed = 0
    images = options.images and options.images.resolve()
    program = Program(options.virtual_sensor.resolve(), images)
    with ProcessPoolExecutor(options.jobs) as pool:
        for report in pool.map(run_group, itertools.repeat(program), *zip(*plan, strict=True)):
            for line in report.lines:
                print(line)
            passed += report.passed
            failed += report.failed
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


def run_group(program: Program, product: str, group: Group) -> Report:
    """Runs one group in an empty folder."""
    report = Report(f"{product} {group.__name__}")
    with tempfile.TemporaryDirectory() as folder:
        try:
            group(Context(report, program, PRODUCTS[product], Path(folder)))
        except Exception as error:  # the other groups must still run
            place = traceback.extract_tb(error.__traceback__)[-1]
            report.verdict(False, "group", "complete run", f"{error!r} at {place.name}:{place.lineno}")
    return report
