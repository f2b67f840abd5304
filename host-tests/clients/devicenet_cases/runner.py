"""Runs groups of checks for products and prints the count."""

import argparse
import itertools
import tempfile
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from gemac import attempts
from gemac.harness import Program
from gemac.report import Report

from .protocol import SUBJECTS, Subject
from .session import Session

# The modules with a client that knows only the time of the computer.
REAL_TIME_MODULES = ("devicenet_cases.cases_client",)


@dataclass
class Context:
    """The product, the sensor program, an empty folder, the report, and the folder with the data sheets if they are checked."""

    subject: Subject
    report: Report
    program: Program
    folder: Path
    sheets: Path | None = None

    def session(self, **options: object) -> Session:
        """Starts a sensor; see `Session` for the options."""
        return Session(self.report, self.program, self.subject, **options)

    def store(self, name: str = "memory") -> Path:
        """The path of a store file that does not exist yet."""
        return self.folder / f"{name}.bin"


Group = Callable[[Context], None]


def parser(description: str, groups: Iterable[str]) -> argparse.ArgumentParser:
    """The parser of the command line."""
    options = argparse.ArgumentParser(
        description=description,
        epilog=f"Other arguments go to the sensor program. Groups: {', '.join(groups)}.",
        allow_abbrev=False,
    )
    options.add_argument("--virtual-sensor", type=Path, required=True, metavar="PATH", help="the program to check")
    options.add_argument(
        "--images", type=Path, metavar="FOLDER", help="check the firmware images in this folder (named as the products)"
    )
    options.add_argument("--model", action="append", choices=list(SUBJECTS), help="only this product (repeatable)")
    parts = list(dict.fromkeys(name.partition(".")[0] for name in groups))
    options.add_argument(
        "--only", action="append", choices=[*groups, *parts], metavar="GROUP", help="only this group, or its part before the dot (repeatable)"
    )
    options.add_argument("--jobs", type=int, default=2, metavar="N", help="groups at the same time (default: 2)")
    return options


def parse(description: str, groups: Iterable[str]) -> tuple[argparse.Namespace, list[str]]:
    """Parses the command line; returns the options and the arguments for the sensor program."""
    return parser(description, groups).parse_known_args()


def run(options: argparse.Namespace, arguments: list[str], groups: dict[str, Group], sheets: Path | None = None) -> int:
    """Runs the groups for the products and prints every check in their order; returns the exit code."""
    passed = failed = 0
    images = options.images and options.images.resolve()
    program = Program(options.virtual_sensor.resolve(), images, tuple(arguments))
    only = options.only or groups
    names = [name for name in groups if name in only or name.partition(".")[0] in only]
    plan = [(product, groups[name]) for product in options.model or SUBJECTS for name in names]
    with ProcessPoolExecutor(options.jobs) as pool:
        for report in pool.map(run_group, itertools.repeat(program), itertools.repeat(sheets), *zip(*plan, strict=True)):
            for line in report.lines:
                print(line)
            passed += report.passed
            failed += report.failed
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


def run_group(program: Program, sheets: Path | None, product: str, group: Group) -> Report:
    """Runs one group."""
    real_time = group.__module__ in REAL_TIME_MODULES
    return attempts.run(lambda: attempt_group(program, sheets, product, group), real_time=real_time)


def attempt_group(program: Program, sheets: Path | None, product: str, group: Group) -> Report:
    """Runs one group in an empty folder."""
    report = Report(f"{product} {group.__name__}")
    with tempfile.TemporaryDirectory() as folder:
        try:
            group(Context(SUBJECTS[product], report, program, Path(folder), sheets))
        except Exception as error:  # the other groups must still run
            places = traceback.extract_tb(error.__traceback__)
            place = " in ".join(f"{step.name}:{step.lineno}" for step in reversed(places[-4:]))
            report.verdict(False, "group", "complete run", f"{error!r} at {place}")
    return report
