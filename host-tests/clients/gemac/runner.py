"""Runs groups of checks for models and prints the count."""

import argparse
import itertools
import tempfile
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from .context import Context
from .harness import Program
from .protocol import MODELS
from .report import Report

Group = Callable[[Context], None]


def parser(description: str, groups: Iterable[str], on_request: Iterable[str] = ()) -> argparse.ArgumentParser:
    """The command line that the checks share."""
    listing = ", ".join(groups)
    if slow := ", ".join(on_request):
        listing += f"; only on request: {slow}"
    options = argparse.ArgumentParser(description=description, epilog=f"Groups: {listing}.")
    options.add_argument("--virtual-sensor", type=Path, required=True, metavar="PATH", help="the program to check")
    options.add_argument(
        "--images", type=Path, metavar="FOLDER", help="check these firmware images (named as the models) on it, not the models for the PC"
    )
    options.add_argument("--model", action="append", choices=list(MODELS), help="only this model (repeatable)")
    options.add_argument(
        "--only", action="append", choices=[*groups, *on_request], metavar="GROUP", help="only this group (repeatable)"
    )
    options.add_argument("--jobs", type=int, default=2, metavar="N", help="groups at the same time (default: 2)")
    return options


def run(options: argparse.Namespace, plan: list[tuple[str, Group]]) -> int:
    """Runs (model, group) pairs and prints every check in the order of the plan; the exit code."""
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


# Groups that measure in real time: a machine that is busy with something else can spoil one attempt, but not every one.
REAL_TIME_MODULES = ("gemac.cases_cyclic", "gemac.cases_response")
ATTEMPTS = 4


def run_group(program: Program, model: str, group: Group) -> Report:
    """Runs one group; one that measures in real time once more when it fails, but not for ever."""
    attempts = ATTEMPTS if group.__module__ in REAL_TIME_MODULES else 1
    for attempt in range(1, attempts + 1):
        report = attempt_group(program, model, group)
        if not report.failed or attempt == attempts:
            break
        # Told, so that a check which often needs a second attempt is noticed.
        print(f"attempt {attempt} of {model} {group.__name__} failed:", *(x for x in report.lines if "FAIL" in x), sep="\n  ")
    return report


def attempt_group(program: Program, model: str, group: Group) -> Report:
    """Runs one group in an empty folder."""
    report = Report(f"{model} {group.__name__}")
    with tempfile.TemporaryDirectory() as folder:
        try:
            group(Context(report, program, MODELS[model], Path(folder)))
        except Exception as error:  # one broken group must not hide the others
            place = traceback.extract_tb(error.__traceback__)[-1]
            report.verdict(False, "group", "to run through", f"{error!r} at {place.name}:{place.lineno}")
    return report
