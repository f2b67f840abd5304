"""One line per check, and the count at the end."""


class Report:
    """Prints and counts checks."""

    def __init__(self) -> None:
        self.passed = 0
        self.failed = 0
        self.subject = ""

    def verdict(self, good: bool, name: str, expected: object, got: object) -> bool:
        """Prints one check whose judgement is already known."""
        word = "PASS" if good else "FAIL"
        print(f"{word} {self.subject}: {name}: expected {expected}, got {got}", flush=not good)
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

    def close(self) -> int:
        """Prints the closing line; the exit code."""
        print(f"{self.passed} passed, {self.failed} failed", flush=True)
        return 1 if self.failed or not self.passed else 0
