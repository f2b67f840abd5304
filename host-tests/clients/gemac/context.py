"""The argument of every group of checks."""

from dataclasses import dataclass
from pathlib import Path

from .harness import Program
from .protocol import Product
from .report import Report
from .session import Session


@dataclass
class Context:
    """The sensor program, the product under test, an empty folder and the report."""

    report: Report
    program: Program
    product: Product
    folder: Path

    def session(self, **options: object) -> Session:
        """Starts a sensor; see `Session` for the options."""
        return Session(self.report, self.program, self.product, **options)

    def store(self, name: str = "memory") -> Path:
        """The path of a store file that does not exist yet."""
        return self.folder / f"{name}.bin"
