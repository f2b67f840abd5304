"""A sensor under test with its expected state."""

from pathlib import Path

from . import protocol as p
from .expected import Expected
from .harness import Frame, Program, Sensor, Tester, Timed
from .report import Report

# An identifier that the sensor does not use, for traffic on the bus.
FOREIGN = 0x7FE

# A flashed image measures the first angles 60 ms after its start. Replies before that have sensor errors.
FIRST_MEASUREMENT = 0.15


class Session(Expected, Timed):
    """One sensor, one adapter, and the expected state, from which every reply is known."""

    def __init__(
        self,
        report: Report,
        program: Program,
        product: p.Product,
        *,
        scene: str | Path = "tilt=0,0",
        store: Path | None = None,
        bus_rate: str | None = None,
        bitrate: int | None = None,
        wake: bool = True,
    ) -> None:
        super().__init__(product)
        self.report, self.program = report, program
        self.options = {"scene": scene, "store": store, "bus_rate": bus_rate}
        self.bitrate = bitrate
        self.power_up(wake=wake)

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self.power_down()

    # Power and restart.

    def power_up(self, *, wake: bool = True) -> None:
        """Starts the process and opens an adapter; with `wake`, sends frames until a sensor with automatic detection boots."""
        self.sensor = Sensor(self.program, self.product.name, **self.options)
        self.tester = Tester(self.sensor, self.bitrate)
        if wake:
            self.wake()

    def power_down(self) -> None:
        """Cuts the power."""
        self.tester.close()
        self.sensor.kill()

    def wake(self, timeout: float = 5.0) -> list[Frame]:
        """Sends frames until the boot-up messages are received; returns them. A sensor with a fixed rate needs no traffic."""
        end = self.now() + timeout
        frames: list[Frame] = []
        while len(frames) < 2 and self.now() < end:
            if not frames:
                self.tester.send(FOREIGN)
            if frame := self.tester.receive(0.02):
                frames.append(frame)
        if self.program.images is not None:
            self.sleep(FIRST_MEASUREMENT)
        return frames

    def boot_up(self) -> list[str]:
        """The two expected boot-up messages."""
        return [str(Frame(self.reply_id, self.boot_message()))] * 2

    def check_wake(self, name: str) -> None:
        """Wakes the sensor and checks its two boot-up messages."""
        self.report.equal(name, self.boot_up(), [str(frame) for frame in self.wake()])

    def reset(self, name: str = "RESET, then two boot-up messages") -> None:
        """RESET. The expected values must be those of the memory."""
        self.tester.send(self.set_id, bytes([p.BOOT]) + p.RESET_SIGNATURE)
        self.errors = 0
        self.restart_ids()
        self.check_wake(name)

    # Requests and their replies.

    def reply(self, name: str, request: bytes, expected: bytes) -> Frame | None:
        """One request whose complete reply is known."""
        frame = self.tester.request(self.set_id, request)
        self.report.equal(name, str(Frame(self.reply_id, expected)), str(frame))
        return frame

    def acknowledged(self, name: str, request: bytes) -> None:
        """One request that is answered with FSC and status only."""
        self.reply(name, request, bytes([request[0], self.status]))

    def read(self, parameter: p.Parameter, name: str = "", extra: bytes = b"") -> None:
        """Reads a parameter and compares it with the expected value."""
        self.reply(name or f"read {parameter.name}", bytes([parameter.read]) + extra, self.read_reply(parameter))

    def read_all(self, name: str) -> None:
        """Reads every parameter and compares it with the expected value; one check."""
        expected = {f"{parameter.read:02X}h": value.hex() for parameter, value in self.values.items()}
        self.report.equal(name, expected, self.snapshot())

    def snapshot(self) -> dict[str, str]:
        """All parameters as read from the sensor."""
        found = {}
        for parameter in self.product.parameters:
            frame = self.tester.request(self.set_id, bytes([parameter.read]))
            found[f"{parameter.read:02X}h"] = frame.data[2:].hex() if frame else "no reply"
        return found

    def accept(self, parameter: p.Parameter, value: bytes, name: str = "", extra: bytes = b"") -> None:
        """Writes a value that must be accepted, and reads it back."""
        name = name or f"{parameter.name} = {value.hex()}"
        self.values[parameter] = value
        self.acknowledged(f"write {name}", bytes([parameter.write]) + value + extra)
        self.read(parameter, f"read back {name}")

    def refuse(self, name: str, request: bytes) -> None:
        """A request that must be refused: the reply is FSC and status with CmdParamError, no parameter changes (G9)."""
        self.errors |= p.CMD_ERROR
        self.acknowledged(f"{name} is refused", request)
        self.read_all(f"{name} changes nothing")
        self.read_status(f"{name}: CmdParamError in the status, then cleared")

    def read_status(self, name: str = "read status") -> None:
        """Reads the status, which contains and then clears the sticky errors (G17)."""
        self.acknowledged(name, bytes([p.STATUS]))
        self.errors = 0

    def ignored(self, name: str, identifier: int, data: bytes = b"", **kind: object) -> None:
        """A frame that must have no effect: the next frame on the bus is the reply to the next request."""
        self.tester.send(identifier, data, **kind)
        self.acknowledged(f"{name} is ignored", bytes([p.STATUS]))

    def save(self) -> None:
        """SAVE, answered when the memory holds the parameters (G25)."""
        self.acknowledged("SAVE", bytes([p.SAVE]) + p.SAVE_SIGNATURE)

    def load(self) -> None:
        """LOAD: factory values in the reads and in the status at once (G8, G22)."""
        self.load_values()
        self.acknowledged("LOAD", bytes([p.LOAD]) + p.LOAD_SIGNATURE)

    def quiet(self, name: str, seconds: float = 0.1) -> None:
        """Checks that no frame is sent for this time."""
        self.report.equal(name, [], [str(frame) for frame in self.tester.collect(seconds)])

    def angles(self) -> tuple[int, ...] | None:
        """The angles as polled, in 0.01 deg."""
        frame = self.tester.request(self.set_id, bytes([p.ANGLES]))
        return decode_angles(self.product, frame.data) if frame else None

    def settle(self, seconds: float = 4.0) -> tuple[int, ...] | None:
        """Polls until the angles have not changed for 0.2 s; returns the angles."""
        end = self.now() + seconds
        last, since = self.angles(), self.now()
        while self.now() < end and self.now() - since < 0.2:
            self.sleep(0.01)
            now = self.angles()
            if now != last:
                last, since = now, self.now()
        return last


def decode_angles(product: p.Product, data: bytes) -> tuple[int, ...]:
    """The angles of an inclination reply: unsigned on a 1-axis type, signed on a 2-axis type (section 9.9.1)."""
    signed = product.axes == 2
    return tuple(int.from_bytes(data[at : at + 2], "little", signed=signed) for at in range(2, 2 + 2 * product.axes, 2))


def counter(product: p.Product, data: bytes) -> int | None:
    """The cyclic counter of an inclination reply, if it has one."""
    rest = data[2 + 2 * product.axes :]
    return int.from_bytes(rest, "little") if len(rest) == 2 else None
