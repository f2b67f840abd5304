"""The package with the program: starts, wrong arguments, events, several sensors."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from plumbline_bench import Bench, BenchError, Sensor, find_program


def test_marker_of_fixture_is_optional(sensor):
    assert sensor.state()["model"] == "is2"


@pytest.mark.parametrize("rate", [50_000, 125_000, 1_000_000])
def test_sensor_that_detects_the_rate_runs_at_any(rate):
    with Sensor("is1", tilt=(45, 0), bit_rate=rate, virtual_time=True) as sensor:
        sensor.bench.wake()
        assert sensor.state()["bit_rate"] == rate
        assert sensor.bench.exchange("300#00", 0x301)[0] == 0x00


def test_rate_of_sensor_that_does_not_detect_it_is_named():
    with pytest.raises(BenchError, match="jn2101 has 125000 bit/s, not 500000"):
        Sensor("jn2101", bit_rate=500_000)


def test_message_of_program_is_that_of_the_exception():
    with pytest.raises(BenchError, match="is3"):
        Sensor("is3")
    with pytest.raises(BenchError, match="91,0"):
        Sensor("is2", tilt=(91, 0))
    with pytest.raises(BenchError, match="either a tilt or a scene"):
        Sensor("is2", tilt=(1, 0), scene="a.csv")
    with pytest.raises(BenchError, match="not a file"), pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLUMBLINE_VIRTUAL_SENSOR", "/nowhere")
        Sensor("is2")


def test_installation_from_the_folder_of_the_project_has_its_program(tmp_path):
    if "CI" not in os.environ:
        pytest.importorskip("setuptools")
    package = tmp_path / "host-tests" / "python"
    shutil.copytree(Path(__file__).parents[1], package)
    built = tmp_path / "target" / "release" / Path(find_program()).name
    built.parent.mkdir(parents=True)
    built.write_bytes(b"the program")
    (tmp_path / "Cargo.toml").touch()
    unset = ("PLUMBLINE_VIRTUAL_SENSOR", "CARGO_TARGET_DIR")
    environment = {name: value for name, value in os.environ.items() if name not in unset}
    command = [sys.executable, "setup.py", "--quiet", "build_py", "--build-lib", "lib"]
    subprocess.run(command, cwd=package, env=environment, check=True)
    installed = package / "lib" / "plumbline_bench" / "bin" / built.name
    assert installed.read_bytes() == b"the program"


def test_sensor_moves_and_breaks_in_virtual_time(tmp_path):
    store = tmp_path / "is2.store"
    with Sensor("is2", tilt=(0, 0), store=store, virtual_time=True) as sensor:
        bench = sensor.bench
        bench.exchange("300#00", 0x301)
        assert sensor.rate(5, 1, seconds=2)["to"] == [10, 2]
        bench.advance(4)
        sensor.restart()
        bench.advance(61)
        assert {event["event"] for event in bench.events} == {"leds", "state", "stored"}
        # The usage, ten seconds after the second start.
        assert [event["programmed"] for event in bench.events if event["event"] == "stored"] == [44]
        bench.wake()
        assert sensor.state()["angles"] == [10, 2]
        with pytest.raises(BenchError, match="does not exist"):
            sensor.tilt(80, 80)
        bench.send("300#5053415645")  # SAVE
        stored = bench.wait(lambda event: event["event"] == "stored")
        assert stored["programmed"] > 0
        sensor.bus_off()
        bench.send("300#00")
        bench.wait(lambda event: event.get("bus") == "bus-off")
        sensor.power(False)
        assert sensor.state()["angles"] is None
        with pytest.raises(BenchError, match="within 0.5 s"):
            bench.wait(lambda event: event["event"] == "frame", seconds=0.5)
    assert any(store.read_bytes())


def test_lost_frame_is_on_the_bus_but_not_at_python_can():
    with Sensor("is2", tilt=(3, 4)) as sensor:
        bench = sensor.bench
        bench.wake()
        bench.exchange("300#15", 0x301, seconds=20)
        with bench.can_bus() as bus:
            assert None not in bus.get_version(20)  # its channel is open
            bench.lose(1, identifier="301")
            for code in ("00", "15"):
                bench.exchange(f"300#{code}", 0x301, seconds=20)
            codes = [(message.arbitration_id, message.data[0]) for message in (bus.recv(20) for _ in range(3))]
    assert codes == [(0x300, 0x00), (0x300, 0x15), (0x301, 0x15)]


def test_sensors_of_one_bench_have_names():
    one, other = ("jn2101", {"tilt": (1, 2)}), ("ims360", {"tilt": (-5, 0)})
    with Bench(one, other, bit_rate=125_000, virtual_time=True) as bench:
        assert list(bench.sensors) == ["jn2101", "ims360"]
        bench["jn2101"].tilt(20, 0)
        frames = bench.advance(2)
        assert {frame.sensor for frame in frames} == {"jn2101", "ims360"}
        assert bench["jn2101"].state()["angles"] == [20, 0]
