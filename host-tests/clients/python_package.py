#!/usr/bin/env python3
"""Runs the tests and the examples of the Python package (host-tests/python) with the virtual sensor.

    pip install -r requirements.txt
    python python_package.py --virtual-sensor ../../target/release/virtual-sensor

The exit code is that of pytest.
"""

import argparse
import os
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "python"

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--virtual-sensor", required=True)
os.environ["PLUMBLINE_VIRTUAL_SENSOR"] = parser.parse_args().virtual_sensor
# An installation from the folder leaves there a description of the package, by which pytest would load the plugin a second time.
os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
sys.dont_write_bytecode = True
sys.path.insert(0, str(PACKAGE / "src"))
plugins = ["-p", "plumbline_bench.fixtures", "-p", "no:cacheprovider"]
sys.exit(pytest.main(["-q", *plugins, str(PACKAGE / "tests"), str(PACKAGE / "examples")]))
