"""Builds one trace: a bus with a tester and a sensor, and a clock."""

import wire
from gemac import protocol as p
from gemac.expected import Expected

# An identifier that the sensor does not use: traffic for the detection of the bit rate.
FOREIGN = 0x7FE


MANUAL = "written from GEMAC user manual 1.7 (2021-07-30)"

# The time of a save depends on the memory.
SAVING_US = 5000

TWO_AXIS = "12.34,-5.67"
ONE_AXIS = "10.65,3.00"  # the example of section 9.9.1: 1065


class Trace:
    """Frames in the order of time. `expected` gives the replies of the sensor."""

    def __init__(self, name: str, origin: str, *, scene: str, tolerance_us: int = 300, serial: int = 1) -> None:
        self.name = name
        self.product = p.PRODUCTS[name.split("-")[0]]
        self.expected = Expected(self.product)
        self.serial = serial
        self.bit_us = 4  # 250 kbit/s
        self.now = 100_000
        self.pose(scene)
        self._lines = [
            f"# origin: {origin}",
            f"# model: {self.product.name}",
            f"# scene: tilt={scene}",
            "# bitrate: 250000",
            f"# tolerance-us: {tolerance_us}",
            f"# serial: {serial}",
            "",
        ]

    def text(self) -> str:
        """The text of the file."""
        return "\n".join(self._lines) + "\n"

    # Lines.

    def note(self, text: str) -> None:
        """A heading."""
        self._lines += ["", f"# -- {text}"]

    def action(self, text: str) -> None:
        """An action at the time of the line before."""
        self._lines.append(f"# {text}")

    def _frame(self, at_us: int, identifier: int, data: str, direction: str) -> None:
        number = f"{identifier & 0x1FFF_FFFF:08X}" if identifier & p.EXTENDED else f"{identifier:03X}"
        self._lines.append(f"({at_us // 1_000_000}.{at_us % 1_000_000:06}) can0 {number}#{data} {direction}")

    def wait(self, milliseconds: int) -> None:
        """Lets time pass."""
        self.now += 1000 * milliseconds

    # Frames.

    def send(self, identifier: int, data: bytes = b"", remote_dlc: int | None = None) -> None:
        """The tester sends; sets `now` to the end of the frame."""
        text = data.hex().upper() if remote_dlc is None else f"R{remote_dlc or ''}"
        self._frame(self.now, identifier, text, "T")
        self.now += self.bit_us * wire.frame_bits(identifier, data, remote_dlc)

    def expect(self, data: bytes, start_us: int | None = None) -> None:
        """The sensor sends at the first time after `start_us` at which the bus is free; sets `now` to the end of the frame."""
        earliest = self.now + self.bit_us * wire.INTERMISSION
        start = earliest if start_us is None else max(earliest, start_us)
        self.now = start + self.bit_us * wire.frame_bits(self.expected.reply_id, data)
        self._frame(self.now, self.expected.reply_id, data.hex().upper(), "R")

    def ask(self, request: bytes, reply: bytes) -> None:
        """A request on the set id in force, its reply, and a pause."""
        self.send(self.expected.set_id, request)
        self.expect(reply)
        self.wait(10)

    def silent(self, identifier: int, data: bytes = b"", remote_dlc: int | None = None) -> None:
        """A frame that is not answered."""
        self.send(identifier, data, remote_dlc)
        self.wait(10)

    # Requests of the manual.

    def acknowledged(self, request: bytes) -> None:
        """A request that is answered with FSC and status."""
        self.ask(request, bytes([request[0], self.expected.status]))

    def read(self, parameter: p.Parameter) -> None:
        """Reads a parameter."""
        self.ask(bytes([parameter.read]), self.expected.read_reply(parameter))

    def write(self, parameter: p.Parameter, value: bytes, *, read_back: bool = True) -> None:
        """Writes a value that is accepted."""
        self.expected.values[parameter] = value
        self.acknowledged(bytes([parameter.write]) + value)
        if read_back:
            self.read(parameter)

    def refused(self, request: bytes) -> None:
        """A request that is refused."""
        self.expected.errors |= p.CMD_ERROR
        self.acknowledged(request)

    def status(self) -> None:
        """Reads the status, which clears the errors."""
        self.acknowledged(bytes([p.STATUS]))
        self.expected.errors = 0

    def poll(self, counter: int | None = None) -> None:
        """Polls the angles."""
        self.ask(bytes([p.ANGLES]), self.expected.angles_reply(self.measured, counter))

    def sync(self, counter: int | None = None) -> None:
        """A sync frame and its answer."""
        self.send(self.expected.sync_id)
        self.expect(self.expected.angles_reply(self.measured, counter))
        self.wait(10)

    def boot(self, first: tuple[int, bytes] = (FOREIGN, b"")) -> None:
        """The first frame on the bus, which is not answered, and two boot-up messages (9.6, G21)."""
        self.send(*first)
        for _ in range(2):
            self.expect(self.expected.boot_message())
        self.wait(50)

    def save(self) -> None:
        """SAVE."""
        self.acknowledged(bytes([p.SAVE]) + p.SAVE_SIGNATURE)

    def reset(self) -> None:
        """RESET of a sensor that detects the bit rate: it is silent until it receives a frame (G27)."""
        self.silent(self.expected.set_id, bytes([p.BOOT]) + p.RESET_SIGNATURE)
        self.expected.errors = 0
        self.expected.restart_ids()
        self.wait(200)
        self.boot()

    def power_cycle(self) -> None:
        """The power is cut and returns; the expected values must be those of the memory."""
        self.wait(100)
        self.action("power-cycle")
        self.expected.errors = 0
        self.expected.restart_ids()
        self.wait(300)

    def pose(self, scene: str) -> None:
        """Sets the measured angles and sensor errors of a pose."""
        first, second = (round(100 * float(part)) for part in scene.split(","))
        if self.product.axes == 1:
            self.measured = (first % 36000,)
            self.expected.sensor_bits = p.SENSOR_ERROR if abs(second) > 4500 else 0
        else:
            self.measured = (first, second)
            self.expected.sensor_bits = (p.SENSOR_X_ERROR if abs(first) > 8500 else 0) | (
                p.SENSOR_Y_ERROR if abs(second) > 8500 else 0
            )

    def move(self, scene: str) -> None:
        """A new pose, and time for the filter to settle."""
        self.action(f"scene: tilt={scene}")
        self.pose(scene)
        self.wait(3000)
