"""Checks the CAN databases of `descriptors` with cantools: they load, and they decode and encode the frames of the manual.

Usage: dbc_check.py --descriptors PATH-OF-THE-PROGRAM
Prints one line for each check that fails, then `N passed, N failed`.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import cantools

# Codes of table 17; 1-axis sensors have no 19h and 29h.
FUNCTIONS = {0x00, 0x02, 0x03, 0x04, 0x40, 0x50, 0xFF}
READS = set(range(0x10, 0x1A))
WRITES = set(range(0x20, 0x2A))

counts = {True: 0, False: 0}


def check(what, got, expected):
    counts[got == expected] += 1
    if got != expected:
        print(f"FAIL {what}: expected {expected!r}, got {got!r}")


def decode(database, data):
    """The decoded reply, with numbers instead of names."""
    return database.decode_message(0x301, bytes(data), decode_choices=False, allow_truncated=True)


# The longest name in a database of Vector's tools.
NAME = 32


def names(name, database):
    """The names of messages, signals and nodes."""
    for message in database.messages:
        for text in [message.name, *message.senders, *(signal.name for signal in message.signals)]:
            check(f"{name}: length of {text}", len(text) <= NAME, True)


def decodes(name, database, codes):
    """Every frame decodes in the way that the comments of its message say."""
    for message in ("SetParameter", "ReplyParameter"):
        comment = database.get_message_by_name(message).comment
        check(f"{name}: comment of {message}", "allow_truncated=True" in comment, True)
    check(f"{name}: sync", database.decode_message(0x100, b""), {})
    for code in codes:
        for size in range(8):
            request = database.decode_message(0x300, bytes([code] + [0xFF] * size), allow_truncated=True)
            check(f"{name}: request {code:02X}, {size}", "FSC" in request, True)
        for size in range(1, 8):
            reply = database.decode_message(0x301, bytes([code] + [0] * size), allow_truncated=True)
            check(f"{name}: reply {code:02X}, {size}", "CmdParamError" in reply, True)


def signals(database, data):
    """The decoded signals without code and status bits."""
    bits = {signal.name for signal in database.get_message_by_name("ReplyParameter").signals if signal.length == 1}
    return {name: value for name, value in decode(database, data).items() if name not in bits | {"FSC"}}


def common(name, database, codes):
    request = database.get_message_by_name("SetParameter")
    reply = database.get_message_by_name("ReplyParameter")
    sync = database.get_message_by_name("Sync")
    check(f"{name}: factory identifiers", (request.frame_id, reply.frame_id, sync.frame_id), (0x300, 0x301, 0x100))
    check(f"{name}: lengths", (request.length, reply.length, sync.length), (8, 8, 0))
    for message in (request, reply):
        choices = message.get_signal_by_name("FSC").choices
        check(f"{name}: codes of {message.name}", set(choices), codes)

    check(f"{name}: 03h", signals(database, [0x03, 0, 0x96, 0x2D, 0x23, 0, 1, 0]),
          {"ProductNumber": 2305430, "Revision": 1})
    check(f"{name}: 04h", signals(database, [0x04, 0, 1, 0, 0, 0, 0x44, 0x03]),
          {"SerialNumber": 1, "SoftwareVersion": 0x0344})
    check(f"{name}: 10h", signals(database, [0x10, 0, 0x61, 3, 0, 0x80]), {"SetParameterID": 0x80000361})
    check(f"{name}: 13h", signals(database, [0x13, 0, 6]), {"BaudRate": 6})
    check(f"{name}: 15h", signals(database, [0x15, 0, 250, 0]), {"CyclicTime": 250})
    check(f"{name}: 17h", signals(database, [0x17, 0, 0xD0, 0x07, 2]), {"CutOffFrequency": 2000, "FilterType": 2})
    check(f"{name}: boot-up", signals(database, [0xFF, 3, 0, 3, 0, 0, 0x44, 3]),
          {"ActiveSetParameterID": 0x300, "AliveSoftwareVersion": 0x0344})
    status = decode(database, [0x02, 0x0F])
    check(f"{name}: status bits", [status[bit] for bit in
          ("DefaultParam", "AutobaudDetection", "EEPROMError", "CmdParamError", "AccuracyWarning")], [1, 1, 1, 1, 0])
    check(f"{name}: AccuracyWarning", decode(database, [0x02, 0x40])["AccuracyWarning"], 1)

    names(name, database)
    decodes(name, database, codes)
    for data, signal in ((b"\x40LOAD", "LoadDefaultsSignature"), (b"\x50SAVE", "SaveSignature"),
                         (b"\xFFRESET", "AliveOrResetSignature")):
        text = str(database.decode_message(0x300, data, allow_truncated=True)[signal])
        check(f"{name}: text of {signal}", text, data[1:].decode())

    def encode(**values):
        # A multiplexed message has only the signals of its code.
        return database.encode_message("SetParameter", values).hex()

    check(f"{name}: filter written", encode(FSC=0x27, CutOffFrequency=25000, FilterType=1)[:8], "27a86101")
    check(f"{name}: baud rate written", encode(FSC=0x23, BaudRate=7)[:4], "2307")
    check(f"{name}: saved", encode(FSC=0x50, SaveSignature=int.from_bytes(b"SAVE", "little"))[:10], b"\x50SAVE".hex())
    reset = encode(FSC=0xFF, AliveOrResetSignature=int.from_bytes(b"RESET", "little"))
    check(f"{name}: reset", reset[:12], b"\xffRESET".hex())


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--descriptors", required=True)
    program = options.parse_args().descriptors
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "--out", folder], check=True, stdout=subprocess.DEVNULL)
        load = lambda name: cantools.database.load_file(pathlib.Path(folder, f"{name}.dbc"), strict=True)
        for name in ("is2", "is2d", "is2dm", "is2tk"):
            database = load(name)
            common(name, database, FUNCTIONS | READS | WRITES)
            # The manual's conversion: value / 100, two's complement; with the counter while cyclic mode is on.
            check(f"{name}: 00h", signals(database, [0, 0, 0xD2, 0x04, 0xC9, 0xFD]), {"AngleX": 12.34, "AngleY": -5.67})
            check(f"{name}: 00h cyclic", signals(database, [0, 0, 0xD2, 0x04, 0xC9, 0xFD, 1, 1]),
                  {"AngleX": 12.34, "AngleY": -5.67, "CyclicCounter": 257})
            check(f"{name}: 19h", signals(database, [0x19, 0, 0xD8, 0xDC]), {"ZeroOffsetY": -90.0})
            status = decode(database, [0x02, 0x20])
            check(f"{name}: SensorErrorY", (status["SensorErrorX"], status["SensorErrorY"]), (0, 1))
            check(f"{name}: zero offset written",
                  database.encode_message("SetParameter", {"FSC": 0x28, "ZeroOffsetX": -90.0}).hex()[:6], "28d8dc")
        for name in ("is1", "is1d", "is1dm", "is1tk"):
            database = load(name)
            common(name, database, FUNCTIONS | READS - {0x19} | WRITES - {0x29})
            # The manual's example: 1065 / 100 = 10.65 deg.
            check(f"{name}: 00h", signals(database, [0, 0, 0x29, 0x04]), {"Angle": 10.65})
            check(f"{name}: 00h cyclic", signals(database, [0, 0, 0x9F, 0x8C, 1, 0]), {"Angle": 359.99, "CyclicCounter": 1})
            check(f"{name}: 18h", signals(database, [0x18, 0, 0x9F, 0x8C]), {"ZeroOffset": 359.99})
            check(f"{name}: SensorError", decode(database, [0x02, 0x10])["SensorError"], 1)
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
