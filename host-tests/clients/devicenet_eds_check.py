#!/usr/bin/env python3
"""Lets eds-pie read the DeviceNet data sheets that `descriptors` has written.

    pip install -r requirements.txt
    python devicenet_eds_check.py --sheets FOLDER

Prints one line per check; the exit code is 1 if a check failed. host-tests/descriptors/tests/files/devicenet compares the sheets with
the sensors.
"""

import argparse
import logging
import re
import sys
from pathlib import Path

from eds_pie.eds import EDS
from eds_pie.eds_pie import CIP_EDS

# What the library does not know of DeviceNet.
UNKNOWN = re.compile(
    r"Unknown (Section|Entry|Field).*(IO_Info|EnumPar|ParamClass|Params|section\.keyword)"
    r"|Requested Protocol Database \"DeviceNet\" not available"
)
# Connections in [IO_Info].
POLL, COS, CYCLIC = 0x0001, 0x0004, 0x0008
# The types of parameters: UINT is C7h, INT is C3h.
U16, I16 = 0xC7, 0xC3
READ_ONLY = 0x10
# The slopes, offsets, presets and differential offsets: words with a sign on the 080.
ANGLES = {0x72, 0x74, 0x76, 0x77, 0x7A, 0x7C, 0x7E, 0x7F}
READ_ONLY_ATTRIBUTES = {0x72, 0x76, 0x78, 0x7A, 0x7E, 0x80}
ATTRIBUTES = {*range(0x71, 0x79), *range(0x7A, 0x83), 0x84, 0x85, 0x87, 0x88}


class Records(logging.Handler):
    """Keeps the warnings and errors of the library."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.found: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keeps one message."""
        self.found.append(record.getMessage())


class Checks:
    """Prints and counts the results of checks."""

    failed = 0

    def equal(self, name: str, expected: object, got: object) -> None:
        """Checks that two values are equal."""
        self.failed += expected != got
        print("ok    " if expected == got else "FAILED", f"{name}: {got!r}", "" if expected == got else f"instead of {expected!r}")


def parse(data: bytes) -> tuple[EDS, list[str]]:
    """The data sheet, and what the library complains about."""
    records, root = Records(), logging.getLogger()
    handlers, root.handlers = root.handlers, [records]
    try:
        return CIP_EDS(data), records.found
    finally:
        root.handlers = handlers


def values(eds: EDS, section: str, entry: str) -> list[object]:
    """The fields of an entry; numbers in any notation as integers."""
    found = eds.get_entry(section, entry)
    return [number(field.value) for field in found.fields] if found is not None else []


def number(value: object) -> object:
    """A number in any notation as an integer; other values as they are."""
    try:
        return int(value.strip(), 0) if isinstance(value, str) else value
    except ValueError:
        return value


def entries(eds: EDS, section: str, name: str) -> list[str]:
    """The entries of a section with this name and a number."""
    return [key for key in eds.get_section(section).entries if re.fullmatch(name + r"\d+", key)]


def check(checks: Checks, product: str, data: bytes) -> None:
    """A data sheet."""
    eds, complaints = parse(data)
    checks.equal("complaints of eds-pie", [], [one for one in complaints if not UNKNOWN.search(one)])
    try:
        parse(data.replace(b"[Device]", b"[Device", 1))
        found = False
    except Exception:
        found = True
    checks.equal("a syntax error is found", True, found)

    def first(section: str, entry: str) -> object:
        return (values(eds, section, entry) or [None])[0]

    checks.equal("first sections", ["File", "Device"], list(eds.sections)[:2])
    date, time = r"\d\d-\d\d-\d{4}", r"\d\d:\d\d:\d\d"
    for entry, pattern in (
        ("CreateDate", date),
        ("ModDate", date),
        ("CreateTime", time),
        ("ModTime", time),
        ("Revision", r"\d+\.\d+"),
        ("DescText", r".+"),
    ):
        checks.equal(f"[File] {entry} is complete", True, bool(re.fullmatch(pattern, str(first("File", entry)))))
    for entry, expected in (
        ("VendCode", 354),
        ("VendName", "FRABA Posital GmbH"),
        ("ProdType", 0),
        ("ProdTypeStr", "Generic Device"),
        ("ProdCode", int(product[-3:])),
        ("MajRev", 1),
        ("MinRev", 1),
        ("ProdName", f"INCLINOMETER {product[-3:]} degree"),
    ):
        checks.equal(f"[Device] {entry}", expected, first("Device", entry))
    checks.equal("[Device] Catalog is a text", True, bool(first("Device", "Catalog")))
    checks.equal("[Device Classification]", "DeviceNet", first("Device Classification", "Class1"))

    inputs = {int(key[5:]): values(eds, "IO_Info", key) for key in entries(eds, "IO_Info", "Input")}
    checks.equal("[IO_Info] Default", [POLL], values(eds, "IO_Info", "Default"))
    checks.equal("no outputs", [], entries(eds, "IO_Info", "Output"))
    for entry, types in (("PollInfo", POLL | COS | CYCLIC), ("COSInfo", POLL | COS), ("CyclicInfo", POLL | CYCLIC)):
        found = values(eds, "IO_Info", entry)
        checks.equal(f"{entry}: types, default output", [types, 0], [found[0], found[2]])
        checks.equal(f"{entry}: default input", "20 04 24 67 30 03", inputs[found[1]][5])
    found = sorted((fields[5], fields[:3], fields[4]) for fields in inputs.values())
    sizes = ((0x65, 2), (0x66, 2), (0x67, 4))
    expected = [(f"20 04 24 {one:02X} 30 03", [size, 0, POLL | COS | CYCLIC], 6) for one, size in sizes]
    checks.equal("inputs", expected, found)

    params = [values(eds, "Params", key) for key in entries(eds, "Params", "Param")]
    checks.equal("[ParamClass] MaxInst", len(params), first("ParamClass", "MaxInst"))
    checks.equal("[ParamClass] CfgAssembly", 0, first("ParamClass", "CfgAssembly"))
    checks.equal("[ParamClass] Descriptor is a number", True, isinstance(first("ParamClass", "Descriptor"), int))
    checks.equal("fields of the parameters", {21}, {len(fields) for fields in params})
    found = {int(fields[2][-2:], 16): fields for fields in params if fields[2].startswith("20 65 24 01 30 ")}
    checks.equal("attributes of the angle object", ATTRIBUTES, set(found))
    checks.equal("read-only", READ_ONLY_ATTRIBUTES, {one for one, fields in found.items() if fields[3] & READ_ONLY})
    word = I16 if product == "tiltix080" else U16
    checks.equal("types of the angles", {one: word for one in ANGLES}, {one: found[one][4] for one in ANGLES})
    limits = [-8000, 8000] if product == "tiltix080" else [0, 35999]
    settable = ANGLES - READ_ONLY_ATTRIBUTES
    checks.equal("limits of the angles", {one: limits for one in settable}, {one: found[one][9:11] for one in settable})


def main() -> int:
    """Runs the checks; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sheets", type=Path, required=True, metavar="FOLDER", help="the folder with the data sheets")
    folder, checks = parser.parse_args().sheets, Checks()
    for product in ("tiltix080", "tiltix360"):
        check(checks, product, (folder / f"{product}.eds").read_bytes())
    return int(checks.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
