"""Runs groups of checks and prints the count."""

import argparse
import itertools
import tempfile
import traceback
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from gemac import attempts
from gemac.report import Report

from . import protocol as p
from .session import Session

# The modules with a client that knows only the time of the computer.
REAL_TIME_MODULES = (
    "canopen_cases.cases_master",
    "canopen_cases.cases_tools",
    "canopen_cases.ims360_master",
    "j1939_cases.cases_peer",
)


@dataclass(frozen=True)
class Subject:
    """A product under test: its name, its factory node-ID and the objects of its manual."""

    product: str
    node: int
    table: Mapping[tuple[int, int], p.Object]


JN2101 = Subject("jn2101", p.FACTORY_NODE_ID, p.BY_KEY)


@dataclass
class Context:
    """The product, the sensor program with further arguments for it, an empty folder and the report."""

    subject: Subject
    report: Report
    binary: Path
    arguments: tuple[str, ...]
    folder: Path

    def session(self, **options: object) -> Session:
        """Starts a sensor; see `Session` for the options."""
        subject = self.subject
        options = {"node": subject.node, "table": subject.table} | options
        return Session(self.report, self.binary, subject.product, self.arguments, **options)

    def store(self, name: str = "memory") -> Path:
        """The path of a store file that does not exist yet."""
        return self.folder / f"{name}.bin"


Group = Callable[[Context], None]


def parse(description: str, groups: Iterable[str]) -> tuple[argparse.Namespace, tuple[str, ...]]:
    """Parses the command line; returns the options and the arguments for the sensor program."""
    options = argparse.ArgumentParser(
        description=description,
        epilog=f"Other arguments go to the sensor program. Groups: {', '.join(groups)}.",
        allow_abbrev=False,
    )
    options.add_argument("--virtual-sensor", type=Path, required=True, metavar="PATH", help="the program to check")
    options.add_argument(
        "--only", action="append", choices=list(groups), metavar="GROUP", help="only this group (repeatable)"
    )
    options.add_argument("--jobs", type=int, default=2, metavar="N", help="groups at the same time (default: 2)")
    known, others = options.parse_known_args()
    return known, tuple(others)


def run(options: argparse.Namespace, arguments: tuple[str, ...], groups: Iterable[Group], subject: Subject = JN2101) -> int:
    """Runs the groups for a product and prints every check in their order; returns the exit code."""
    passed = failed = 0
    binary = options.virtual_sensor.resolve()
    with ProcessPoolExecutor(options.jobs) as pool:
        for report in pool.map(run_group, itertools.repeat(subject), itertools.repeat(binary), itertools.repeat(arguments), groups):
            for line in report.lines:
                print(line)
            passed += report.passed
            failed += report.failed
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


def run_group(subject: Subject, binary: Path, arguments: tuple[str, ...], group: Group) -> Report:
    """Runs one group."""
    real_time = group.__module__ in REAL_TIME_MODULES
    return attempts.run(lambda: attempt_group(subject, binary, arguments, group), real_time=real_time)


def attempt_group(subject: Subject, binary: Path, arguments: tuple[str, ...], group: Group) -> Report:
    """Runs one group in an empty folder."""
    report = Report(f"{subject.product} {group.__name__}")
    with tempfile.TemporaryDirectory() as folder:
        try:
            group(Context(subject, report, binary, arguments, Path(folder)))
        except Exception as error:  # the other groups must still run
            places = traceback.extract_tb(error.__traceback__)
            place = " in ".join(f"{step.name}:{step.lineno}" for step in reversed(places[-4:]))
            report.verdict(False, "group", "complete run", f"{error!r} at {place}")
    return report
