"""What the manual says about a sensor after what has been done to it: its parameters, identifiers and status byte."""

from . import protocol as p


class Book:
    """Foretells replies. A write shows at once in the reads and in the status (G22); `set_id`, `reply_id` and `sync_id` are the
    identifiers in force, which follow the parameters only at a restart."""

    def __init__(self, model: p.Model) -> None:
        self.model = model
        self.sensor_bits = 0
        self.factory()

    def factory(self) -> None:
        """A sensor as delivered (table 19)."""
        self.load_values()
        self.errors = 0
        self.restart_ids()

    def load_values(self) -> None:
        """The factory values; the identifiers in force stay (section 9.10.7)."""
        self.values = {parameter: parameter.factory for parameter in self.model.parameters}

    def restart_ids(self) -> None:
        """The identifiers as after a restart: those that are written."""
        ids = (int.from_bytes(self.values[i], "little") for i in (p.SET_ID, p.REPLY_ID, p.SYNC_ID))
        self.set_id, self.reply_id, self.sync_id = ids

    @property
    def status(self) -> int:
        """The status byte that the next reply must carry (section 9.5.2; DefaultParam is derived, G12)."""
        status = self.errors | self.sensor_bits
        if self.model.heated:  # after power-up, as long as these checks last (9.3, G6)
            status |= p.ACCURACY_WARNING
        if all(value == parameter.factory for parameter, value in self.values.items()):
            status |= p.DEFAULT_PARAM
        if self.values[p.BAUD_RATE] == b"\x00":
            status |= p.AUTOBAUD
        return status

    def boot_message(self) -> bytes:
        """The boot-up message, which names the set id in force (G22)."""
        return self.model.boot(self.status, self.set_id)

    def read_reply(self, parameter: p.Parameter) -> bytes:
        """The reply to the request that reads a parameter."""
        return bytes([parameter.read, self.status]) + self.values[parameter]

    def offset(self, axis: int) -> int:
        """The zero offset of an axis in 0.01 deg."""
        value = self.values[self.model.offset(axis)]
        return int.from_bytes(value, "little", signed=self.model.axes == 2)

    def angles_reply(self, measured: tuple[int, ...], counter: int | None = None) -> bytes:
        """The inclination reply: measured plus offset, wrapped on one axis, clamped on two (G7)."""
        sums = [value + self.offset(axis) for axis, value in enumerate(measured)]
        if self.model.axes == 1:
            shown = tuple(value % 36000 for value in sums)
        else:
            shown = tuple(max(-9000, min(9000, value)) for value in sums)
        return self.model.angles(self.status, shown, counter)

    def automatic_offset(self, measured: int) -> bytes:
        """The offset that makes the measured angle zero (section 9.2)."""
        return p.u16(-measured % 36000 if self.model.axes == 1 else -measured)
