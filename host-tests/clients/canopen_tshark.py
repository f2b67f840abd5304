#!/usr/bin/env python3
"""Decodes the recorded traces of the JN2101 with tshark as CANopen.

    python canopen_tshark.py --traces ../traces

Prints one line for each check that fails and the count; the exit code is 1 if a check failed.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

FRAME = re.compile(r"\(\d+\.\d+\) can0 ([0-9A-F]{3})#([0-9A-F]*) [TR]")
# NMT, SYNC and EMCY, both TPDOs, SDO both ways, error control.
FUNCTIONS = {0x0, 0x1, 0x3, 0x5, 0xB, 0xC, 0xE}

counts = {True: 0, False: 0}


def check(what, got, expected):
    """Compares, prints and counts."""
    counts[got == expected] += 1
    if got != expected:
        print(f"FAILED {what}: expected {expected!r}, got {got!r}")


def tshark(log, *arguments):
    """The output of tshark."""
    command = ["tshark", "-r", str(log), "-d", "can.subdissector,canopen", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def main():
    """Decodes the traces of the product but those with frames that are wrong on purpose."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--traces", type=Path, required=True)
    traces = parser.parse_args().traces
    lines = []
    for name in ("boot-up", "read-all", "write-all", "emcy", "store", "node-id"):
        lines += FRAME.findall((traces / f"jn2101-{name}.log").read_text())
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder, "traces.log")
        # One trace after the other: a frame each millisecond.
        log.write_text("".join(f"({at / 1000:.6f}) can0 {identifier}#{data}\n" for at, (identifier, data) in enumerate(lines)))
        frames = [frame["_source"]["layers"] for frame in json.loads(tshark(log, "-T", "json"))]
        check("frames", len(frames), len(lines))
        check("decoded as CANopen", sum("canopen" in layers for layers in frames), len(lines))
        check("malformed", tshark(log, "-Y", "_ws.malformed"), "")
        codes = tshark(log, "-T", "fields", "-e", "canopen.function_code").split()
        check("functions", FUNCTIONS & {int(code, 0) for code in codes}, FUNCTIONS)
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
