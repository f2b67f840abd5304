"""Checks ims360_j1939.dbc with cantools: attributes of J1939, the layout of the five groups, and the frames of the recorded traces.

Usage: j1939_dbc_check.py --descriptors PATH-OF-THE-PROGRAM --traces FOLDER
Prints one line for each check that fails, then `N passed, N failed`.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import cantools

SENSOR = 0x80

# SAE J1939-71 and -73: PGN, priority, cycle in ms as delivered, and the SPN of some signals.
GROUPS = {
    "SSI2": (61481, 3, 10, {"PitchAngleExRange": 4976, "RollAngleExRange": 4977, "PitchAngleExRangeFigureOfMerit": 4979,
                            "RollAngleExRangeFigureOfMerit": 4981, "RollAndPitchExRangeLatency": 4982}),
    "SSI": (61459, 3, None, {"PitchAngle": 3318, "RollAngle": 3319, "PitchRate": 3322, "PitchAngleFigureOfMerit": 3323,
                             "RollAngleFigureOfMerit": 3324, "PitchRateFigureOfMerit": 3325, "RollAndPitchMeasurementLatency": 3327}),
    "ARI": (61482, 3, None, {}),
    "ACCS": (61485, 3, None, {}),
    "DM1": (65226, 6, 1000, {"AmberWarningLamp": 624, "SuspectParameterNumber": 1214, "FailureModeIdentifier": 1215,
                             "OccurrenceCount": 1216, "ConversionMethod": 1706}),
}

# SAE J1939-21, -71 and -81: PGN, priority, destination, source, length.
PROTOCOL = {
    "AddressClaimed": (60928, 6, 0xFF, SENSOR, 8),
    "SoftwareIdentification": (65242, 6, None, SENSOR, 8),
    "Acknowledgement": (59392, 6, 0xFF, SENSOR, 8),
    "Request": (59904, 6, SENSOR, 0xFE, 3),
    "TransportControl": (60416, 7, 0xFF, SENSOR, 8),
    "TransportData": (60160, 7, 0xFF, SENSOR, 8),
    "TransportControlReceived": (60416, 7, SENSOR, 0xFE, 8),
    "TransportDataReceived": (60160, 7, SENSOR, 0xFE, 8),
    "CommandedAddress": (65240, 6, None, 0xFE, 9),
    "ObjectRequest": (61184, 6, SENSOR, 0xFE, 8),
    "ObjectResponse": (61184, 6, 0xFE, SENSOR, 8),
}

# The longest name in a database of Vector's tools.
NAME = 32

# Frames of a sensor and what they mean, calculated from the scales of SAE J1939-71.
FRAMES = [
    ("0CF02980#852B8300807A33FF", {"PitchAngleExRange": 12.34, "RollAngleExRange": -5.0, "PitchAngleExRangeFigureOfMerit": 0,
                                   "RollAngleExRangeFigureOfMerit": 0, "PitchAngleExRangeCompensation": 3}),
    ("0CF02980#0040509A197D3360", {"PitchAngleExRange": -89.5, "RollAngleExRange": 0.2,
                                                            "RollAndPitchExRangeLatency": 48.0}),
    ("0CF02980#0000AF00007D37FF", {"PitchAngleExRange": 100.0, "PitchAngleExRangeFigureOfMerit": 1, "RollAngleExRangeFigureOfMerit": 0}),
    ("0CF02980#000050FFFFFFF3FF", {"PitchAngleExRange": -90.0, "RollAngleExRangeFigureOfMerit": 3, "PitchAngleExRangeFigureOfMerit": 0}),
    ("0CF01380#1A953C73007DC060", {"PitchAngle": 12.34, "RollAngle": -5.0, "PitchRate": 0.0, "PitchAngleFigureOfMerit": 0,
                                   "RollAngleFigureOfMerit": 0, "PitchAndRollCompensated": 3, "RollAndPitchMeasurementLatency": 48.0}),
    ("0CF01380#FFFF647D10A4C360", {"RollAngle": 0.2, "PitchRate": 20.0, "PitchAngleFigureOfMerit": 3}),
    ("0CF02A80#00878075007DC0FF", {"PitchRateExRange": 20.0, "RollRateExRange": -15.0, "YawRateExRange": 0.0}),
    ("0CF02D80#007D007DD580C0FF", {"LateralAcceleration": 0.0, "LongitudinalAcceleration": 0.0, "VerticalAcceleration": 9.81}),
    ("18FECA80#00FF00000000FFFF", {"AmberWarningLamp": 0, "FlashAmberWarningLamp": 3, "SuspectParameterNumber": 0}),
    ("18FECA80#04FF70130001FFFF", {"AmberWarningLamp": 1, "RedStopLamp": 0, "SuspectParameterNumber": 4976, "FailureModeIdentifier": 0,
                                   "OccurrenceCount": 1, "ConversionMethod": 0}),
    ("18FECA80#04FF76020C7EFFFF", {"SuspectParameterNumber": 630, "FailureModeIdentifier": 12, "OccurrenceCount": 126}),
    ("18EEFF80#0100E0FF00910080", {"IdentityNumber": 1, "ManufacturerCode": 2047, "ECUInstance": 0, "FunctionInstance": 0, "Function": 145,
                                   "VehicleSystem": 0, "VehicleSystemInstance": 0, "IndustryGroup": 0, "ArbitraryAddressCapable": 1}),
    ("18EEFF80#A1BC3A1285460CA5", {"IdentityNumber": 0x1ABCA1, "ManufacturerCode": 0x91, "ECUInstance": 5,
                                   "FunctionInstance": 16, "Function": 0x46, "VehicleSystem": 6, "VehicleSystemInstance": 5,
                                   "IndustryGroup": 2, "ArbitraryAddressCapable": 1}),
    ("18E8FF80#01FFFFFF21EEFE00", {"Answer": 1, "Requester": 0x21, "AcknowledgedPGN": 0xFEEE}),
    ("18EA80FE#13F000", {"RequestedPGN": 61459}),
    ("1CECFF80#20140003FFEBFE00", {"Control": 32, "Parameters": 0xFF030014, "TransportedPGN": 65259}),
    ("1CEB80FE#0280A0FFFFFFFFFF", {"SequenceNumber": 2}),
    ("18EF80FE#2B04210214000000", {"Command": 0x2B, "Index": 0x2104, "Subindex": 2, "Contents": 20}),
]

counts = {True: 0, False: 0}


def check(what, got, expected):
    counts[got == expected] += 1
    if got != expected:
        print(f"FAIL {what}: expected {expected!r}, got {got!r}")


def near(what, got, expected):
    """The numbers agree within half of the smallest step."""
    close = got.keys() >= expected.keys() and all(abs(got[name] - value) < 0.00501 for name, value in expected.items())
    counts[close] += 1
    if not close:
        print(f"FAIL {what}: expected {expected!r}, got {got!r}")


def decode(database, text):
    number, data = text.split("#")
    return database.decode_message(int(number, 16), bytes.fromhex(data), decode_choices=False)


def layout(database):
    check("messages", {message.name for message in database.messages}, set(GROUPS) | set(PROTOCOL))
    for message in database.messages:
        for text in [message.name, *(signal.name for signal in message.signals)]:
            check(f"{message.name}: length of {text}", len(text) <= NAME, True)
    for name, (pgn, priority, destination, source, length) in PROTOCOL.items():
        message = database.get_message_by_name(name)
        number = priority << 26 | pgn << 8 | (destination or 0) << 8 | source
        check(f"{name}: identifier", (message.frame_id, message.is_extended_frame), (number, True))
        check(f"{name}: PGN", message.dbc.attributes["PGN"].value, pgn)
        check(f"{name}: length", message.length, length)
        check(f"{name}: sender", message.senders, ["Sensor"] if source == SENSOR else [])
    for message in database.messages:
        if message.name in PROTOCOL:
            continue
        pgn, priority, cycle, spns = GROUPS[message.name]
        name = message.name
        check(f"{name}: identifier", (message.frame_id, message.is_extended_frame), (priority << 26 | pgn << 8 | SENSOR, True))
        parts = cantools.j1939.frame_id_unpack(message.frame_id)
        group = cantools.j1939.pgn_pack(parts.reserved, parts.data_page, parts.pdu_format, parts.pdu_specific)
        check(f"{name}: PGN of the identifier", group, pgn)
        check(f"{name}: PGN", message.dbc.attributes["PGN"].value, pgn)
        check(f"{name}: VFrameFormat", message.protocol, "j1939")
        check(f"{name}: GenMsgCycleTime", message.cycle_time or None, cycle)
        check(f"{name}: length", (message.length, message.senders), (8, ["Sensor"]))
        for signal, spn in spns.items():
            check(f"{name}: SPN of {signal}", message.get_signal_by_name(signal).spn, spn)
        used = sum(signal.length for signal in message.signals)
        check(f"{name}: bits", used, 64 if name != "DM1" else 48)
        for signal in message.signals:
            if signal.name.endswith("FigureOfMerit"):
                names = [str(signal.choices[number]) for number in range(4)]
                check(f"{name}: {signal.name}", names, ["fully functional", "degraded", "error", "not available"])
    node = database.get_node_by_name("Sensor").dbc.attributes
    fields = {"NmStationAddress": 128, "NmJ1939AAC": 1, "NmJ1939Function": 145, "NmJ1939ManufacturerCode": 2047,
              "NmJ1939IndustryGroup": 0, "NmJ1939ECUInstance": 0}
    check("NAME", {name: node[name].value for name in fields}, fields)
    check("ProtocolType", database.dbc.attributes["ProtocolType"].value, "J1939")


def traffic(database, folder):
    """Every frame of a sensor in the traces that is in the database; another address has the same signals."""
    line = re.compile(r"\([\d.]+\) can0 ([0-9A-F]{8})#([0-9A-F]{16}) R")
    known = {message.frame_id & 0x3FFFF00: message for message in database.messages if message.name in GROUPS}
    seen = {name: 0 for name in GROUPS}
    for path in sorted(folder.glob("ims360-j1939-*.log")):
        for number, data in line.findall(path.read_text()):
            message = known.get(int(number, 16) & 0x3FFFF00)
            if message is None:
                continue
            seen[message.name] += 1
            values = message.decode(bytes.fromhex(data), decode_choices=False)
            again = message.encode({name: values[name] for name in values}, strict=False)
            # DM1 has no signals in the last two bytes.
            size = 6 if message.name == "DM1" else 8
            check(f"{path.name}: {number}#{data}", again[:size].hex().upper(), data[: 2 * size])
            for signal in message.signals:
                raw = signal.name.endswith("FigureOfMerit")
                check(f"{path.name}: {signal.name}", not raw or values[signal.name] in (0, 1, 2, 3), True)
            if path.name == "ims360-j1939-process-data.log" and message.name != "DM1":
                level = {"VerticalAcceleration": 9.81}
                angles = [name for name in values if re.fullmatch(r"(Pitch|Roll)(Angle|Rate)(ExRange)?|(Yaw)RateExRange|L\w+lAcceleration", name)]
                near(f"{path.name}: {number}#{data}", values, {name: level.get(name, 0.0) for name in angles})
    for name, count in seen.items():
        check(f"{name} is in the traces", count > 0, True)


def protocol(database, folder):
    """Every frame of the traces, also those to the sensor, has a message that decodes it in the strict default of cantools."""
    line = re.compile(r"\([\d.]+\) can0 ([0-9A-F]{8})#([0-9A-F]*) ([RT])")
    names = {}
    for name, (pgn, _, _, source, _) in PROTOCOL.items():
        names[pgn, "R" if source == SENSOR else "T"] = name
    # Each node claims its address.
    names[60928, "T"] = "AddressClaimed"
    names |= {(pgn, "R"): name for name, (pgn, *_) in GROUPS.items()}
    seen = set()
    for path in sorted(folder.glob("ims360-j1939-*.log")):
        for number, data, direction in line.findall(path.read_text()):
            number, data = int(number, 16), bytes.fromhex(data)
            pgn = number >> 8 & 0x3FFFF
            pgn = pgn if pgn & 0xFF00 >= 0xF000 else pgn & 0x3FF00
            name = names.get((pgn, direction))
            if direction == "R":
                check(f"{path.name}: {number:08X} is known", name is not None, True)
            # Frames that the sensor must ignore are in the traces too.
            if name is None or direction == "T" and len(data) < database.get_message_by_name(name).length:
                continue
            values = database.get_message_by_name(name).decode(data)
            check(f"{path.name}: {number:08X}#{data.hex()}", len(values) > 0, True)
            seen.add(name)
    check("messages in the traces", set(names.values()) - seen, {"CommandedAddress"})


def offsets(database, path):
    """The angles of a level sensor are its zero offsets, which the trace writes: 3210h and 3220h in 0.01 deg."""
    line = re.compile(r" ([0-9A-F]{8})#([0-9A-F]{16}) ([TR])")
    known = {"0CF02980": ("PitchAngleExRange", "RollAngleExRange"), "0CF01380": ("PitchAngle", "RollAngle")}
    written = {"103200": 0, "203200": 0}
    counted = 0
    for number, data, direction in line.findall(path.read_text()):
        if direction == "T" and data[:2] == "23" and data[2:8] in written:
            written[data[2:8]] = int.from_bytes(bytes.fromhex(data[8:]), "little", signed=True) / 100
        if direction == "R" and number in known:
            values = database.decode_message(int(number, 16), bytes.fromhex(data), decode_choices=False)
            for name, angle in zip(known[number], written.values(), strict=True):
                # 3: beyond the range of the field.
                if values[f"{name}FigureOfMerit"] != 3:
                    near(f"{path.name}: {number}#{data}", values, {name: angle})
                    counted += 1
    check("angles by offsets", counted > 30, True)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--descriptors", required=True)
    options.add_argument("--traces", required=True, type=pathlib.Path)
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([options.descriptors, "--out", folder], check=True, stdout=subprocess.DEVNULL)
        database = cantools.database.load_file(pathlib.Path(folder, "ims360_j1939.dbc"), strict=True)
    layout(database)
    for text, expected in FRAMES:
        near(text, decode(database, text), expected)
    named = database.decode_message(0x18FECA80, bytes.fromhex("04FF70130001FFFF"))
    check("names of DM1", [str(named[name]) for name in ("AmberWarningLamp", "SuspectParameterNumber", "FailureModeIdentifier")],
          ["on", "PitchAngleExRange", "above normal"])
    traffic(database, options.traces)
    protocol(database, options.traces)
    offsets(database, options.traces / "ims360-j1939-angles.log")
    print(f"{counts[True]} passed, {counts[False]} failed")
    return counts[False] != 0


if __name__ == "__main__":
    sys.exit(main())
