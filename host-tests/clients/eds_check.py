"""Checks the data sheet of `descriptors` with other tools: dcfchk and dcfgen (dcf-tools), eds-validate (eds-utils), and
python-canopen, which must read the values of the manual from it.

Usage: eds_check.py --descriptors PATH-OF-THE-PROGRAM
Prints one line for each check that fails, then `N passed, N failed`.
"""

import argparse
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

import canopen
from canopen.objectdictionary import datatypes

from canopen_cases import protocol

NODE_ID = 10

# The number of objects in 7.6 and 7.7.
OBJECTS = 46

# Some objects of the manual: type, access, factory value with node-ID 10.
PRINTED = {
    (0x1000, 0): (datatypes.UNSIGNED32, "const", 0x4019A),
    (0x1003, 0): (datatypes.UNSIGNED8, "rw", None),
    (0x1003, 50): (datatypes.UNSIGNED32, "ro", 0),
    (0x1005, 0): (datatypes.UNSIGNED32, "rw", 0x80),
    (0x1008, 0): (datatypes.VISIBLE_STRING, "const", "JN2101"),
    (0x100C, 0): (datatypes.UNSIGNED16, "rw", 0),
    (0x1010, 0): (datatypes.UNSIGNED8, "ro", 1),
    (0x1011, 0): (datatypes.UNSIGNED8, "ro", 1),
    (0x1011, 1): (datatypes.UNSIGNED32, "rw", None),
    (0x1014, 0): (datatypes.UNSIGNED32, "ro", 0x8A),
    (0x1017, 0): (datatypes.UNSIGNED16, "rw", 0),
    (0x1018, 1): (datatypes.UNSIGNED32, "ro", 0x6D666900),
    (0x1029, 1): (datatypes.UNSIGNED8, "rw", 0),
    (0x1200, 1): (datatypes.UNSIGNED32, "ro", 0x60A),
    (0x1200, 2): (datatypes.UNSIGNED32, "ro", 0x58A),
    (0x1800, 0): (datatypes.UNSIGNED8, "ro", 5),
    (0x1800, 1): (datatypes.UNSIGNED32, "rw", 0x18A),
    (0x1800, 5): (datatypes.UNSIGNED16, "rw", 10),
    (0x1801, 1): (datatypes.UNSIGNED32, "rw", 0x28A),
    (0x1A00, 2): (datatypes.UNSIGNED32, "ro", 0x60200010),
    (0x1A01, 1): (datatypes.UNSIGNED32, "ro", 0x61100020),
    (0x1F80, 0): (datatypes.UNSIGNED32, "rw", 0),
    (0x2000, 0): (datatypes.UNSIGNED8, "rw", 10),
    (0x2001, 0): (datatypes.UNSIGNED16, "rw", 125),
    (0x2042, 0): (datatypes.UNSIGNED8, "rw", None),
    (0x2043, 0): (datatypes.UNSIGNED8, "rw", 2),
    (0x3000, 0): (datatypes.VISIBLE_STRING, "rw", None),
    (0x4080, 0): (datatypes.INTEGER32, "ro", None),
    (0x6000, 0): (datatypes.UNSIGNED16, "rw", 10),
    (0x6010, 0): (datatypes.INTEGER16, "ro", None),
    (0x6120, 0): (datatypes.INTEGER32, "ro", None),
}

counts = {True: 0, False: 0}


def check(what, got, expected):
    counts[got == expected] += 1
    if got != expected:
        print(f"FAIL {what}: expected {expected!r}, got {got!r}")


def run(*tool):
    """Runs a tool with this interpreter; returns whether it succeeded, and its output lines."""
    tool = subprocess.run([sys.executable, *tool], capture_output=True, text=True)
    return tool.returncode == 0, (tool.stdout + tool.stderr).splitlines()


def dcfchk(sheet):
    # A warning has a second line, with the source that it comes from.
    succeeded, lines = run("-m", "dcf.cli", "-n", str(NODE_ID), str(sheet))
    return succeeded, [line.partition("Warning: ")[2] or line for line in lines if not line.startswith("  ")]


def eds_validate(sheet):
    # Run as a module, eds_utils needs the graphical libraries of its editor.
    return run("-c", "from eds_utils.eds_validate import eds_validate; eds_validate()", str(sheet))


def judged(sheet):
    check("dcfchk", dcfchk(sheet), (True, []))
    check("eds-validate", eds_validate(sheet), (True, []))


# A master, and the sensor with all parameters of its TPDOs, for dcfgen. The values are those of `PDO_CONFIGURATION`.
MASTER = """
master:
  node_id: 1
sensor:
  dcf: "{sheet}"
  node_id: {node}
  heartbeat_producer: 100
  tpdo:
    1:
      cob_id: auto
      transmission: 254
      inhibit_time: 50
      event_timer: 20
      mapping: [{{index: 0x6010}}, {{index: 0x6020}}]
    2:
      cob_id: auto
      transmission: 2
      inhibit_time: 100
      event_timer: 1000
      mapping: [{{index: 0x6110}}, {{index: 0x6120}}]
"""


def generated(sheet):
    """What dcfgen generates: the configuration of the master, and the values that it writes to the sensor."""
    folder = sheet.parent
    plan = folder / "master.yml"
    plan.write_text(MASTER.format(sheet=sheet, node=NODE_ID))
    succeeded, lines = run("-m", "dcfgen.cli", "-r", "-d", str(folder), str(plan))
    # The mapping is read-only in the data sheet, because it is fixed. A warning has a second line.
    mapping = re.compile(r"no write access for sub-object 0x1A0[01]/[012]")
    others = [line for line in lines if not line.startswith("  ") and not mapping.search(line)]
    check("dcfgen", (succeeded, others), (True, []))
    check("dcfgen: configuration of the master", dcfchk(folder / "master.dcf")[0], True)
    expected = [(0x1017, 0, 100), *protocol.PDO_CONFIGURATION]
    check("dcfgen: values for the sensor", concise((folder / "sensor.bin").read_bytes()), expected)


def concise(data):
    """The values of a concise DCF (CiA 302): index, sub-index, value."""
    (count,) = struct.unpack_from("<L", data)
    at, found = 4, []
    for _ in range(count):
        index, sub, size = struct.unpack_from("<HBL", data, at)
        found.append((index, sub, int.from_bytes(data[at + 7 : at + 7 + size], "little")))
        at += 7 + size
    return found


def imported(sheet):
    dictionary = canopen.import_od(str(sheet), NODE_ID)
    lists = re.findall(r"^SupportedObjects=(\d+)$", sheet.read_text(), re.MULTILINE)
    check("objects", (len(dictionary), sum(map(int, lists))), (OBJECTS, OBJECTS))
    for (index, sub), expected in PRINTED.items():
        entry = dictionary[index]
        variable = entry if isinstance(entry, canopen.objectdictionary.ODVariable) else entry[sub]
        got = (variable.data_type, variable.access_type, variable.default)
        check(f"{index:04X}h:{sub:02X}", got, expected)
    angles = [0x6010, 0x6020, 0x6110, 0x6120]
    check("mapped objects can be mapped", [dictionary[index].pdo_mappable for index in angles], [True] * 4)

    device = dictionary.device_information
    check("vendor and product", (device.vendor_number, device.product_number, device.revision_number),
          (0x6D666900, 0x01, 0xAA))
    rates = {kbit * 1000 for kbit in (10, 20, 50, 125, 250, 500, 800, 1000)}
    check("bit rates (9.1)", device.allowed_baudrates, rates)
    check("PDOs", (device.nr_of_RXPDO, device.nr_of_TXPDO), (0, 2))
    check("LSS", device.LSS_supported, False)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--descriptors", required=True)
    program = options.parse_args().descriptors
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "--out", folder], check=True, stdout=subprocess.DEVNULL)
        sheet = pathlib.Path(folder, "jn2101.eds")
        judged(sheet)
        generated(sheet)
        imported(sheet)
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
