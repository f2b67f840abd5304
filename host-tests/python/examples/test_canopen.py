"""python-canopen with a JN2101, in the time of the computer."""

import canopen
import pytest


@pytest.mark.sensor("jn2101", tilt=(10, 0))
def test_master_reads_angle_and_sees_restart(sensor):
    network = canopen.Network()
    network.connect(interface="slcan", channel=sensor.channel, sleep_after_open=0)
    try:
        node = network.add_node(10, canopen.ObjectDictionary())
        node.sdo.RESPONSE_TIMEOUT = 20
        angle = int.from_bytes(node.sdo.upload(0x6010, 0), "little", signed=True)
        assert angle == 1000  # 0.01 deg
        sensor.restart()
        node.nmt.wait_for_bootup(20)
    finally:
        network.disconnect()
