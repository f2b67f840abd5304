#!/usr/bin/env python3
"""Writes the traces of the sensors from the tables of their manuals: what a tester sends and what the sensor must answer.

    python generate.py            write the *.log files beside this script
    python generate.py --check    exit code 1 if a file differs from the manual

The format is that of `candump -L`, with T for frames of the tester and R for frames of the sensor. The time of a T line
is the start of the frame on the bus, that of an R line the end of the expected frame; time 0 is power-up. Lines that begin with
'#' describe the trace (origin, model, scene, bitrate, tolerance-us, serial) or act between frames (power-cycle, scene,
corrupt newest-image, fail-writes, tolerance-us).

Requests are answered on reception, so the time of a reply is exact: the bits of the request, three bits of intermission, the bits
of the reply, including stuff bits.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "clients"))

import canopen_traces  # noqa: E402
import devicenet_traces  # noqa: E402
import gemac_traces  # noqa: E402
import j1939_traces  # noqa: E402


def main() -> int:
    """Writes or compares the files; returns the exit code."""
    folder = Path(__file__).parent
    differing = []
    sources = (gemac_traces, canopen_traces, devicenet_traces, j1939_traces)
    for trace in [trace for source in sources for trace in source.all_traces()]:
        path = folder / f"{trace.name}.log"
        if "--check" in sys.argv[1:]:
            if not path.exists() or path.read_text() != trace.text():
                differing.append(path.name)
        else:
            path.write_text(trace.text(), newline="\n")
    for name in differing:
        print(f"{name} differs")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
