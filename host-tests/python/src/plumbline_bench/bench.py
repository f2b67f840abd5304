"""A bus with virtual sensors: the program `virtual-sensor` as a process, and the connection that controls it."""

import subprocess
import time
from collections.abc import Callable, Iterable

from .connection import BenchError, Connection, Frame
from .program import find_program

# The server lets at most this time pass at once, in s.
LONGEST = 60.0

TOPICS = ("leds", "state", "stored", "frames")


class Bench:
    """Sensors on one bus. Each sensor is its model, or the model and a dict with options of `options_of`."""

    def __init__(
        self,
        *sensors: str | tuple[str, dict],
        bit_rate: int | None = None,
        virtual_time: bool = False,
        log: str | None = None,
        events: Iterable[str] = TOPICS,
        program: str | None = None,
    ):
        from .sensor import Sensor, options_of

        command = [program or find_program(), "--listen", "127.0.0.1:0", "--control", "0"]
        command += ["--bus-rate", f"{bit_rate / 1000:g}"] if bit_rate else []
        command += ["--clock", "client"] if virtual_time else []
        command += ["--log", str(log)] if log else []
        for one in sensors or ("is2",):
            model, options = (one, {}) if isinstance(one, str) else one
            command += ["--model", model, *options_of(**options)]
        self.virtual_time = virtual_time
        self.events: list[dict] = []  # those of the last `advance`
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            # The channel for python-can: can.Bus(interface="slcan", channel=bench.channel, sleep_after_open=0).
            self.channel = self._address("slcan ")
            host, port = self._address("control socket://").rsplit(":", 1)
            self.connection = Connection(host, int(port))
            self.connection.ask("subscribe", events=list(events))
            named = self.connection.ask("sensors")["sensors"]
            self.sensors = {one["sensor"]: Sensor.on(self, one["sensor"]) for one in named}
            for sensor in self.sensors.values():
                sensor.check_rate(bit_rate)
        except BaseException:
            self.close()
            raise

    def _address(self, beginning: str) -> str:
        """The rest of the next line of the program, which has this beginning."""
        line = self.process.stdout.readline().strip()
        if not line.startswith(beginning):
            self.process.kill()
            raise BenchError(self.process.stderr.read().strip() or f"virtual-sensor has printed {line!r}")
        return line.removeprefix(beginning)

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __getitem__(self, name: str):
        """The sensor with this name."""
        return self.sensors[name]

    def close(self) -> None:
        """Ends the program. The content of a store stays."""
        if connection := getattr(self, "connection", None):
            connection.close()
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()

    def can_bus(self, **options: object):
        """A bus of python-can."""
        import can

        return can.Bus(interface="slcan", channel=self.channel, sleep_after_open=0, **options)

    def send(self, frame: str) -> None:
        """Sends a frame in the notation of cansend: 300#00."""
        self.connection.ask("send", frame=frame)

    def advance(self, seconds: float) -> list[Frame]:
        """Lets this time pass: virtual time, or that of the computer. Returns its frames; `events` has all its events."""
        events = []
        if self.virtual_time:
            while seconds > 0:
                self.connection.ask("advance", seconds=min(seconds, LONGEST))
                seconds -= LONGEST
            events = list(self.connection.events)
            self.connection.events.clear()
        else:
            end = time.monotonic() + seconds
            while (left := end - time.monotonic()) > 0:
                if event := self.connection.next_event(left):
                    events.append(event)
        self.events = events
        return [Frame.of_event(event) for event in events if event["event"] == "frame"]

    def wait(self, condition: Callable[[dict], bool], seconds: float = 10.0) -> dict:
        """The next event that meets the condition, within this time."""
        end = self.now() + seconds if self.virtual_time else time.monotonic() + seconds
        while True:
            while self.connection.events:
                if condition(event := self.connection.events.popleft()):
                    return event
            left = end - (self.now() if self.virtual_time else time.monotonic())
            if left <= 0:
                raise BenchError(f"there is no such event within {seconds} s")
            if self.virtual_time:
                self.connection.ask("advance", seconds=min(left, 0.01))
            elif event := self.connection.next_event(left):
                self.connection.events.append(event)

    def now(self) -> float:
        """The time of the bus in s."""
        return self.connection.ask("sensors")["time"]

    def wake(self, seconds: float = 10.0) -> None:
        """Sends frames until all sensors that detect the bit rate take part, and lets them send their boot-up messages."""
        rounds = int(seconds / 0.1)
        for _ in range(rounds):
            if all(sensor.state()["mode"] != "listen" for sensor in self.sensors.values()):
                self.advance(0.1)
                return
            self.send("7FF#55")
            self.advance(0.1)
        raise BenchError(f"not all sensors have detected the bit rate within {seconds} s")

    def exchange(self, frame: str, answer: int, seconds: float = 2.0) -> bytes:
        """Sends a frame and returns the data of the next frame with the identifier of the answer."""
        self.send(frame)

        def is_answer(event: dict) -> bool:
            return event["event"] == "frame" and event["sensor"] and Frame.of_event(event).identifier == answer

        return Frame.of_event(self.wait(is_answer, seconds)).data

    def lose(self, count: int = 1, sender: str = "sensors", identifier: str | None = None) -> None:
        """The next frames from the sensors (or `clients`) do not arrive at python-can (or on the bus)."""
        self.connection.ask("lose", count=count, identifier=identifier, **{"from": sender})

    def delay(self, seconds: float, count: int = 1, sender: str = "sensors", identifier: str | None = None) -> None:
        """They arrive late."""
        self.connection.ask("delay", seconds=seconds, count=count, identifier=identifier, **{"from": sender})

    def corrupt(self, count: int = 1) -> None:
        """The next frames are disturbed on the bus, and repeated."""
        self.connection.ask("corrupt", count=count)

    def hide_acknowledge(self, count: int = 1) -> None:
        """The senders of the next frames see no acknowledge."""
        self.connection.ask("hide-acknowledge", count=count)
