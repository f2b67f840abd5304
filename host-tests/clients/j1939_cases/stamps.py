"""The sensor's own time of each frame: the slcan time stamp, in milliseconds from 0 to 59999."""

from can.interfaces.slcan import slcanBus
from gemac.harness import REPLY_TIMEOUT, Frame, Tester

WRAP = 60_000


class StampedBus(slcanBus):
    """The slcan driver, with time stamps switched on before the channel is opened."""

    stamp: int | None = None
    time = 0.0

    def open(self) -> None:
        """Opens the channel."""
        self._write("Z1")
        super().open()

    def _read(self, timeout: float | None) -> str | None:
        line = super()._read(timeout)
        if line and line[0] in "tTrR":
            head = 10 if line[0] in "TR" else 5
            data = 0 if line[0] in "rR" else 2 * int(line[head - 1])
            stamp = int(line[head + data :], 16)
            if self.stamp is not None:
                self.time += (stamp - self.stamp) % WRAP / 1000.0
            self.stamp = stamp
        return line


class StampedTester(Tester):
    """An adapter whose frames have `sent`: seconds on the sensor's clock."""

    def __init__(self, port: int) -> None:
        self._bus = StampedBus(channel=f"socket://127.0.0.1:{port}", sleep_after_open=0)
        self._missed = 0

    def receive(self, timeout: float = REPLY_TIMEOUT) -> Frame | None:
        """The next frame from the bus, with the time stamp."""
        frame = super().receive(timeout)
        if frame:
            object.__setattr__(frame, "sent", self._bus.time)
        return frame

    @property
    def time(self) -> float:
        """The time stamp of the last frame, in s."""
        return self._bus.time
