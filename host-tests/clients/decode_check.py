#!/usr/bin/env python3
"""Compares what `plumbline decode` says about mixed traffic with what cantools and the dissectors of Wireshark say.

    python decode_check.py --folder FOLDER

The folder has mixed.json (the documents of `plumbline --json decode`) and the databases of `descriptors`. Each value that two of them
show must be the same. Prints one line for each difference and the count; the exit code is 1 if there is one.
"""

import argparse
import json
import re
import sys
from collections import Counter
from pathlib import Path

import cantools
from decode_tshark import compare_canopen, compare_devicenet, compare_j1939

# The frames of the sensors with function select codes as delivered, and of the DeviceNet slave with MAC ID 63.
FSC = {0x300, 0x301, 0x100}
DEVICENET = {0x3FF, 0x37F, 0x33F, *range(0x5F8, 0x600)}

# The names of the tool for signals that have another one in the database. Other names differ only in letters and dashes.
RENAMED = {
    "counter": "cycliccounter", "cutoff": "cutofffrequency", "setid": "setparameterid", "replyid": "replyparameterid",
    "zerox": "zerooffsetx", "zeroy": "zerooffsety", "busoffrecovery": "automaticbusoffrecovery",
    "arbitraryaddress": "arbitraryaddresscapable", "manufacturer": "manufacturercode",
}  # fmt: skip
STATUS = ("DefaultParam", "AutobaudDetection", "EEPROMError", "CmdParamError", "SensorErrorX", "SensorErrorY", "AccuracyWarning")
# What the traffic has at least.
KINDS = {
    "canopen EMCY", "canopen LSS error", "canopen LSS node-id", "canopen LSS number", "canopen NMT", "canopen SYNC",
    "canopen abort code", "canopen block-size", "canopen data", "canopen object", "canopen raw", "canopen segments", "canopen state",
    "cip object", "cip product-name", "cip refusal", "cip serial-number", "cip status", "devicenet check", "devicenet fragment",
    "devicenet message", "devicenet service", "fsc raw", "fsc refused code", "fsc refused status", "fsc status", "fsc value",
    "j1939 abort code", "j1939 access denied acknowledgement", "j1939 acknowledged group", "j1939 cannot respond acknowledgement",
    "j1939 clear to send", "j1939 contents", "j1939 lamps", "j1939 negative acknowledgement", "j1939 not available", "j1939 object",
    "j1939 requested group", "j1939 transported group", "j1939 trouble", "j1939 value",
}  # fmt: skip
ACKNOWLEDGEMENTS = ["positive", "negative", "access denied", "cannot respond"]


class Checks:
    """Compares, prints and counts."""

    def __init__(self) -> None:
        """Nothing compared yet."""
        self.compared = Counter()
        self.failed = 0

    def equal(self, kind: str, frame: str, own: object, other: object) -> None:
        """Compares the value of the tool with that of another program."""
        self.compared[kind] += 1
        same = abs(own - other) < 1e-9 if isinstance(own, float) and isinstance(other, (int, float)) else own == other
        if not same:
            self.failed += 1
            if self.failed <= 40:
                print(f"FAILED {kind}: {frame}: plumbline {own!r}, other {other!r}")


def plain(name: str) -> str:
    """A name without its notation."""
    name = re.sub(r" \(SPN \d+\)$|[^A-Za-z0-9]", "", re.sub(r" \(SPN \d+\)$", "", name)).lower()
    return RENAMED.get(name, name)


def numbers(message: object, data: bytes) -> tuple[dict, dict]:
    """The signals of a frame: physical values and raw numbers, by plain names. None: the database has no such frame."""
    options = {"decode_choices": False, "allow_truncated": True}
    try:
        physical = message.decode(data, **options)
        raw = message.decode(data, scaling=False, **options)
    except (cantools.database.errors.Error, KeyError):
        return {}, {}
    return ({plain(name): value for name, value in signals.items()} for signals in (physical, raw))


def compare_fsc(checks: Checks, database: object, document: dict) -> None:
    """A frame with a function select code."""
    frame = document["frame"]
    number, data = frame.split("#")
    message = database.get_message_by_frame_id(int(number, 16))
    physical, raw = numbers(message, bytes.fromhex(data))
    if re.search(r"^bootloader|update \(60h\)$", document.get("message", "bootloader")):
        # These codes are not in the list.
        checks.equal("fsc unknown", frame, len(physical), 0)
        return
    if code := re.search(r"code ([0-9A-F]{2})h$", document["message"]):
        compare_refused(checks, message, document, int(code[1], 16))
        return
    for name, value in document["values"].items():
        if name == "status":
            bits = [bit for bit in STATUS if physical.get(plain(bit))]
            checks.equal("fsc status", frame, value["value"], " + ".join(bits) or "ok")
        elif name in ("set-id", "software-version") and document["message"] == "boot-up":
            other = raw["activesetparameterid" if name == "set-id" else "alivesoftwareversion"]
            checks.equal("fsc boot-up", frame, value["value"], f"{other:03X}h" if name == "set-id" else f"{other >> 8:X}.{other & 0xFF:02X}")
        else:
            checks.equal("fsc raw", frame, value.get("raw", value["value"]), raw.get(plain(name)))
            if isinstance(value["value"], float):
                checks.equal("fsc value", frame, value["value"], physical.get(plain(name)))


def compare_refused(checks: Checks, message: object, document: dict, code: int) -> None:
    """A code that the database does not have, so cantools decodes no signal: the reply has the status in the same place as all others."""
    frame = document["frame"]
    data = bytes.fromhex(frame.split("#")[1])
    signal = message.get_signal_by_name
    checks.equal("fsc refused code", frame, [code, False], [data[0], data[0] in signal("FSC").choices])
    if "status" in document["values"]:
        bits = [bit for bit in STATUS if data[signal(bit).start // 8] >> signal(bit).start % 8 & 1]
        checks.equal("fsc refused status", frame, document["values"]["status"]["value"], " + ".join(bits))


def compare_signals(checks: Checks, message: object, document: dict) -> None:
    """A group of J1939 with process data, or the fields of a NAME."""
    frame = document["frame"]
    physical, raw = numbers(message, bytes.fromhex(frame.split("#")[1]))
    lengths = {plain(signal.name): signal.length for signal in message.signals}
    for name, value in document["values"].items():
        key = plain(name)
        if value["value"] == "not available":
            checks.equal("j1939 not available", frame, (1 << lengths[key]) - 1, raw[key])
        elif value["value"] == "error":
            checks.equal("j1939 error", frame, raw[key] >> lengths[key] - 8 > 0xFA, True)
        else:
            checks.equal("j1939 raw", frame, value.get("raw", value["value"]), raw.get(key))
            checks.equal("j1939 value", frame, float(value["value"]), physical.get(key))


def compare_j1939_database(checks: Checks, database: object, document: dict) -> None:
    """A frame of J1939 with the database."""
    frame, text, values = document["frame"], document["message"], document["values"]
    number, data = int(frame[:8], 16), bytes.fromhex(frame[9:])
    pgn = number >> 8 & 0x3FFFF
    pgn = pgn if pgn & 0xFF00 >= 0xF000 else pgn & 0x3FF00
    is_sensor = number & 0xFF == 128
    names = {
        0xF029: "SSI2", 0xF013: "SSI", 0xF02A: "ARI", 0xF02D: "ACCS", 0xEE00: "AddressClaimed", 0xEA00: "Request",
        0xE800: "Acknowledgement", 0xFECA: "DM1", 0xEC00: "TransportControl" + ("" if is_sensor else "Received"),
        0xEF00: "ObjectResponse" if is_sensor else "ObjectRequest",
    }  # fmt: skip
    if pgn not in names:
        return
    message = database.get_message_by_name(names[pgn])
    if pgn in (0xF029, 0xF013, 0xF02A, 0xF02D, 0xEE00):
        compare_signals(checks, message, document)
        return
    _, raw = numbers(message, data)
    group = re.search(r"([0-9A-F]+)h\)?$", values["group"]["value"]) if "group" in values else None
    if pgn == 0xEA00:
        checks.equal("j1939 requested group", frame, int(group[1], 16), raw["requestedpgn"])
    elif pgn == 0xE800:
        control = values["control"]["value"]
        checks.equal(f"j1939 {control} acknowledgement", frame, control, ACKNOWLEDGEMENTS[raw["answer"]])
        checks.equal("j1939 acknowledged group", frame, int(group[1], 16), raw["acknowledgedpgn"])
    elif pgn == 0xFECA:
        lamps = sum(raw[name] << at for name, at in (("protectlamp", 0), ("amberwarninglamp", 2), ("redstoplamp", 4),
                                                     ("malfunctionindicatorlamp", 6)))  # fmt: skip
        checks.equal("j1939 lamps", frame, values["lamps"]["value"], f"{lamps:02X}h")
        spn = raw["suspectparameternumber"] | raw["suspectparameternumberhigh"] << 16
        code = {f"SPN {spn}": f"FMI {raw['failuremodeidentifier']}, {raw['occurrencecount']} times"} if spn else {}
        checks.equal("j1939 trouble", frame, {name: value["value"] for name, value in values.items() if name != "lamps"}, code)
    elif pgn == 0xEC00:
        kinds = {16: "TP.CM request to send", 17: "TP.CM clear to send", 19: "TP.CM end of message", 32: "TP.CM announcement"}
        checks.equal("j1939 transport", frame, re.sub(r" to \d+$", "", text), kinds.get(raw["control"], "TP.CM abort"))
        checks.equal("j1939 transported group", frame, int(group[1], 16), raw["transportedpgn"])
        first = raw["parameters"] & 0xFFFF if raw["control"] != 17 else None
        if "size" in values:
            checks.equal("j1939 size", frame, values["size"]["value"], first)
            checks.equal("j1939 packets", frame, values["packets"]["value"], raw["parameters"] >> 16 & 0xFF)
        elif raw["control"] == 17:
            told = [values["packets"]["value"], values["next"]["value"]]
            checks.equal("j1939 clear to send", frame, told, [raw["parameters"] & 0xFF, raw["parameters"] >> 8 & 0xFF])
    else:
        place = re.match(r"SDO [a-z ]+ ([0-9A-F]{4})h:(\d+)", text)
        # A segment has no object.
        if place and raw["command"] & 0xE0:
            checks.equal("j1939 object", frame, (int(place[1], 16), int(place[2])), (raw["index"], raw["subindex"]))
        if "reason" in values:
            code = int(re.search(r"([0-9A-F]{8})h", values["reason"]["value"])[1], 16)
            checks.equal("j1939 abort code", frame, code, raw["contents"])
        if place and raw["command"] & 0xE2 in (0x22, 0x42):
            for value in values.values():
                if "raw" in value:
                    unused = raw["command"] >> 2 & 3
                    checks.equal("j1939 contents", frame, value["raw"], signed(raw["contents"], 4 - unused, value["raw"]))


def signed(number: int, size: int, like: int) -> int:
    """The number in this many bytes; negative if the other one is."""
    number &= (1 << 8 * size) - 1
    return number - (1 << 8 * size) if like < 0 else number


def main() -> int:
    """Compares; returns the exit code."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--folder", required=True, type=Path)
    folder = options.parse_args().folder
    documents = [json.loads(line) for line in (folder / "mixed.json").read_text().splitlines()]
    load = lambda name: cantools.database.load_file(folder / name, strict=True)
    fsc, j1939 = load("is2.dbc"), load("ims360_j1939.dbc")
    checks, by_protocol = Checks(), {"fsc": [], "j1939": [], "devicenet": [], "canopen": []}
    for document in documents:
        digits = document["frame"].split("#")[0]
        number = int(digits, 16)
        protocol = "j1939" if len(digits) == 8 else "fsc" if number in FSC else "devicenet" if number in DEVICENET else "canopen"
        if "protocol" in document:
            checks.equal("protocol", document["frame"], document["protocol"], protocol)
            if document["protocol"] != protocol:
                continue
        elif protocol != "fsc":
            checks.equal("decoded", document["frame"], "not decoded", protocol)
            continue
        by_protocol[protocol].append(document)
    for document in by_protocol["fsc"]:
        compare_fsc(checks, fsc, document)
    for document in by_protocol["j1939"]:
        compare_j1939_database(checks, j1939, document)
    compare_j1939(checks, by_protocol["j1939"], folder)
    compare_canopen(checks, by_protocol["canopen"], folder)
    compare_devicenet(checks, by_protocol["devicenet"], folder)
    for kind, count in sorted(checks.compared.items()):
        print(f"{count:7} {kind}")
    for kind in sorted(KINDS - set(checks.compared)):
        checks.equal("compared", kind, 0, "at least one")
    print(f"{len(documents)} frames, {sum(checks.compared.values())} compared, {checks.failed} failed")
    return int(checks.failed > 0)


if __name__ == "__main__":
    sys.exit(main())
