"""Runs groups of checks for models and prints the count."""

import argparse
import tempfile
import traceback
from collections.abc import Callable, Iterable
from pathlib import Path

from .context import Context
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
    options.add_argument("--model", action="append", choices=list(MODELS), help="only this model (repeatable)")
    options.add_argument(
        "--only", action="append", choices=[*groups, *on_request], metavar="GROUP", help="only this group (repeatable)"
    )
    return options


def run(binary: Path, plan: Iterable[tuple[str, Group]]) -> int:
    """Runs (model, group) pairs; the exit code."""
    report = Report()
    for model, group in plan:
        report.subject = f"{model} {group.__name__}"
        with tempfile.TemporaryDirectory() as folder:
            try:
                group(Context(report, binary.resolve(), MODELS[model], Path(folder)))
            except Exception as error:  # one broken group must not hide the others
                place = traceback.extract_tb(error.__traceback__)[-1]
                report.verdict(False, "group", "to run through", f"{error!r} at {place.name}:{place.lineno}")
    return report.close()
