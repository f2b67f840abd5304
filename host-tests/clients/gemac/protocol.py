"""The protocol: function select codes, status bits, parameters and products (tables 14 to 26)."""

from dataclasses import dataclass

# Function select codes (tables 17 and 18).
ANGLES = 0x00
STATUS = 0x02
PRODUCT = 0x03
SERIAL = 0x04
LOAD = 0x40
SAVE = 0x50
BOOT = 0xFF

# Status bits (tables 14 and 15).
DEFAULT_PARAM = 0x01
AUTOBAUD = 0x02
EEPROM_ERROR = 0x04
CMD_ERROR = 0x08
SENSOR_ERROR = 0x10  # of the 1-axis types
SENSOR_X_ERROR = 0x10
SENSOR_Y_ERROR = 0x20
ACCURACY_WARNING = 0x40

EXTENDED = 0x8000_0000  # bit 31 of a stored identifier: 29-bit format (table 23)

LOAD_SIGNATURE = b"LOAD"
SAVE_SIGNATURE = b"SAVE"
RESET_SIGNATURE = b"RESET"


def u16(value: int) -> bytes:
    """A 16-bit number as it is sent: low byte first. Negative numbers in two's complement."""
    return (value & 0xFFFF).to_bytes(2, "little")


def u32(value: int) -> bytes:
    """A 32-bit number as it is sent: low byte first."""
    return value.to_bytes(4, "little")


def filter_value(cutoff_mhz: int, filter_type: int) -> bytes:
    """The parameters of 17h/27h: cut-off frequency in mHz and filter type (section 9.10.5)."""
    return u16(cutoff_mhz) + bytes([filter_type])


@dataclass(frozen=True)
class Parameter:
    """A device parameter: the codes that read and write it, and its factory value (tables 17 to 19)."""

    name: str
    read: int
    write: int
    factory: bytes

    @property
    def size(self) -> int:
        """Data bytes after the FSC in a write and after the status in the reply to a read."""
        return len(self.factory)


SET_ID = Parameter("Set-Parameter-ID", 0x10, 0x20, u32(0x300))
REPLY_ID = Parameter("Reply-Parameter-ID", 0x11, 0x21, u32(0x301))
SYNC_ID = Parameter("Sync-ID", 0x12, 0x22, u32(0x100))
BAUD_RATE = Parameter("Baud Rate", 0x13, 0x23, b"\x00")
BUS_OFF_RECOVERY = Parameter("Automatic Bus-Off Recovery", 0x14, 0x24, b"\x00")
CYCLIC_TIME = Parameter("Cyclic Time", 0x15, 0x25, u16(250))
CYCLIC_MODE = Parameter("Cyclic Mode", 0x16, 0x26, b"\x00")
FILTER = Parameter("Cut-off Frequency, Filter", 0x17, 0x27, filter_value(2000, 2))
ZERO_OFFSET = Parameter("Zero Offset", 0x18, 0x28, u16(0))
ZERO_OFFSET_X = Parameter("Zero Offset X", 0x18, 0x28, u16(0))
ZERO_OFFSET_Y = Parameter("Zero Offset Y", 0x19, 0x29, u16(0))

COMMON = (
    SET_ID,
    REPLY_ID,
    SYNC_ID,
    BAUD_RATE,
    BUS_OFF_RECOVERY,
    CYCLIC_TIME,
    CYCLIC_MODE,
    FILTER,
)

# Codes of section 9.10.3 and their rates in bit/s.
BAUD_CODES = {
    1: 10_000,
    2: 20_000,
    3: 50_000,
    4: 100_000,
    5: 125_000,
    6: 250_000,
    7: 500_000,
    8: 800_000,
    9: 1_000_000,
    10: 62_500,
}


@dataclass(frozen=True)
class Product:
    """One product: its differences from the others on the bus."""

    name: str
    axes: int
    product_number: int
    version: bytes
    heated: bool = False

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The device parameters; zero offsets per axis (G1)."""
        offsets = (ZERO_OFFSET,) if self.axes == 1 else (ZERO_OFFSET_X, ZERO_OFFSET_Y)
        return COMMON + offsets

    @property
    def codes(self) -> set[int]:
        """Every valid function select code of a request (table 17 with G1)."""
        fixed = {ANGLES, STATUS, PRODUCT, SERIAL, LOAD, SAVE, BOOT}
        return fixed | {p.read for p in self.parameters} | {p.write for p in self.parameters}

    def offset(self, axis: int) -> Parameter:
        """The zero offset of an axis, 0 or 1."""
        return self.parameters[len(COMMON) + axis]

    def boot(self, status: int, set_id: int = 0x300) -> bytes:
        """The boot-up message (table 16)."""
        return bytes([BOOT, status]) + u32(set_id) + self.version

    def angles(self, status: int, values: tuple[int, ...], counter: int | None = None) -> bytes:
        """The inclination reply: one or two angles in 0.01 deg, and the counter in cyclic mode (tables 21 and 22, G4)."""
        data = bytes([ANGLES, status]) + b"".join(u16(value) for value in values)
        return data if counter is None else data + u16(counter)


# The product number has the digits of the article number. The version is hexadecimal on the types of 2021 and decimal on the
# older types (G5, G20).
_V3_44 = b"\x44\x03"
_V1_03 = u16(103)
PRODUCTS = {
    product.name: product
    for product in (
        Product("is1", 1, 2305030, _V3_44),
        Product("is2", 2, 2305430, _V3_44),
        Product("is1d", 1, 2305030, _V1_03),
        Product("is2d", 2, 2305430, _V1_03),
        Product("is1dm", 1, 2302030, _V1_03, heated=True),
        Product("is2dm", 2, 2302430, _V1_03, heated=True),
        Product("is1tk", 1, 2302030, _V3_44, heated=True),
        Product("is2tk", 2, 2302430, _V3_44, heated=True),
    )
}
REVISION = 1
SERIAL_NUMBER = 1
