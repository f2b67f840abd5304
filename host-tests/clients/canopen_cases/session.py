"""A sensor under test and its master: NMT, SDO, and other frames of the sensor."""

from collections.abc import Callable, Mapping
from pathlib import Path

from gemac.harness import Frame, Program, Sensor, SensorGone, Tester, Timed
from gemac.report import Report

from . import protocol as p

REPLY_TIMEOUT = 0.5  # also long enough for a busy machine with the time of the computer
SILENCE = 0.12  # without an answer within this time, a frame is ignored
START_TIME = 5.0


class Abort(Exception):
    """The sensor aborted a transfer."""

    def __init__(self, code: int) -> None:
        super().__init__(f"abort {code:08X}h")
        self.code = code


class Session(Timed):
    """One sensor and one adapter."""

    def __init__(
        self,
        report: Report,
        binary: Path,
        product: str,
        arguments: tuple[str, ...] = (),
        *,
        scene: str | Path = "tilt=0,0",
        store: Path | None = None,
        bus_rate: str | None = None,
        log: Path | None = None,
        real_time: bool = False,
        node: int = p.FACTORY_NODE_ID,
        table: Mapping[tuple[int, int], p.Object] = p.BY_KEY,
    ) -> None:
        self.table = table
        self.report, self.binary, self.product, self.arguments = report, binary, product, arguments
        self.options = {"scene": scene, "store": store, "bus_rate": bus_rate, "log": log, "real_time": real_time}
        self.node = node
        try:
            self.power_up()
        except BaseException:
            # There will be no call of `__exit__`.
            if hasattr(self, "sensor"):
                self.sensor.kill()
            raise

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self.power_down()

    # Power.

    def power_up(self, *, boot: bool = True, alone: float = 0.0) -> None:
        """Starts the process and opens an adapter after the sensor has been `alone` for some seconds; with `boot`, waits for the
        boot-up message."""
        self.sensor = Sensor(Program(self.binary, arguments=self.arguments), self.product, **self.options)
        self.sleep(alone)
        self.tester = Tester(self.sensor)
        self.others: list[Frame] = []
        if boot and not self.wait_boot_up(START_TIME):
            raise SensorGone(f"no boot-up message of node {self.node}; {self.sensor.errors()}")
        if boot and not alone:
            self.clear_error_passive()

    def clear_error_passive(self) -> None:
        """Until the adapter is open, no node acknowledges. If that takes some time, the controller is error passive, and the
        sensor reports it after its boot-up message. Clears that error, and waits for the first sample."""
        self.wait(lambda frame: False, 0.06)
        code = p.encode(p.ERROR_PASSIVE, 2)
        found = [n for n, frame in enumerate(self.others) if frame.id == p.EMCY + self.node and frame.data[:2] == code]
        if found:
            # The error and the error reset.
            del self.others[found[0] : found[0] + 2]
            self.put(0x1003, 0, 0)

    def power_down(self) -> None:
        """Cuts the power."""
        self.tester.close()
        self.sensor.kill()

    def power_cycle(self, **options: object) -> None:
        """Switches the power off and on, optionally with other options of the program."""
        self.power_down()
        self.options |= options
        self.power_up()

    # Frames.

    def send(self, identifier: int, data: bytes = b"", **kind: object) -> None:
        """Sends one frame."""
        self.tester.send(identifier, data, **kind)

    def wait(self, wanted: Callable[[Frame], bool], timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame of a kind; the frames before it are kept in `others`."""
        end = self.now() + timeout
        while (left := end - self.now()) > 0:
            frame = self.tester.receive(left)
            if frame is None:
                break
            if wanted(frame):
                return frame
            self.others.append(frame)
        return None

    def wait_id(self, base: int, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame of a service of this node."""
        return self.wait(lambda frame: frame.id == base + self.node, timeout)

    def wait_boot_up(self, timeout: float = START_TIME) -> bool:
        """Waits for the boot-up message; returns whether it was received."""
        boot_up = Frame(p.ERROR_CONTROL + self.node, bytes([p.BOOT_UP]))
        return self.wait(lambda frame: frame == boot_up, timeout) is not None

    def collect(self, seconds: float, base: int | None = None) -> list[Frame]:
        """All frames received within this time, or only those of a service of this node."""
        frames = self.tester.collect(seconds)
        return [frame for frame in frames if base is None or frame.id == base + self.node]

    def quiet(self, name: str, seconds: float = SILENCE) -> None:
        """Checks that no frame is sent for this time."""
        self.report.equal(name, [], [str(frame) for frame in self.collect(seconds)])

    # NMT.

    def nmt(self, command: int, node: int | None = None) -> None:
        """Sends an NMT command, to this node if no other is given."""
        self.send(p.NMT, bytes([command, self.node if node is None else node]))

    def guard(self, **kind: object) -> Frame | None:
        """Requests the state with a remote frame (node guarding)."""
        self.send(p.ERROR_CONTROL + self.node, remote=True, dlc=1)
        return self.wait_id(p.ERROR_CONTROL)

    def state(self) -> int | None:
        """The NMT state, read by node guarding."""
        frame = self.guard()
        return frame.data[0] & 0x7F if frame and len(frame.data) == 1 else None

    def check_state(self, name: str, expected: int) -> None:
        """Checks the NMT state."""
        self.report.equal(name, f"state {expected}", f"state {self.state()}")

    def reset(self, command: int = p.RESET_NODE) -> bool:
        """Resets the sensor; returns whether the boot-up message was received."""
        self.nmt(command)
        return self.wait_boot_up()

    # SDO.

    def sdo(self, data: bytes, timeout: float = REPLY_TIMEOUT) -> bytes | None:
        """Sends one SDO frame, filled with zeros, and returns the answer."""
        self.send(p.SDO_REQUEST + self.node, data.ljust(8, b"\x00"))
        frame = self.wait_id(p.SDO_REPLY, timeout)
        return frame.data if frame else None

    def exchange(self, data: bytes) -> bytes:
        """Sends one SDO frame and returns the answer; raises an exception on an abort or without an answer."""
        answer = self.sdo(data)
        if answer is None or len(answer) != 8:
            raise SensorGone(f"SDO {data.hex()} was answered with {answer!r}")
        if answer[0] == 0x80:
            raise Abort(p.decode(answer[4:]))
        return answer

    def upload(self, index: int, sub: int = 0) -> bytes:
        """Reads an object, expedited or in segments as selected by the sensor."""
        answer = self.exchange(initiate(0x40, index, sub))
        if answer[0] & 0x02:
            return answer[4 : 8 - (answer[0] >> 2 & 3)]
        value, toggle = b"", 0
        while True:
            segment = self.exchange(bytes([0x60 | toggle]))
            value += segment[1 : 8 - (segment[0] >> 1 & 7)]
            if segment[0] & 1:
                return value
            toggle ^= 0x10

    def download(self, index: int, sub: int, value: bytes) -> None:
        """Writes an object, expedited if it has at most 4 bytes."""
        if 1 <= len(value) <= 4:
            self.exchange(initiate(0x23 | (4 - len(value)) << 2, index, sub, value))
        else:
            self.download_segments(index, sub, value)

    def download_segments(self, index: int, sub: int, value: bytes, *, with_size: bool = True) -> None:
        """Writes an object in segments."""
        size = p.encode(len(value), 4) if with_size else b""
        self.exchange(initiate(0x21 if with_size else 0x20, index, sub, size))
        toggle = 0
        for at in range(0, max(len(value), 1), 7):
            part = value[at : at + 7]
            last = at + 7 >= len(value)
            self.exchange(bytes([toggle | 7 - len(part) << 1 | last]) + part)
            toggle ^= 0x10

    def resynchronise(self) -> None:
        """Waits until every earlier request is answered, and drops the answers: the answer to this request is the last one."""
        request = initiate(0x40, 0x1018, 0xA5)
        self.send(p.SDO_REQUEST + self.node, request)
        answer = p.SDO_REPLY + self.node
        self.wait(lambda frame: frame.id == answer and frame.data[1:4] == request[1:4], 20.0)
        self.others.clear()

    def get(self, index: int, sub: int = 0) -> int:
        """Reads an integer."""
        entry = self.table.get((index, sub))
        return p.decode(self.upload(index, sub), bool(entry and entry.signed))

    def put(self, index: int, sub: int, value: int) -> None:
        """Writes an integer with the size in the manual."""
        self.download(index, sub, p.encode(value, self.table[index, sub].size))

    def abort_code(self, action: Callable[..., object], *arguments: object) -> int:
        """The abort code of a transfer; 0 if it is not aborted."""
        try:
            action(*arguments)
        except Abort as abort:
            return abort.code
        return 0

    def refused(self, name: str, codes: int | set[int], action: Callable[..., object], *arguments: object) -> None:
        """Checks that a transfer is aborted with one of these codes."""
        codes = codes if isinstance(codes, set) else {codes}
        got = self.abort_code(action, *arguments)
        wanted = " or ".join(f"{code:08X}h" for code in sorted(codes))
        self.report.verdict(got in codes, name, f"abort {wanted}", f"abort {got:08X}h" if got else "no abort")

    def accepted(self, name: str, index: int, sub: int, value: int) -> None:
        """Checks that a value is accepted and read back."""
        code = self.abort_code(self.put, index, sub, value)
        got = f"abort {code:08X}h" if code else self.get(index, sub)
        self.report.equal(name, value, got)

    def reads(self, name: str, index: int, sub: int, expected: int) -> None:
        """Checks the value of an object."""
        self.report.equal(name, expected, self.get(index, sub))

    def snapshot(self) -> dict[str, str]:
        """All settings and constant values as read from the sensor."""
        return {str(entry): self.upload(entry.index, entry.sub).hex() for entry in p.STEADY}

    def slopes(self, wide: bool = False) -> tuple[int, int]:
        """The longitudinal and the lateral slope in the unit of 6000h."""
        return (self.get(0x6110), self.get(0x6120)) if wide else (self.get(0x6010), self.get(0x6020))

    def settle(self, seconds: float = 8.0) -> tuple[int, int]:
        """Reads until the 32-bit slopes have not changed for 0.4 s; returns the slopes."""
        end = self.now() + seconds
        last, since = self.slopes(wide=True), self.now()
        while self.now() < end and self.now() - since < 0.4:
            self.sleep(0.02)
            now = self.slopes(wide=True)
            if now != last:
                last, since = now, self.now()
        return last


def initiate(command: int, index: int, sub: int, data: bytes = b"") -> bytes:
    """The frame that begins a transfer."""
    return (bytes([command]) + p.encode(index, 2) + bytes([sub]) + data).ljust(8, b"\x00")
