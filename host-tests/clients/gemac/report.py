"""The results of checks."""


class Report:
    """Collects the lines of checks and counts those that passed and failed."""

    def __init__(self, subject: str) -> None:
        self.subject = subject
        self.lines: list[str] = []
        self.passed = 0
        self.failed = 0

    def verdict(self, good: bool, name: str, expected: object, got: object) -> bool:
        """Adds a check with this result."""
        word = "PASS" if good else "FAIL"
        self.lines.append(f"{word} {self.subject}: {name}: expected {expected}, got {got}")
        if good:
            self.passed += 1
        else:
            self.failed += 1
        return good

    def equal(self, name: str, expected: object, got: object) -> bool:
        """Checks that two values are equal."""
        return self.verdict(expected == got, name, expected, got)

    def within(self, name: str, low: float, high: float, got: float) -> bool:
        """Checks that a number lies in a closed range."""
        return self.verdict(low <= got <= high, name, f"{low:.6g}..{high:.6g}", f"{got:.6g}")
