"""Virtual CAN inclination sensors for test benches: starts them, moves them and breaks them.

    from plumbline_bench import Sensor

    with Sensor("is2", tilt=(0, 0), virtual_time=True) as sensor:
        sensor.tilt(12.34, -5.67)
        sensor.bench.advance(1)
        print(sensor.state()["angles"])
"""

from .bench import Bench
from .connection import BenchError, Frame
from .program import find_program
from .sensor import Sensor

__all__ = ["Bench", "BenchError", "Frame", "Sensor", "find_program"]
