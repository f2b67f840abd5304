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

import canopen

NODE = 20


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
        line = [program, "--json", "--rate", "125", *arguments.split()]
        for _ in range(3):
            ended = subprocess.run(line, env=environment, capture_output=True, text=True, check=False, timeout=120)
            # The node answers late if the computer is busy: nobody has answered in time.
            if ended.returncode != 3:
                break
        if ended.returncode != code or note not in ended.stderr:
            failures.append(f"{arguments}: exit code {ended.returncode}, {ended.stdout} {ended.stderr}")
        lines = ended.stdout.splitlines()
        return json.loads(lines[-1]) if lines else {}

    backup = pathlib.Path(folder) / "encoder.toml"
    backup.unlink(missing_ok=True)
    backup.with_suffix(".dcf").unlink(missing_ok=True)
    device = f"--node {NODE} --eds {eds}"

    # The scan finds no node that answers late because the computer is busy.
    for _ in range(5):
        nodes = [(row["protocol"], row["address"], row["serial"]) for row in run("scan --active")]
        if found := ("canopen", str(NODE), 4711) in nodes:
            break
    check("scan", found, True)

    read = run(f"{device} get filter offset position-value manufacturer-device-name")
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
    check("differences", set(run(f"{device} diff {backup}")), {"filter", "offset"})

    written.clear()
    run(f"{device} --yes restore {backup}", note="no command to store")
    check("only differences are restored", sorted(set(written)), [(0x2100, 0, b"\x02"), (0x2101, 0, b"\x00\x00")])
    check("no difference is left", run(f"{device} diff {backup}"), {})

    sample = run(f"{device} watch position-value --every 50 --seconds 2")
    check("a sample", sample["position-value"], 1234)
    # Product tables are not used for a device that names another maker.
    run(f"--node {NODE} get", code=2)

    network.disconnect()
    print("\n".join(failures))
    return bool(failures)


if __name__ == "__main__":
    sys.exit(main())
