"""can-j1939 with an IMS360 that 3100h:01 has set to J1939, in the time of the computer."""

import queue

import j1939
import pytest

SLOPE = 61481  # SSI2: pitch and roll in 1/32768 deg, from -250 deg


@pytest.mark.sensor("ims360", tilt=(10, 0))
def test_controller_receives_slope(sensor):
    for write in ("2F00310101000000", "2310100173617665"):  # 3100h:01 = J1939, 1010h:01 = save
        assert sensor.bench.exchange(f"632#{write}", 0x5B2)[0] == 0x60
    sensor.restart()
    received = queue.Queue()
    ecu = j1939.ElectronicControlUnit()
    ecu.connect(interface="slcan", channel=sensor.channel, sleep_after_open=0)
    try:
        ecu.subscribe(lambda _priority, pgn, _source, _time, data: received.put((pgn, bytes(data))))
        data = next(data for pgn, data in iter(lambda: received.get(timeout=20), None) if pgn == SLOPE)
        pitch, roll = (int.from_bytes(data[at : at + 3], "little") / 32768 - 250 for at in (0, 3))
        assert (pitch, roll) == pytest.approx((10, 0), abs=0.01)
    finally:
        ecu.disconnect()
