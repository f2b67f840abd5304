#!/usr/bin/env python3
"""Lets Wireshark's dissectors for DeviceNet and CIP read the traffic of the virtual sensors tiltix080 and tiltix360.

    pip install -r requirements.txt
    python devicenet_tshark.py --virtual-sensor ../../target/release/virtual-sensor

Needs tshark. Three files are read: the log of the sensor; explicit messages with the identifier of a group 3 message, because the
dissector decodes only those; requests and replies as EtherNet/IP, for the CIP dissector. Prints one line per check and the count;
the exit code is 1 if a check failed.
"""

import sys

from devicenet_cases import cases_tshark, runner

GROUPS = {group.__name__: group for group in cases_tshark.GROUPS}


def main() -> int:
    """Runs the groups; returns the exit code."""
    options, arguments = runner.parse(__doc__.splitlines()[0], GROUPS)
    return runner.run(options, arguments, GROUPS)


if __name__ == "__main__":
    sys.exit(main())
