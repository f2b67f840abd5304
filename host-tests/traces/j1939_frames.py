"""A trace in J1939: identifiers, NAME, scales and packets of SAE J1939-21, -71, -73 and -81."""

from collections.abc import Callable

from canopen_traces import IMS360, Trace
from wire import EXTENDED

SENSOR, TESTER, EVERYONE, NOBODY = 0x80, 0x21, 0xFF, 0xFE

# Parameter groups. Those below F000h have a destination.
REQUEST, ACKNOWLEDGEMENT, CLAIM, CONTROL, DATA, PROPRIETARY = 0xEA00, 0xE800, 0xEE00, 0xEC00, 0xEB00, 0xEF00
SSI2, SSI, ARI, ACCS = 0xF029, 0xF013, 0xF02A, 0xF02D
DM1, COMMANDED, SOFTWARE, COMPONENT, ECU = 0xFECA, 0xFED8, 0xFEDA, 0xFEEB, 0xFDC5

PRIORITY = {CONTROL: 7, DATA: 7, SSI2: 3, SSI: 3, ARI: 3, ACCS: 3}

CLAIM_MS, BAM_MS, DM1_MS, RESTART_MS = 250, 60, 1000, 99

NO_CODES = "00FF00000000FFFF"
# The lowest and the highest NAME.
LOWEST, HIGHEST = "00" * 8, "FF" * 8

ORIGIN = "written from {}, and the decisions S17 to S39 of the IMS360"
SAVE = "2310100173617665", "6010100100000000"


def identifier(group: int, source: int = SENSOR, destination: int = EVERYONE, priority: int | None = None) -> int:
    """The 29-bit identifier of a group, with its usual priority unless another is given."""
    number = group if group >= 0xF000 else group | destination
    return EXTENDED | (PRIORITY.get(group, 6) if priority is None else priority) << 26 | number << 8 | source


def little(number: int, size: int) -> str:
    """A number in bytes, the least significant first."""
    return number.to_bytes(size, "little").hex().upper()


def name(serial: int, capable: int = 1) -> str:
    """The NAME of J1939-81: manufacturer code 2047, function 145, the other fields 0."""
    return little(capable << 63 | 145 << 40 | 2047 << 21 | serial & 0x1FFFFF, 8)


class J1939Trace(Trace):
    """A trace that begins in CANopen and goes on in J1939."""

    def __init__(self, trace: str, sources: str, *, scene: str = "12.34,-5.67", writes: tuple[str, ...] = ()) -> None:
        super().__init__(f"ims360-j1939-{trace}", ORIGIN.format(sources), scene=scene, node=IMS360)
        self.address = SENSOR
        self.name_data = name(1, 0 if "2F06210100000000" in writes else 1)
        self.note("Over CANopen: J1939, save, reset node.")
        self.expect(0x700 + IMS360, "00")
        self.wait(100)
        for request in (*writes, "2F00310101000000"):
            self.ask(request, f"60{request[2:8]}00000000")
        self.saved(lambda: self.ask(*SAVE))
        self.send(0x000, f"81{IMS360:02X}")

    def saved(self, save: Callable[[], None]) -> None:
        """A save, whose duration depends on the memory."""
        self.tolerance(30_000)
        save()
        self.wait(100)
        self.tolerance(300)

    def tolerance(self, microseconds: int) -> None:
        """The tolerance of the frames that follow."""
        self._lines.append(f"# tolerance-us: {microseconds}")

    def group(self, group: int, data: str, destination: int = EVERYONE) -> None:
        """The sensor sends a group."""
        self.expect(identifier(group, self.address, destination), data)

    def tell(self, group: int, data: str, destination: int = EVERYONE, source: int = TESTER) -> None:
        """The tester sends a group."""
        self.send(identifier(group, source, destination), data)

    def claims(self) -> None:
        """The sensor claims its address and then sends DM1 without codes."""
        self.group(CLAIM, self.name_data)
        self.silence()

    def silence(self) -> None:
        """250 ms after the claim, the sensor sends DM1. Sets `begin`, the end of the silence."""
        self.wait(CLAIM_MS)
        self.begin = self.now
        self.group(DM1, NO_CODES)

    def at(self, milliseconds: float) -> None:
        """Goes to this time after the end of the silence."""
        self.now = self.begin + round(1000 * milliseconds)

    def restarts(self) -> None:
        """2010h:01 = 1: the controller starts again, 100 ms later, as in CANopen."""
        self.tell(PROPRIETARY, "2F10200101000000", self.address)
        self.group(PROPRIETARY, "6010200100000000", TESTER)
        self.wait(RESTART_MS)

    def request(self, group: int, destination: int = SENSOR, source: int = TESTER) -> None:
        """The tester requests a group."""
        self.tell(REQUEST, little(group, 3), destination, source)

    def refused(self, group: int) -> None:
        """A negative acknowledgement to all."""
        self.group(ACKNOWLEDGEMENT, f"01FFFFFF{TESTER:02X}{little(group, 3)}")

    def control(self, text: str, group: int) -> None:
        """A TP.CM message of the tester."""
        self.tell(CONTROL, text.ljust(10, "F") + little(group, 3), self.address)

    def parameter(self, request: str, reply: str) -> None:
        """An SDO request by Proprietary A, its reply, and a pause."""
        self.tell(PROPRIETARY, request, self.address)
        self.group(PROPRIETARY, reply, TESTER)
        self.wait(10)


QUIET = ("2B04210100000000",)  # 2104h:01 = 0: SSI2 on request only


def packets(message: bytes) -> list[str]:
    """A message in packets of the transport protocol."""
    parts = [message[at : at + 7] for at in range(0, len(message), 7)]
    return [f"{count:02X}{part.ljust(7, bytes([255])).hex().upper()}" for count, part in enumerate(parts, 1)]


def scaled(value: float, factor: float, offset: float, size: int) -> str:
    """A number of J1939-71: value = raw * factor + offset."""
    return little(round((value - offset) / factor), size)


def code(spn: int, fmi: int, count: int) -> str:
    """A diagnostic trouble code with conversion method 0."""
    return little(spn & 0xFFFF, 2) + f"{spn >> 16 << 5 | fmi:02X}{count:02X}"


def component(serial: int = 1) -> str:
    """Component identification: make, model, serial number, unit number."""
    return f"Plumbline*IMS360*{serial}**"


def packets_of_command(data: str, address: int) -> list[str]:
    """Commanded Address in packets."""
    return packets(bytes.fromhex(data) + bytes([address]))
