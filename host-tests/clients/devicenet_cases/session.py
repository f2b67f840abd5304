"""A sensor under test and its masters: explicit messages with fragments, I/O messages, and other frames of the sensor.

Data is text: hex digits without spaces, as in a candump log.
"""

from collections.abc import Callable
from pathlib import Path

from gemac.harness import Frame, Program, Sensor, SensorGone, Tester, Timed
from gemac.report import Report

from . import protocol as p

REPLY_TIMEOUT = 3.0  # a reply takes some milliseconds; this is long enough for a busy machine
SILENCE = 0.12  # without an answer within this time, a frame is ignored
START_TIME = 6.0
# The answer to a release of what a stranger has not allocated: "not allocated" or "owned by another master".
PROBE = f"{p.STRANGER:02X}4C030101"
PROBED = tuple(p.error(code, p.STRANGER) for code in (p.CHOICE_STATE, p.PORT_BUSY))


class Refused(Exception):
    """The sensor answered with an error, or did not answer."""


class Session(Timed):
    """One sensor and one adapter."""

    def __init__(
        self,
        report: Report,
        program: Program,
        subject: p.Subject,
        *,
        scene: str | Path | None = None,
        store: Path | None = None,
        bus_rate: int | None = None,
        log: Path | None = None,
        real_time: bool = False,
        mac: int = p.FACTORY_MAC,
        online: bool = True,
        alone: float = 0.0,
    ) -> None:
        self.report, self.program, self.subject, self.mac = report, program, subject, mac
        self.options = {"scene": scene or subject.scene, "store": store, "bus_rate": bus_rate, "log": log, "real_time": real_time}
        self.master = p.MASTER
        self.others: list[Frame] = []
        self.power_up(online=online, alone=alone)

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self.power_down()

    # Power.

    def power_up(self, *, online: bool = True, alone: float = 0.0) -> None:
        """Starts the process and opens an adapter after the sensor has been `alone` for some seconds; with `online`, waits until
        the sensor answers."""
        self.sensor = Sensor(self.program, self.subject.product, **self.options)
        self.sleep(alone)
        self.tester = Tester(self.sensor)
        self.opened = self.now()
        if online and not self.wait_online():
            self.power_down()
            raise SensorGone(f"node {self.mac} is not on-line; {self.sensor.errors()}")

    def power_down(self) -> None:
        """Cuts the power."""
        self.tester.close()
        self.sensor.kill()

    def power_cycle(self, *, online: bool = True, **options: object) -> None:
        """Switches the power off and on, optionally with other options of the program."""
        self.power_down()
        self.options |= options
        self.power_up(online=online)

    def wait_online(self, timeout: float = START_TIME, step: float = 0.1) -> float | None:
        """Probes until the sensor answers; returns the time of the answer."""
        end = self.now() + timeout
        while self.now() < end:
            self.send(p.PORT, PROBE)
            if frame := self.wait_probe(step):
                # On a busy machine, several probes may be answered.
                self.tester.collect_until_quiet(0.06, 1.0)
                self.others.clear()
                return frame.at
        return None

    def wait_probe(self, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The answer to the probe."""
        return self.wait(lambda frame: frame.id == self.id(p.RESPONSE) and text(frame) in PROBED, timeout)

    # Frames.

    def id(self, message: int) -> int:
        """The identifier of a group 2 message of this node."""
        return p.group2(message, self.mac)

    def send(self, message: int, data: str = "") -> None:
        """Sends a group 2 message to this node."""
        if len(data) > 16:
            raise ValueError(f"{data} is longer than a frame")
        self.tester.send(self.id(message), bytes.fromhex(data))

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

    def wait_message(self, message: int, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next group 2 message of this node."""
        return self.wait(lambda frame: frame.id == self.id(message), timeout)

    def collect(self, seconds: float, identifier: int | None = None) -> list[Frame]:
        """All frames received within this time, or only those with an identifier."""
        frames = self.tester.collect(seconds)
        return [frame for frame in frames if identifier is None or frame.id == identifier]

    def quiet(self, name: str, seconds: float = SILENCE) -> None:
        """Checks that no frame is sent for this time."""
        self.report.equal(name, [], [str(frame) for frame in self.collect(seconds)])

    def ignored(self, name: str, *frames: tuple[int, str], **kind: object) -> None:
        """Sends frames (identifier, data) and checks that none is answered. The answer to a probe marks the end."""
        for identifier, data in frames:
            self.tester.send(identifier, bytes.fromhex(data), **kind)
        self.others.clear()
        self.send(p.PORT, PROBE)
        probed = self.wait_probe() is not None
        shown = ", ".join(f"{identifier & 0x1FFF_FFFF:03X}#{data}" for identifier, data in frames[:3])
        self.report.equal(f"{name}: {shown}", (True, []), (probed, [str(frame) for frame in self.others]))
        self.others.clear()

    # Explicit messages.

    def ask(self, data: str, on: int = p.EXPLICIT, timeout: float = REPLY_TIMEOUT) -> str:
        """Sends a request and returns the data of the answer; empty without an answer."""
        self.send(on, data)
        return self.answer(timeout)

    def answer(self, timeout: float = REPLY_TIMEOUT) -> str:
        """The data of the next response of the sensor; empty without one."""
        frame = self.wait_message(p.RESPONSE, timeout)
        return text(frame) if frame else ""

    def expect(self, name: str, data: str, *expected: str, on: int = p.EXPLICIT) -> bool:
        """Checks the answer to a request; with several expected answers, each of them is right."""
        got = self.ask(data, on, SILENCE if "" in expected else REPLY_TIMEOUT)
        name = f"{name}: {self.id(on):03X}#{data}"
        return self.report.verdict(got in expected, name, " or ".join(expected) or "no answer", got or "no answer")

    def expect_port(self, name: str, data: str, *expected: str) -> bool:
        """Checks the answer of the unconnected port."""
        return self.expect(name, data, *expected, on=p.PORT)

    def body(self, service: int, kind: int, instance: int, data: str = "") -> str:
        """The data of a request by the master."""
        return f"{self.master:02X}{service:02X}{kind:02X}{instance:02X}{data}"

    def error(self, code: str) -> str:
        """An error response to the master."""
        return p.error(code, self.master)

    def done(self, service: int, data: str = "") -> str:
        """A success response to the master."""
        return f"{self.master:02X}{service | p.RESPONSE_BIT:02X}{data}"

    def get_answer(self, kind: int, instance: int, attribute: int) -> str:
        """The service and data of the answer to Get_Attribute_Single, fragments put together; an error as it came."""
        answer = self.ask(self.body(p.GET, kind, instance, f"{attribute:02X}"))
        if not answer or not int(answer[:2], 16) & 0x80:
            return answer[2:]
        whole = ""
        while answer:
            whole += answer[4:]
            count = int(answer[2:4], 16)
            acknowledge = f"{answer[:2]}{0xC0 | count & 0x3F:02X}00"
            if count & 0xC0 == 0x80:
                self.send(p.EXPLICIT, acknowledge)
                break
            answer = self.ask(acknowledge)
        return whole

    def get(self, kind: int, instance: int, attribute: int) -> str:
        """The value of an attribute; an error as text with a question mark."""
        answer = self.get_answer(kind, instance, attribute)
        return answer[2:] if answer[:2] == "8E" else f"?{answer}"

    def number(self, kind: int, instance: int, attribute: int, signed: bool = False) -> int | str:
        """The value of an attribute as an integer; an error as text."""
        value = self.get(kind, instance, attribute)
        return value if "?" in value else p.decode(value, signed)

    def set(self, kind: int, instance: int, attribute: int, data: str) -> str:
        """Sets an attribute and returns the service and data of the answer."""
        return self.ask(self.body(p.SET, kind, instance, f"{attribute:02X}{data}"))[2:]

    def put(self, kind: int, instance: int, attribute: int, data: str) -> str:
        """Sets an attribute, which must succeed; returns the data of the answer."""
        answer = self.set(kind, instance, attribute, data)
        if answer[:2] != "90":
            raise Refused(f"set {kind:02X}h/{instance}/{attribute:02X}h = {data}: {answer or 'no answer'}")
        return answer[2:]

    # The angle object.

    def angle(self, attribute: int) -> int | str:
        """An attribute of the angle object as an integer; an error as text."""
        entry = p.BY_ID[attribute]
        signed = (entry.angle and not self.subject.circular) or attribute in (0x78, 0x80)
        return self.number(p.ANGLE, 1, attribute, signed)

    def put_angle(self, attribute: int, value: int) -> None:
        """Sets an attribute of the angle object, which must succeed."""
        self.put(p.ANGLE, 1, attribute, p.encode(value, p.BY_ID[attribute].size))

    def set_angle(self, attribute: int, value: int) -> str:
        """Sets an attribute of the angle object; returns the service and data of the answer."""
        return self.set(p.ANGLE, 1, attribute, p.encode(value, p.BY_ID[attribute].size))

    def angles(self) -> dict[str, object]:
        """All attributes of the angle object but the measured ones."""
        return {str(entry): self.angle(entry.id) for entry in p.ATTRIBUTES if entry.id not in (0x72, 0x78, 0x7A, 0x80)}

    def words(self, long: int, lateral: int | None = None) -> str:
        """The data of assembly 103."""
        return p.encode(long, 2) + p.encode(self.subject.lateral if lateral is None else lateral, 2)

    # Connections.

    def allocate(self, choice: int, master: int | None = None) -> str:
        """Allocates connections over the unconnected port; returns the answer."""
        master = self.master if master is None else master
        return self.ask(f"{master:02X}4B0301{choice:02X}{master:02X}", p.PORT)

    def release(self, choice: int, master: int | None = None) -> str:
        """Releases connections over the unconnected port; returns the answer."""
        return self.ask(f"{self.master if master is None else master:02X}4C0301{choice:02X}", p.PORT)

    def connect(self, choice: int = 1, **rates: int) -> None:
        """Allocates, sets the rate of the explicit connection to 0 (no time-out) and those of `poll` and `cos` if given."""
        answer = self.allocate(choice)
        if answer != f"{self.master:02X}CB00":
            raise Refused(f"allocate {choice:02X}h: {answer or 'no answer'}")
        self.rate(p.C_EXPLICIT, rates.pop("explicit", 0))
        for name, value in rates.items():
            self.rate({"poll": p.C_POLL, "cos": p.C_COS}[name], value)

    def rate(self, instance: int, milliseconds: int) -> str:
        """Sets the expected packet rate of a connection; returns the data of the answer."""
        return self.put(p.CONNECTION, instance, 9, p.encode(milliseconds, 2))

    def state(self, instance: int) -> int | str:
        """The state of a connection."""
        return self.number(p.CONNECTION, instance, 1)

    def poll(self, data: str = "", timeout: float = REPLY_TIMEOUT) -> str | None:
        """Sends a poll command; returns the data of the response."""
        self.send(p.POLL, data)
        frame = self.wait(lambda frame: frame.id == p.poll_response(self.mac), timeout)
        return text(frame) if frame else None

    def produced(self, seconds: float) -> list[Frame]:
        """The COS or cyclic messages within this time."""
        found = [frame for frame in self.others if frame.id == p.change_of_state(self.mac)]
        self.others.clear()
        return found + self.collect(seconds, p.change_of_state(self.mac))

    def until_free(self, limit: float, master: int = p.OTHER, step: float = 0.03) -> float | None:
        """Tries to allocate for another master until it succeeds; returns the time of its answer."""
        end = self.now() + limit
        while self.now() < end:
            self.send(p.PORT, f"{master:02X}4B030101{master:02X}")
            frame = self.wait_message(p.RESPONSE)
            if frame and text(frame) == f"{master:02X}CB00":
                return frame.at
            self.sleep(step)
        return None


def text(frame: Frame) -> str:
    """The data of a frame."""
    return frame.data.hex().upper()


def shown(frames: list[Frame]) -> list[str]:
    """Frames as text."""
    return [str(frame) for frame in frames]
