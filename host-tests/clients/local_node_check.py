"""Checks `plumbline` with a node of python-canopen (LocalNode), a CANopen device that is not of this project.

Usage: local_node_check.py PLUMBLINE HOST:PORT EDS FOLDER
The node has node-ID 20 and joins the bus of a virtual sensor at 125 kbit/s. Files are written into the folder. Prints one line for each
check that fails.
"""

import json
import os
import pathlib
import subprocess
import sys
import time

import canopen

NODE = 20
PATIENCE = 120.0  # s; a busy computer answers late


def main():
    program, address, eds, folder = sys.argv[1:]
    environment = {**os.environ, "PLUMBLINE_PORT": f"slcan://{address}", "PLUMBLINE_CONFIG": folder}
    network = canopen.Network()
    network.connect(interface="slcan", channel=f"socket://{address}", bitrate=125000, sleep_after_open=0)
    node = network.create_node(NODE, eds)
    written = []
    node.add_write_callback(lambda index, subindex, data, **_: written.append((index, subindex, bytes(data))))
    # Boot-up, then the heartbeat.
    node.nmt.state = "INITIALISING"
    node.nmt.state = "PRE-OPERATIONAL"
    failures = []

    def check(what, got, expected):
        if got != expected:
            failures.append(f"{what}: {got!r} instead of {expected!r}")

    def run(arguments, code=0, note=""):
        """The documents that the command prints."""
        line = [program, "--json", "--rate", "125", *arguments.split()]
        end = time.monotonic() + PATIENCE
        while True:
            ended = subprocess.run(line, env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE)
            # The node answers late if the computer is busy: nobody has answered in time.
            if ended.returncode != 3 or time.monotonic() > end:
                break
        if ended.returncode != code or note not in ended.stderr:
            failures.append(f"{arguments}: exit code {ended.returncode}, {ended.stdout} {ended.stderr}")
        return [json.loads(line) for line in ended.stdout.splitlines()]

    def last(arguments):
        """The last document that the command prints."""
        return (run(arguments) or [{}])[-1]

    def until(attempt):
        """Repeats until the attempt returns something true, which an attempt with late answers does not; returns it."""
        end = time.monotonic() + PATIENCE
        while not (got := attempt()) and time.monotonic() < end:
            pass
        return got

    backup = pathlib.Path(folder) / "encoder.toml"
    backup.unlink(missing_ok=True)
    backup.with_suffix(".dcf").unlink(missing_ok=True)
    device = f"--node {NODE} --eds {eds}"

    def scanned():
        return ("canopen", str(NODE), 4711) in [(row["protocol"], row["address"], row["serial"]) for row in last("scan --active")]

    check("scan", until(scanned), True)

    read = last(f"{device} get filter offset position-value manufacturer-device-name")
    check("filter", read["filter"]["raw"], 2)
    check("position", read["position-value"]["raw"], 1234)
    check("name", read["manufacturer-device-name"]["value"], "Encoder 13")
    check("nothing is written", written, [])

    run(f"{device} backup {backup}")
    run(f"{device} set filter=6", code=2)
    run(f"{device} set offset=-1001", code=2)
    run(f"{device} set position-value=1", code=2)
    check("nothing is written out of range", written, [])
    run(f"{device} set filter=5 offset=-1000")
    check("two values are written", list(dict.fromkeys(written)), [(0x2100, 0, b"\x05"), (0x2101, 0, b"\x18\xfc")])
    check("differences", set(last(f"{device} diff {backup}")), {"filter", "offset"})

    written.clear()
    run(f"{device} --yes restore {backup}", note="no command to store")
    check("only differences are restored", sorted(set(written)), [(0x2100, 0, b"\x02"), (0x2101, 0, b"\x00\x00")])
    check("no difference is left", last(f"{device} diff {backup}"), {})

    def samples():
        # A sample whose answer was late is null.
        values = {sample["position-value"] for sample in run(f"{device} watch position-value --every 50 --seconds 2")}
        return values - {None}

    check("samples", until(samples), {1234})
    # Product tables are not used for a device that names another maker.
    run(f"--node {NODE} get", code=2)

    network.disconnect()
    print("\n".join(failures))
    return bool(failures)


if __name__ == "__main__":
    sys.exit(main())
