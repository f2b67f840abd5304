"""What every group of checks is given."""

from dataclasses import dataclass
from pathlib import Path

from .harness import Program
from .protocol import Model
from .report import Report
from .session import Session


@dataclass
class Context:
    """The sensor program, the model under test, an empty folder and the report."""

    report: Report
    program: Program
    model: Model
    folder: Path

    def session(self, **options: object) -> Session:
        """Starts a sensor; see `Session` for the options."""
        return Session(self.report, self.program, self.model, **options)

    def store(self, name: str = "memory") -> Path:
        """A path for a nonvolatile memory that does not exist yet."""
        return self.folder / f"{name}.bin"
