"""A virtual sensor: its motion, its faults and its state."""

import os
from collections.abc import Iterable

from .bench import Bench
from .connection import BenchError


def options_of(
    tilt: tuple[float, float] | None = None,
    scene: str | os.PathLike | None = None,
    store: str | os.PathLike | None = None,
    article: str | None = None,
    elf: str | os.PathLike | None = None,
    serial: int | None = None,
    faults: Iterable[str] = (),
) -> list[str]:
    """The options of a sensor on the command line: at rest with these angles or a CSV file, a file as nonvolatile memory, an article, a
    firmware image, a serial number, and faults of the accelerometer from a time on (`silent@2`)."""
    if tilt is not None and scene is not None:
        raise BenchError("a sensor has either a tilt or a scene")
    scene = f"tilt={tilt[0]},{tilt[1]}" if tilt is not None else scene
    named = {"scene": scene, "store": store, "article": article, "elf": elf, "serial": serial}
    options = [f"--{name}={value}" for name, value in named.items() if value is not None]
    return options + [f"--fault=accelerometer={fault}" for fault in faults]


class Sensor:
    """A sensor of any product. Alone on its bus it is a context manager; `Bench` has several.

    `model` and the options of `options_of` select the sensor; `bit_rate` (in bit/s), `virtual_time`, `log` and `program` are those of
    `Bench`.
    """

    def __init__(
        self,
        model: str = "is2",
        *,
        bit_rate: int | None = None,
        virtual_time: bool = False,
        log: str | None = None,
        program: str | None = None,
        **options: object,
    ):
        bench = Bench((model, options), bit_rate=bit_rate, virtual_time=virtual_time, log=log, program=program)
        self.bench = bench
        self.name = next(iter(bench.sensors))

    @classmethod
    def on(cls, bench: Bench, name: str) -> "Sensor":
        """The sensor with this name of a bench."""
        sensor = cls.__new__(cls)
        sensor.bench, sensor.name = bench, name
        return sensor

    def __enter__(self) -> "Sensor":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the bench of the sensor."""
        self.bench.close()

    def ask(self, do: str, **members: object) -> dict:
        """Sends a request to this sensor: see the README of virtual-sensor."""
        return self.bench.connection.ask(do, sensor=self.name, **members)

    def check_rate(self, bit_rate: int | None) -> None:
        """Refuses a bus with another rate than that of a sensor that does not detect it."""
        state = self.state()
        own = state["bit_rate"]
        if bit_rate and state["mode"] == "normal" and own != bit_rate:
            raise BenchError(f"{self.name} has {own} bit/s, not {bit_rate}: set it in a store, or omit bit_rate")

    @property
    def channel(self) -> str:
        """The channel for python-can: can.Bus(interface="slcan", channel=sensor.channel, sleep_after_open=0)."""
        return self.bench.channel

    def state(self) -> dict:
        """Power, bus, LEDs, angles, surroundings, faults, memory."""
        return self.ask("state")

    def image(self) -> dict:
        """The nonvolatile memory and the stored parameters, in hexadecimal."""
        return self.ask("image")

    def tilt(self, x: float, y: float = 0.0) -> None:
        """At rest with these angles in degrees; with one axis X is the angle, Y the cross slope."""
        self.ask("tilt", x=x, y=y)

    def rate(self, x: float, y: float = 0.0, seconds: float | None = None) -> dict:
        """Turns from the present angles with these rates in deg/s, for this time."""
        return self.ask("rate", x=x, y=y, seconds=seconds)

    def sine(self, x: float, y: float = 0.0, hertz: float = 1.0) -> None:
        """Oscillates around the present angles with these amplitudes in degrees."""
        self.ask("sine", x=x, y=y, hertz=hertz)

    def scene(self, csv: str) -> dict:
        """A motion from now on: the text of a CSV file with the columns t_s,ax_g,ay_g,az_g and others."""
        return self.ask("scene", csv=csv)

    def temperature(self, celsius: float | None) -> None:
        """The temperature around the sensor; None: that of the scene."""
        self.ask("temperature", celsius=celsius)

    def supply(self, volts: float | None) -> None:
        """The supply of the sensor; None: that of the scene."""
        self.ask("supply", volts=volts)

    def accelerometer(self, fault: str | None) -> None:
        """A fault: silent, stopped, frozen, zero, axis-x, axis-y, axis-z or clipping; None: it works."""
        self.ask("accelerometer", fault=fault)

    def memory(self, fault: str | None) -> None:
        """A fault of the nonvolatile memory: programming or erasing; None: it works."""
        self.ask("memory", fault=fault)

    def damage(self) -> None:
        """Damages what was saved last."""
        self.ask("damage")

    def power(self, on: bool) -> None:
        """Switches the supply on or off."""
        self.ask("power", on=on)

    def restart(self) -> None:
        """Switches the supply off and on."""
        self.ask("restart")

    def cut_in_save(self, operations: int, seed: int = 0) -> None:
        """Cuts the power in the operation of the memory after this many others."""
        self.ask("cut-in-save", operations=operations, seed=seed)

    def bus_off(self) -> None:
        """Disturbs the frames of the sensor until it is bus-off."""
        self.ask("bus-off")

    def corrupt(self, count: int = 1) -> None:
        """Disturbs the next frames of this sensor, which it repeats."""
        self.ask("corrupt", count=count)
