"""The pytest plugin: `pip install` activates it."""

import pytest

from .sensor import Sensor


def pytest_configure(config: pytest.Config) -> None:
    """Describes the marker of the fixture."""
    config.addinivalue_line("markers", "sensor(model, **options): the arguments of plumbline_bench.Sensor for the fixture `sensor`")


@pytest.fixture
def sensor(request: pytest.FixtureRequest):
    """A virtual sensor with the arguments of the marker `sensor`; an is2 without one."""
    marker = request.node.get_closest_marker("sensor")
    arguments, options = (marker.args, marker.kwargs) if marker else ((), {})
    with Sensor(*arguments, **options) as started:
        yield started
