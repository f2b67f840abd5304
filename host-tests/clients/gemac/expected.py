"""The state that a sensor must have according to the manual: its parameters, identifiers and status byte."""

from . import protocol as p


class Expected:
    """The expected state and replies. Reads and status follow a write at once (G22). `set_id`, `reply_id` and `sync_id` are the
    identifiers in force, which change only with a restart."""

    def __init__(self, product: p.Product) -> None:
        self.product = product
        self.sensor_bits = 0
        self.factory()

    def factory(self) -> None:
        """The state of a sensor with factory values (table 19)."""
        self.load_values()
        self.errors = 0
        self.restart_ids()

    def load_values(self) -> None:
        """Sets the factory values; the identifiers in force do not change (section 9.10.7)."""
        self.values = {parameter: parameter.factory for parameter in self.product.parameters}

    def restart_ids(self) -> None:
        """Sets the identifiers in force as after a restart: to the written values."""
        ids = (int.from_bytes(self.values[i], "little") for i in (p.SET_ID, p.REPLY_ID, p.SYNC_ID))
        self.set_id, self.reply_id, self.sync_id = ids

    @property
    def status(self) -> int:
        """The status byte of the next reply (section 9.5.2; for DefaultParam see G12)."""
        status = self.errors | self.sensor_bits
        if self.product.heated:  # for some time after power-up, longer than these checks (9.3, G6)
            status |= p.ACCURACY_WARNING
        if all(value == parameter.factory for parameter, value in self.values.items()):
            status |= p.DEFAULT_PARAM
        if self.values[p.BAUD_RATE] == b"\x00":
            status |= p.AUTOBAUD
        return status

    def boot_message(self) -> bytes:
        """The boot-up message, which contains the set id in force (G22)."""
        return self.product.boot(self.status, self.set_id)

    def read_reply(self, parameter: p.Parameter) -> bytes:
        """The reply to the request that reads a parameter."""
        return bytes([parameter.read, self.status]) + self.values[parameter]

    def offset(self, axis: int) -> int:
        """The zero offset of an axis in 0.01 deg."""
        value = self.values[self.product.offset(axis)]
        return int.from_bytes(value, "little", signed=self.product.axes == 2)

    def angles_reply(self, measured: tuple[int, ...], counter: int | None = None) -> bytes:
        """The inclination reply: measured angle plus offset, wrapped on 1 axis, clamped on 2 axes (G7)."""
        sums = [value + self.offset(axis) for axis, value in enumerate(measured)]
        if self.product.axes == 1:
            shown = tuple(value % 36000 for value in sums)
        else:
            shown = tuple(max(-9000, min(9000, value)) for value in sums)
        return self.product.angles(self.status, shown, counter)

    def automatic_offset(self, measured: int) -> bytes:
        """The offset that makes the measured angle zero (section 9.2)."""
        return p.u16(-measured % 36000 if self.product.axes == 1 else -measured)
