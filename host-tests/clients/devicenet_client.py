#!/usr/bin/env python3
"""Runs devicenet-py, a public DeviceNet master, with the virtual sensors tiltix080 and tiltix360.

    pip install -r requirements.txt
    pip install --no-deps --ignore-requires-python -r requirements-no-deps.txt
    python devicenet_client.py --virtual-sensor ../../target/release/virtual-sensor

Needs Python 3.11. Prints one line per check and the count; the exit code is 1 if a check failed.
The allocation is sent as a frame: devicenet-py sends it on the explicit connection, with the MAC ID in other bits of its last
byte.
"""

import sys

from devicenet_cases import cases_client, runner

GROUPS = {group.__name__: group for group in cases_client.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, GROUPS)


if __name__ == "__main__":
    sys.exit(main())
