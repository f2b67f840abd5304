"""GEMAC's function select codes: a PLC polls an IS2 whose accelerometer fails. In virtual time, so it takes no time."""

import struct

import pytest


@pytest.mark.sensor("is2", tilt=(0, 0), virtual_time=True)
def test_plc_sees_angle_and_fault(sensor):
    bench = sensor.bench
    bench.wake()  # the sensor detects the bit rate
    sensor.tilt(12.34, -5.67)
    bench.advance(1)
    code, status, x, y = struct.unpack("<BBhh", bench.exchange("300#00", 0x301))
    assert (code, status, x, y) == (0x00, 0x03, 1234, -567)

    sensor.accelerometer("silent")
    bench.advance(1)
    _, status, *_ = bench.exchange("300#00", 0x301)
    assert status == 0x33  # sensor error of both axes
