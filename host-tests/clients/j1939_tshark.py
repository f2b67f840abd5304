#!/usr/bin/env python3
"""Lets Wireshark's dissector for J1939 read the recorded traces of the IMS360: priority, group and addresses of every frame.

    python j1939_tshark.py --traces ../traces

Needs tshark. Prints one line for each check that fails, then `N passed, N failed`; the exit code is 1 if a check failed.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

# Without data, the dissector has a bug.
FRAME = re.compile(r"\([\d.]+\) can0 ([0-9A-F]{8}#[0-9A-F]+) [TR]")
FIELDS = ("j1939.priority", "j1939.pgn", "j1939.src_addr", "j1939.dst_addr", "_ws.malformed")
# Each of them is in the traces.
GROUPS = {
    0xEA00: "requests", 0xE800: "acknowledgements", 0xEE00: "claims", 0xEC00: "TP.CM", 0xEB00: "TP.DT", 0xEF00: "parameters",
    0xF013: "SSI", 0xF029: "SSI2", 0xF02A: "ARI", 0xF02D: "ACCS", 0xFECA: "DM1", 0xFEDA: "software identification",
}  # fmt: skip


def expected(frame: str) -> tuple[int, int, int, int]:
    """Priority, group, source and destination of a frame (J1939-21, 5.2)."""
    number = int(frame[:8], 16)
    kind, specific = number >> 16 & 0xFF, number >> 8 & 0xFF
    group = (number >> 24 & 1) << 16 | kind << 8 | (specific if kind >= 240 else 0)
    return number >> 26, group, number & 0xFF, specific if kind < 240 else 255


def dissect(frames: list[str]) -> list[list[str]]:
    """The fields of each frame as tshark reads them."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "frames.log")
        log.write_text("".join(f"({1.7e9 + number / 1000:.6f}) can0 {frame}\n" for number, frame in enumerate(frames)))
        command = ["tshark", "-n", "-r", str(log), "-d", "can.subdissector,j1939", "-T", "fields", "-E", "occurrence=f"]
        for field in FIELDS:
            command += ["-e", field]
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [line.split("\t") for line in text.splitlines()]


def main() -> int:
    """Runs the checks; returns the exit code."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--traces", required=True, type=Path)
    paths = sorted(options.parse_args().traces.glob("ims360-j1939-*.log"))
    frames = [frame for path in paths for frame in FRAME.findall(path.read_text())]
    rows = dissect(frames)
    failed = [f"{len(frames)} frames, {len(rows)} read"] if len(frames) != len(rows) or len(frames) < 500 else []
    seen = Counter()
    for frame, (*values, malformed) in zip(frames, rows, strict=False):
        priority, group, source, destination = (int(value, 0) if value else None for value in values)
        seen[group] += 1
        # A frame to all has no destination.
        got = (priority, group, source, 255 if destination is None else destination)
        if got != expected(frame) or malformed:
            failed.append(f"{frame}: expected {expected(frame)}, got {got} {malformed}")
    failed += [f"no {name}" for group, name in GROUPS.items() if not seen[group]]
    for line in failed:
        print(f"FAIL {line}")
    print(f"{len(frames) + len(GROUPS) - len(failed)} passed, {len(failed)} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
