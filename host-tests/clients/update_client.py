#!/usr/bin/env python3
"""Loads a program with python-canopen, a public CANopen master, into a sensor that has only its bootloader: by blocks, then in segments.

    pip install -r requirements.txt
    python update_client.py --virtual-sensor ../../target/release/virtual-sensor --bootloader ELF --image FILE

FILE is for the jn2101. Prints one line for each check that fails and the count; the exit code is 1 if a check failed.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import canopen
from canopen.sdo import SdoClient

SdoClient.RESPONSE_TIMEOUT = 60.0  # s; a busy computer answers late

# Without a boot record the bootloader has this node-ID.
NODE = 127
FILE, CONTROL, CRC, STATUS = (0x1F50, 1), (0x1F51, 1), (0x1F56, 1), (0x1F57, 1)
NO_PROGRAM = 1 << 1
TIME_OUT = 0x05040000

counts = {True: 0, False: 0}


def check(what, got, expected):
    """Compares, prints and counts."""
    counts[got == expected] += 1
    if got != expected:
        print(f"FAILED {what}: expected {expected!r}, got {got!r}")


def number(sdo, address):
    return int.from_bytes(sdo.upload(*address), "little")


def load(sdo, image, blocks):
    """Loads the image, and checks what the bootloader says of it."""
    kind = "blocks" if blocks else "segments"
    while True:
        sdo.download(*CONTROL, b"\x03")
        check(f"{kind}: status after clear", number(sdo, STATUS) & ~NO_PROGRAM, 0)
        try:
            with sdo.open(*FILE, "wb", size=len(image), block_transfer=blocks) as file:
                file.write(image)
            break
        except canopen.SdoAbortedError as error:
            # A busy computer has paused for longer than the time-out of the bootloader, 1 s.
            if error.code != TIME_OUT:
                raise
    check(f"{kind}: status", number(sdo, STATUS), 0)
    check(f"{kind}: CRC", number(sdo, CRC), int.from_bytes(image[20:24], "little"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--virtual-sensor", required=True)
    parser.add_argument("--bootloader", required=True)
    parser.add_argument("--image", required=True, type=Path)
    options = parser.parse_args()
    command = [options.virtual_sensor, "--model", "jn2101", "--listen", "127.0.0.1:0"]
    command += ["--bootloader", options.bootloader]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    address = process.stdout.readline().removeprefix("slcan ").strip()
    network = canopen.Network()
    network.connect(interface="slcan", channel=address, sleep_after_open=0)
    try:
        sdo = network.add_node(NODE, canopen.ObjectDictionary()).sdo
        check("device type", number(sdo, (0x1000, 0)), 0)
        check("status", number(sdo, STATUS), NO_PROGRAM)
        image = options.image.read_bytes()
        load(sdo, image, blocks=True)
        load(sdo, image, blocks=False)
        try:
            with sdo.open(*FILE, "wb", size=len(image), block_transfer=True) as file:
                file.write(image)
            check("without clear", "accepted", "refused")
        except canopen.SdoAbortedError as error:
            check("without clear", error.code, 0x08000022)
    finally:
        network.disconnect()
        process.kill()
        process.wait()
    print(f"{counts[True]} passed, {counts[False]} failed")
    sys.exit(counts[False] > 0)


main()
