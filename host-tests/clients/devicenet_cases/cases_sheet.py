"""The data sheet (EDS): its syntax, its entries, and each parameter compared with the sensor."""

import logging
import re

from eds_pie.eds import EDS
from eds_pie.eds_pie import CIP_EDS

from . import protocol as p
from .runner import Context
from .session import Session

FIELDS = 21
# Type: size, whether it is signed.
TYPES = {
    0xC1: (1, False),
    0xC2: (1, True),
    0xC3: (2, True),
    0xC4: (4, True),
    0xC6: (1, False),
    0xC7: (2, False),
    0xC8: (4, False),
}
ENUMERATED, READ_ONLY = 0x02, 0x10
POLL, COS, CYCLIC = 0x0001, 0x0004, 0x0008
# Fields of DeviceNet that the library does not know.
UNKNOWN = re.compile(
    r"Unknown (Section|Entry|Field).*(IO_Info|EnumPar|ParamClass|Params|section\.keyword)"
    r"|Requested Protocol Database \"DeviceNet\" not available"
)


class Records(logging.Handler):
    """Keeps the warnings and errors of the library."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.found: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keeps one message."""
        self.found.append(record.getMessage())


def parse(data: bytes) -> tuple[EDS, list[str]]:
    """The data sheet, and what the library complains about."""
    records, root = Records(), logging.getLogger()
    handlers, root.handlers = root.handlers, [records]
    try:
        return CIP_EDS(data), records.found
    finally:
        root.handlers = handlers


def sheet(context: Context) -> tuple[bytes, EDS]:
    """The data sheet of the product."""
    data = (context.sheets / f"{context.subject.product}.eds").read_bytes()
    return data, parse(data)[0]


def values(eds: EDS, section: str, entry: str) -> list[object]:
    """The fields of an entry; numbers as integers."""
    found = eds.get_entry(section, entry)
    return [number(field.value) for field in found.fields] if found is not None else []


def number(value: object) -> object:
    """A number in any of the notations as an integer; other values as they are."""
    try:
        return int(value.strip(), 0) if isinstance(value, str) else value
    except ValueError:
        return value


def entries(eds: EDS, section: str, name: str) -> list[str]:
    """The entries of a section with this name and a number."""
    return [key for key in eds.get_section(section).entries if re.fullmatch(name + r"\d+", key)]


def syntax(context: Context) -> None:
    """The library reads the data sheet without an error."""
    report = context.report
    data = (context.sheets / f"{context.subject.product}.eds").read_bytes()
    report.equal("ASCII", True, data.isascii())
    _, complaints = parse(data)
    report.equal("complaints of eds-pie", [], [one for one in complaints if not UNKNOWN.search(one)])
    broken = data.replace(b"[Device]", b"[Device", 1)
    try:
        parse(broken)
        report.verdict(False, "a syntax error", "an exception", "none")
    except Exception as error:
        report.verdict(True, "a syntax error", "an exception", type(error).__name__)


def general(context: Context) -> None:
    """[File], [Device], [Device Classification] and [ParamClass]; the identity as the sensor tells it."""
    _, eds = sheet(context)
    report, get = context.report, lambda section, entry: (values(eds, section, entry) or [None])[0]
    report.equal("first sections", ["File", "Device"], list(eds.sections)[:2])
    for entry, pattern in (
        ("CreateDate", r"\d\d-\d\d-\d{4}"),
        ("ModDate", r"\d\d-\d\d-\d{4}"),
        ("CreateTime", r"\d\d:\d\d:\d\d"),
        ("ModTime", r"\d\d:\d\d:\d\d"),
        ("Revision", r"\d+\.\d+"),
        ("DescText", r".+"),
    ):
        found = str(get("File", entry))
        report.verdict(bool(re.fullmatch(pattern, found)), f"[File] {entry}", pattern, found)
    report.equal("[Device Classification]", "DeviceNet", get("Device Classification", "Class1"))
    with context.session() as session:
        session.connect()
        number = lambda attribute: session.number(p.IDENTITY, 1, attribute)  # noqa: E731
        major, minor = bytes.fromhex(session.get(p.IDENTITY, 1, 4))
        name = bytes.fromhex(session.get(p.IDENTITY, 1, 7))[1:].decode()
        wire = {
            "VendCode": number(1),
            "ProdType": number(2),
            "ProdCode": number(3),
            "MajRev": major,
            "MinRev": minor,
            "ProdName": name,
        }
    for entry, expected in wire.items():
        report.equal(f"[Device] {entry}", expected, get("Device", entry))
    report.equal(
        "[Device] VendName",
        True,
        "FRABA" in str(get("Device", "VendName")).upper() or "POSITAL" in str(get("Device", "VendName")).upper(),
    )
    report.equal("[Device] ProdTypeStr", "Generic Device", get("Device", "ProdTypeStr"))
    report.verdict(bool(get("Device", "Catalog")), "[Device] Catalog", "a text", get("Device", "Catalog"))
    report.equal("[ParamClass] MaxInst", len(entries(eds, "Params", "Param")), get("ParamClass", "MaxInst"))
    report.equal("[ParamClass] CfgAssembly", 0, get("ParamClass", "CfgAssembly"))
    report.verdict(
        isinstance(get("ParamClass", "Descriptor"), int), "[ParamClass] Descriptor", "a number", get("ParamClass", "Descriptor")
    )


def inputs_outputs(context: Context) -> None:
    """[IO_Info]: types that may be open together, and the assemblies with their sizes on the wire."""
    _, eds = sheet(context)
    report, get = context.report, lambda entry: values(eds, "IO_Info", entry)
    report.equal("Default", [POLL], get("Default"))
    inputs = {int(key[5:]): get(key) for key in entries(eds, "IO_Info", "Input")}
    report.equal("no outputs", [], entries(eds, "IO_Info", "Output"))
    for entry, types in (("PollInfo", 0x000D), ("COSInfo", 0x0005), ("CyclicInfo", 0x0009)):
        found = get(entry)
        report.equal(f"{entry}: number of fields", 3, len(found))
        report.equal(f"{entry}: types", types, found[0])
        report.equal(f"{entry}: default input is assembly 103", [0x67], [path(inputs.get(found[1], [None] * 6)[5])[1]])
        report.equal(f"{entry}: no default output", 0, found[2])
    report.equal("assemblies", [0x65, 0x66, 0x67], sorted(path(fields[5])[1] for fields in inputs.values()))
    with context.session() as session:
        session.connect()
        for index, fields in sorted(inputs.items()):
            kind, instance, attribute = path(fields[5])
            size = len(session.get(kind, instance, attribute)) // 2
            report.equal(f"Input{index}: size, bits, types, path size", [size, 0, 0x000D, 6], [*fields[:3], fields[4]])


def path(text: object) -> tuple[int, int, int]:
    """Class, instance and attribute of a path."""
    parts = bytes.fromhex(str(text))
    if len(parts) != 6 or (parts[0], parts[2], parts[4]) != (0x20, 0x24, 0x30):
        return (-1, -1, -1)
    return parts[1], parts[3], parts[5]


def parameters(context: Context) -> None:
    """Each parameter against the wire: size, read-only, default, limits, names of values."""
    _, eds = sheet(context)
    report, found = context.report, {}
    for key in entries(eds, "Params", "Param"):
        fields = values(eds, "Params", key)
        report.equal(f"{key}: number of fields", FIELDS, len(fields))
        report.equal(f"{key}: first field and path size", [0, 6], fields[:2])
        found[path(fields[2])] = (key, fields)
    expected = {(p.ANGLE, 1, entry.id) for entry in p.ATTRIBUTES if entry.id != 1}
    report.equal("attributes of the angle object without a parameter", set(), expected - set(found))
    numbers = sorted(int(key[5:]) for key, _ in found.values())
    report.equal("numbers of the parameters", list(range(1, len(numbers) + 1)), numbers)
    with context.session() as session:
        session.connect()
        # Before any of them is set.
        wire = {address: session.get(*address) for address in found}
        for address, (key, fields) in found.items():
            parameter(session, f"{key} {fields[6]!r}", address, fields, wire[address])
            if address[0] == p.ANGLE and not fields[3] & READ_ONLY:
                settable(session, eds, f"{key} {fields[6]!r}", key, address, fields)


def parameter(session: Session, name: str, address: tuple[int, int, int], fields: list, wire: str) -> None:
    """One parameter and its value on the wire."""
    report = session.report
    descriptor, kind, size = fields[3:6]
    low, high, default = fields[9:12]
    width, signed = TYPES.get(kind, (0, False))
    report.equal(f"{name}: size of its type", width, size)
    report.equal(f"{name}: size on the wire", size, len(wire) // 2)
    entry = p.BY_ID.get(address[2]) if address[0] == p.ANGLE else None
    if entry is not None:
        wanted = (entry.angle and not session.subject.circular) or address[2] in (0x78, 0x80)
        report.equal(f"{name}: signed", wanted, signed)
        report.equal(f"{name}: read-only", entry.range is None, bool(descriptor & READ_ONLY))
        if entry.range:
            report.equal(f"{name}: limits", entry.range(session.subject, 10), (low, high))
    value = p.decode(wire, signed)
    report.within(f"{name}: value on the wire", low, high, value)
    if entry is None or entry.factory is not None:
        report.equal(f"{name}: default", value, default)
    if descriptor & READ_ONLY:
        report.equal(f"{name}: set is refused", "94" + p.NOT_SETTABLE, session.set(*address, wire[:6]))


def settable(session: Session, eds: EDS, name: str, key: str, address: tuple[int, int, int], fields: list) -> None:
    """The limits and the names of values of a parameter that can be set."""
    report = session.report
    descriptor, kind, size = fields[3:6]
    low, high, default = fields[9:12]
    signed = TYPES[kind][1]
    report.equal(f"{name}: default is accepted", "90", session.set(*address, p.encode(default, size)))
    for value in (low, high):
        report.equal(f"{name}: {value} is accepted", "90", session.set(*address, p.encode(value, size)))
        session.set(*address, p.encode(default, size))
    smallest, biggest = (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1) if signed else (0, (1 << 8 * size) - 1)
    for value in (low - 1, high + 1):
        if smallest <= value <= biggest:
            report.equal(f"{name}: {value} is refused", "94" + p.INVALID_VALUE, session.set(*address, p.encode(value, size)))
    if not descriptor & ENUMERATED:
        return
    names = values(eds, "Params", key.replace("Param", "Enum"))
    if names:
        choices = names[::2]
    else:
        names = values(eds, "EnumPar", key)
        choices = list(range(low, low + len(names)))
    report.verdict(bool(choices), f"{name}: names of values", "some", names)
    for value in choices:
        report.equal(f"{name}: {value} has a name and is accepted", "90", session.set(*address, p.encode(value, size)))
    report.equal(
        f"{name}: named values are within the limits", (low, high), (min(choices, default=None), max(choices, default=None))
    )
    session.set(*address, p.encode(default, size))


GROUPS = (syntax, general, inputs_outputs, parameters)
