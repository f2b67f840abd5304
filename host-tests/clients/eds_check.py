"""Checks the data sheet of `descriptors` with other tools: dcfchk (dcf-tools), eds-validate (eds-utils), and python-canopen,
which must read the values of the manual from it.

Usage: eds_check.py --descriptors PATH-OF-THE-PROGRAM
Prints one line for each check that fails, then `N passed, N failed`.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import canopen
from canopen.objectdictionary import datatypes

NODE_ID = 10

# Sub-index 0 of these objects is u32 in the manual (7.6) and UNSIGNED8 in CiA 301. The sensor and its data sheet have u32 (J16 in
# core/src/model/jn2101/README.md). Both tools must report only this, and nothing in a corrected copy.
WIDE = ["1003", "1010", "1011"]

# The number of objects in 7.6 and 7.7.
OBJECTS = 46

# Some objects of the manual: type, access, factory value with node-ID 10.
PRINTED = {
    (0x1000, 0): (datatypes.UNSIGNED32, "const", 0x4019A),
    (0x1003, 50): (datatypes.UNSIGNED32, "ro", 0),
    (0x1005, 0): (datatypes.UNSIGNED32, "rw", 0x80),
    (0x1008, 0): (datatypes.VISIBLE_STRING, "const", "JN2101"),
    (0x100C, 0): (datatypes.UNSIGNED16, "rw", 0),
    (0x1014, 0): (datatypes.UNSIGNED32, "ro", 0x8A),
    (0x1017, 0): (datatypes.UNSIGNED16, "rw", 0),
    (0x1018, 1): (datatypes.UNSIGNED32, "ro", 0x6D666900),
    (0x1029, 1): (datatypes.UNSIGNED8, "rw", 0),
    (0x1200, 1): (datatypes.UNSIGNED32, "ro", 0x60A),
    (0x1200, 2): (datatypes.UNSIGNED32, "ro", 0x58A),
    (0x1800, 0): (datatypes.UNSIGNED8, "ro", 5),
    (0x1800, 1): (datatypes.UNSIGNED32, "ro", 0x18A),
    (0x1800, 5): (datatypes.UNSIGNED16, "rw", 10),
    (0x1801, 1): (datatypes.UNSIGNED32, "ro", 0x28A),
    (0x1A00, 2): (datatypes.UNSIGNED32, "ro", 0x60200010),
    (0x1A01, 1): (datatypes.UNSIGNED32, "ro", 0x61100020),
    (0x1F80, 0): (datatypes.UNSIGNED32, "rw", 0),
    (0x2000, 0): (datatypes.UNSIGNED8, "rw", 10),
    (0x2001, 0): (datatypes.UNSIGNED16, "rw", 125),
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
    check("dcfchk", dcfchk(sheet), (False, [f"DataType should be UNSIGNED8 in [{index}sub0]" for index in WIDE]))
    objections = [f"AUTO-FIXED: subindex 0 for [{index}sub0] was not a UNSIGNED8" for index in WIDE]
    check("eds-validate", eds_validate(sheet), (False, objections))

    text = sheet.read_text()
    for index in WIDE:
        text = re.sub(rf"(\[{index}sub0\]\n(?:.+\n)*?DataType=)0x0007", r"\g<1>0x0005", text)
    corrected = sheet.with_name("corrected.eds")
    corrected.write_text(text)
    check("dcfchk, corrected", dcfchk(corrected), (True, []))
    check("eds-validate, corrected", eds_validate(corrected), (True, []))


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
        imported(sheet)
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
