"""Checks a Device Configuration File of `plumbline backup` with python-canopen.

Usage: dcf_check.py FILE NODE-ID KBITS INDEX:SUB=VALUE...
The numbers are hexadecimal, except node-ID and bit rate. Prints one line for each check that fails.
"""

import sys

import canopen


def main():
    file, node, kbits, *values = sys.argv[1:]
    dictionary = canopen.import_od(file)
    failures = []

    def check(what, got, expected):
        if got != expected:
            failures.append(f"{what}: {got!r} instead of {expected!r}")

    check("node-ID", dictionary.node_id, int(node))
    check("bit rate", dictionary.bitrate, int(kbits) * 1000)
    for text in values:
        address, value = text.split("=")
        index, sub = (int(part, 16) for part in address.split(":"))
        entry = dictionary[index]
        variable = entry if isinstance(entry, canopen.objectdictionary.ODVariable) else entry[sub]
        check(address, variable.value, int(value, 16))
    print("\n".join(failures))
    return bool(failures)


if __name__ == "__main__":
    sys.exit(main())
