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

NODE_ID = 10
IMS360_NODE_ID = 50

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
    (0x2000, 0): (datatypes.UNSIGNED8, "rw", None),
    (0x2001, 0): (datatypes.UNSIGNED16, "rw", None),
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


def dcfchk(sheet, node=NODE_ID):
    # A warning has a second line, with the source that it comes from.
    succeeded, lines = run("-m", "dcf.cli", "-n", str(node), str(sheet))
    return succeeded, [line.partition("Warning: ")[2] or line for line in lines if not line.startswith("  ")]


def eds_validate(sheet):
    # Run as a module, eds_utils needs the graphical libraries of its editor.
    return run("-c", "from eds_utils.eds_validate import eds_validate; eds_validate()", str(sheet))


def judged(sheet, node=NODE_ID):
    check(f"{sheet.name}: dcfchk", dcfchk(sheet, node), (True, []))
    check(f"{sheet.name}: eds-validate", eds_validate(sheet), (True, []))


# A master, and the sensor with all parameters of its TPDOs, for dcfgen.
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

# What dcfgen writes for it: index, sub-index, value. core/tests/wire/canopen/configuration.rs writes the same to the sensor.
PDO_CONFIGURATION = [
    (0x1800, 1, 0x8000018A),
    (0x1800, 2, 254),
    (0x1800, 3, 50),
    (0x1800, 5, 20),
    (0x1A00, 0, 0),
    (0x1A00, 1, 0x60100010),
    (0x1A00, 2, 0x60200010),
    (0x1A00, 0, 2),
    (0x1800, 1, 0x18A),
    (0x1801, 1, 0x8000028A),
    (0x1801, 2, 2),
    (0x1801, 3, 100),
    (0x1801, 5, 1000),
    (0x1A01, 0, 0),
    (0x1A01, 1, 0x61100020),
    (0x1A01, 2, 0x61200020),
    (0x1A01, 0, 2),
    (0x1801, 1, 0x28A),
]


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
    expected = [(0x1017, 0, 100), *PDO_CONFIGURATION]
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
        one = variable(dictionary, index, sub)
        got = (one.data_type, one.access_type, one.default)
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


# The IMS360 with all parameters of one of its TPDOs in another mapping, for dcfgen.
IMS360_MASTER = """
master:
  node_id: 1
sensor:
  dcf: "{sheet}"
  node_id: {node}
  tpdo:
    2:
      enabled: true
      cob_id: auto
      transmission: 254
      event_timer: 20
      mapping: [{{index: 0x6120}}, {{index: 0x3000, sub_index: 1}}]
"""

# What dcfgen writes for it. core/tests/wire/canopen/ims360_interrupted.rs makes the same steps.
IMS360_PDO_CONFIGURATION = [
    (0x1801, 5, 20),
    (0x1A01, 0, 0),
    (0x1A01, 1, 0x61200020),
    (0x1A01, 2, 0x30000108),
    (0x1A01, 0, 2),
    (0x1801, 1, 0x2B2),
]

# Some objects of the manual: type, access, factory value with node-ID 50. The tests of `descriptors` compare each with the sensor.
IMS360_PRINTED = {
    (0x1003, 0): (datatypes.UNSIGNED8, "rw", None),
    (0x1014, 0): (datatypes.UNSIGNED32, "rw", 0xB2),
    (0x1803, 1): (datatypes.UNSIGNED32, "rw", 0x800004B2),
    (0x1A01, 8): (datatypes.UNSIGNED32, "rw", 0),
    (0x2001, 0): (datatypes.UNSIGNED32, "rw", None),
    (0x2010, 1): (datatypes.UNSIGNED8, "wo", None),
    (0x3112, 2): (datatypes.INTEGER8, "rw", -3),
    (0x3200, 0): (datatypes.INTEGER8, "wo", None),
    (0x3210, 0): (datatypes.INTEGER32, "rw", 0),
    (0x6110, 0): (datatypes.INTEGER32, "ro", None),
}

# With two axes and with one (7.2.1, 7.2.17, 7.2.40).
TWO_AXES = {(0x1000, 0): 0x0704019A, (0x1A00, 0): 2, (0x1A00, 2): 0x61200020, (0x3120, 1): 1}
ONE_AXIS = {(0x1000, 0): 0x0703019A, (0x1A00, 0): 1, (0x1A00, 2): 0, (0x3120, 1): 0}


def variable(dictionary, index, sub):
    entry = dictionary[index]
    return entry if isinstance(entry, canopen.objectdictionary.ODVariable) else entry[sub]


def ims360(sheet, axes):
    """The data sheet of a variant of the IMS360."""
    judged(sheet, IMS360_NODE_ID)
    dictionary = canopen.import_od(str(sheet), IMS360_NODE_ID)
    for (index, sub), expected in IMS360_PRINTED.items():
        one = variable(dictionary, index, sub)
        got = (one.data_type, one.access_type, one.default)
        check(f"{sheet.name}: {index:04X}h:{sub:02X}", got, expected)
    for (index, sub), expected in axes.items():
        check(f"{sheet.name}: {index:04X}h:{sub:02X}", variable(dictionary, index, sub).default, expected)
    mappable = [variable(dictionary, index, sub).pdo_mappable for index, sub in ((0x6120, 0), (0x3000, 1), (0x1001, 0))]
    check(f"{sheet.name}: mapped objects", mappable, [True, True, False])
    at = canopen.import_od(str(sheet), 60)
    relative = [at[0x1014].default, *(at[0x1800 + number][1].default for number in range(4))]
    check(f"{sheet.name}: $NODEID", relative, [0xBC, 0x1BC, 0x800002BC, 0x800003BC, 0x800004BC])
    device = dictionary.device_information
    identity = (device.vendor_number, device.product_number, device.revision_number)
    check(f"{sheet.name}: vendor and product", identity, (0x195, 0x1869F, 0))
    check(f"{sheet.name}: bit rates", device.allowed_baudrates, {kbit * 1000 for kbit in (125, 250, 500, 800, 1000)})
    check(f"{sheet.name}: PDOs", (device.nr_of_RXPDO, device.nr_of_TXPDO), (0, 4))
    check(f"{sheet.name}: LSS", device.LSS_supported, True)


def ims360_generated(sheet):
    """What dcfgen writes to an IMS360: the steps of 6.1.3 in their order."""
    folder = sheet.parent
    plan = folder / "ims360.yml"
    plan.write_text(IMS360_MASTER.format(sheet=sheet, node=IMS360_NODE_ID))
    succeeded, lines = run("-m", "dcfgen.cli", "-r", "-d", str(folder), str(plan))
    check("ims360: dcfgen", (succeeded, [line for line in lines if not line.startswith("  ")]), (True, []))
    written = concise((folder / "sensor.bin").read_bytes())
    check("ims360: values for the sensor", written, IMS360_PDO_CONFIGURATION)


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
        ims360(pathlib.Path(folder, "ims360.eds"), TWO_AXES)
        ims360(pathlib.Path(folder, "ims360_1axis.eds"), ONE_AXIS)
        ims360_generated(pathlib.Path(folder, "ims360.eds"))
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
