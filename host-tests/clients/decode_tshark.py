"""Compares the documents of `plumbline decode` with the dissectors of Wireshark for CANopen, J1939, DeviceNet and CIP."""

import re
import struct
import subprocess
from pathlib import Path

from devicenet_tshark import ACKNOWLEDGE, DUPLICATE, ERROR, EXPLICIT, POLL, PORT, RESPONSE, cip, ethernet_ip, number, pairs

NMT = {1: "start", 2: "stop", 128: "enter pre-operational", 129: "reset node", 130: "reset communication"}
STATES = {0: "boot-up", 4: "heartbeat, stopped", 5: "heartbeat, operational", 127: "heartbeat, pre-operational"}


def dissect(frames: list[str], folder: Path, dissector: str, names: list[str]) -> list[dict[str, str]]:
    """The fields of each frame as tshark reads them."""
    log = folder / f"mixed-{dissector}.log"
    # One frame each millisecond.
    log.write_text("".join(f"({1.7e9 + at / 1000:.6f}) can0 {frame}\n" for at, frame in enumerate(frames)))
    return fields(log, names, "-d", f"can.subdissector,{dissector}")


def fields(path: Path, names: list[str], *options: str) -> list[dict[str, str]]:
    """Fields of each packet; the first occurrence."""
    command = ["tshark", "-n", "-r", str(path), *options, "-T", "fields", "-E", "occurrence=f"]
    for name in names:
        command += ["-e", name]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [dict(zip(names, line.split("\t"), strict=True)) for line in text.splitlines()]


def compare_j1939(checks: object, documents: list[dict], folder: Path) -> None:
    """Group, source and destination."""
    # Without data, the dissector has a bug.
    documents = [document for document in documents if not document["frame"].endswith("#")]
    names = ["j1939.pgn", "j1939.src_addr", "j1939.dst_addr"]
    rows = dissect([document["frame"] for document in documents], folder, "j1939", names)
    groups = {"request": 0xEA00, "acknowledgement": 0xE800, "TP.CM": 0xEC00, "TP.DT": 0xEB00, "SDO": 0xEF00,
              "address claimed": 0xEE00, "cannot claim address": 0xEE00}  # fmt: skip
    for document, row in zip(documents, rows, strict=True):
        frame, text = document["frame"], document["message"]
        pgn, source, destination = (number(row[name]) for name in names)
        checks.equal("j1939 source", frame, document["address"], str(source))
        to = re.search(r" to (\d+)$", text)
        checks.equal("j1939 destination", frame, int(to[1]) if to else 255, 255 if destination is None else destination)
        named = next((group for name, group in groups.items() if text.startswith(name)), None)
        named = named or int(re.search(r"([0-9A-F]{4,5})h", text)[1], 16)
        checks.equal("j1939 group", frame, named, pgn)


def compare_canopen(checks: object, documents: list[dict], folder: Path) -> None:
    """Node, command, object, data and error of each message."""
    sdo = ["main_idx", "sub_idx", "data.bytes", "abort_code", "ackseq", "blksize", "n"]
    lss = ["nid", "conf_id.err_code", "conf_bt.err_code", "store_conf.err_code", "bt.tbl_selector", "bt.tbl_index", "switch.mode",
           "addr.vendor", "addr.product", "addr.revision", "addr.serial", "fastscan.id", "fastscan.check", "fastscan.sub", "fastscan.next"]  # fmt: skip
    names = ["canopen.node_id", "canopen.nmt_ctrl.cd", "canopen.nmt_ctrl.node_id", "canopen.nmt_guard.state", "canopen.sync.counter"]
    names += ["canopen.em.err_code", "canopen.em.err_reg", "canopen.em.err_field"]
    names += [f"canopen.sdo.{name}" for name in sdo] + [f"canopen.lss.{name}" for name in lss]
    rows = dissect([document["frame"] for document in documents], folder, "canopen", names)
    for document, row in zip(documents, rows, strict=True):
        row = {name.removeprefix("canopen."): text for name, text in row.items()}
        frame, text = document["frame"], document["message"]
        if text.startswith(("SDO", "TPDO", "heartbeat", "boot-up", "EMCY")):
            checks.equal("canopen node", frame, int(document["address"]), number(row["node_id"]))
        if text.startswith("NMT"):
            checks.equal("canopen NMT", frame, text, "NMT " + NMT[number(row["nmt_ctrl.cd"])])
            checks.equal("canopen NMT node", frame, int(document.get("address", 0)), number(row["nmt_ctrl.node_id"]))
        elif text.startswith(("heartbeat", "boot-up")):
            checks.equal("canopen state", frame, text, STATES[number(row["nmt_guard.state"])])
        elif text == "SYNC":
            counter = document["values"].get("counter", {}).get("value")
            checks.equal("canopen SYNC", frame, counter, number(row["sync.counter"]))
        elif text == "EMCY":
            emergency(checks, document, row)
        elif text.startswith("SDO"):
            transfer(checks, document, row)
        elif text.startswith("LSS"):
            layer_setting(checks, document, row)


def emergency(checks: object, document: dict, row: dict[str, str]) -> None:
    """An EMCY."""
    frame, values = document["frame"], document["values"]
    code = int(re.search(r"([0-9A-F]{4})h", values["error"]["value"])[1], 16)
    checks.equal("canopen EMCY", frame, code, number(row["em.err_code"]))
    checks.equal("canopen error register", frame, int(values["error-register"]["value"][:2], 16), number(row["em.err_reg"]))
    checks.equal("canopen EMCY data", frame, values["data"]["value"].replace(" ", "").lower(), row["em.err_field"])


def transfer(checks: object, document: dict, row: dict[str, str]) -> None:
    """A message of an SDO transfer. The dissector has no state: it reads the segments of a block as commands."""
    frame, text, values = document["frame"], document["message"], document["values"]
    if re.search(r"block .*, segment \d+$", text):
        return
    place = re.search(r" ([0-9A-F]{4})h:(\d+)", text)
    if row["sdo.main_idx"]:
        checks.equal("canopen object", frame, (int(place[1], 16), int(place[2])), (number(row["sdo.main_idx"]), number(row["sdo.sub_idx"])))
    if text.startswith("SDO abort"):
        code = int(re.search(r"([0-9A-F]{8})h", values["reason"]["value"])[1], 16)
        checks.equal("canopen abort code", frame, code, number(row["sdo.abort_code"]))
    for name, field in (("segments", "sdo.ackseq"), ("block-size", "sdo.blksize")):
        if name in values and row[field]:
            checks.equal(f"canopen {name}", frame, values[name]["value"], number(row[field]))
    # An expedited transfer has its data in the frame.
    command = int(frame.split("#")[1][:2], 16)
    if command & 0xE2 in (0x22, 0x42) and row["sdo.data.bytes"]:
        data = bytes.fromhex(row["sdo.data.bytes"])[: 4 - (command >> 2 & 3)]
        for value in values.values():
            if "raw" in value:
                checks.equal("canopen raw", frame, value["raw"], int.from_bytes(data, "little", signed=value["raw"] < 0))
            elif re.fullmatch("[0-9A-F]+h", str(value["value"])):
                checks.equal("canopen data", frame, int(value["value"][:-1], 16), int.from_bytes(data, "little"))


def layer_setting(checks: object, document: dict, row: dict[str, str]) -> None:
    """A message of LSS."""
    frame = document["frame"]
    numbers = [row[f"lss.addr.{name}"] for name in ("vendor", "product", "revision", "serial")] + [row["lss.fastscan.id"]]
    errors = [row[f"lss.{name}.err_code"] for name in ("conf_id", "conf_bt", "store_conf")]
    found = {
        "number": next((number(text) for text in numbers if text), None),
        "error": next((number(text) for text in errors if text), None),
        "node-id": number(row["lss.nid"]), "table": number(row["lss.bt.tbl_selector"]), "place": number(row["lss.bt.tbl_index"]),
        "bit": number(row["lss.fastscan.check"]), "sub": number(row["lss.fastscan.sub"]), "next": number(row["lss.fastscan.next"]),
        "state": {None: None, 0: "waiting", 1: "configuration"}[number(row["lss.switch.mode"])],
    }  # fmt: skip
    for name, value in document["values"].items():
        own = int(value["value"][:-1], 16) if name == "number" else value["value"]
        if found[name] is not None:
            checks.equal(f"canopen LSS {name}", frame, own, found[name])


def compare_devicenet(checks: object, documents: list[dict], folder: Path) -> None:
    """The messages as they are, the explicit ones as messages of group 3, and requests with their responses as CIP."""
    # The dissector calls a frame without data a poll of any kind.
    names = ["devicenet.src_mac_id", "_ws.col.Info", "devicenet.dup_mac_id.vendor", "devicenet.dup_mac_id.serial_number"]
    rows = dissect([document["frame"] for document in documents], folder, "devicenet", names)
    kinds = {"duplicate": "Duplicate MAC ID Check", "poll response": "Slave's I/O Poll Response", "poll": "Master's I/O Poll Command",
             "COS": "Slave's I/O Change of State", "acknowledge of COS": "Master's Change of State or Cyclic Acknowledge"}  # fmt: skip
    for document, row in zip(documents, rows, strict=True):
        frame, text, values = document["frame"], document["message"], document["values"]
        checks.equal("devicenet MAC ID", frame, document["address"], str(number(row["devicenet.src_mac_id"])))
        kind = next((name for own, name in kinds.items() if text.startswith(own)), None)
        if text.startswith("explicit"):
            port = int(frame[:3], 16) & 7 == PORT
            kind = "Slave's Explicit" if "response" in text[:17] else "Group 2 Only Unconnected" if port else "Master's Explicit"
        if kind:
            checks.equal("devicenet message", frame, row["_ws.col.Info"][: len(kind)], kind)
        if text.startswith("duplicate"):
            own = [values["vendor"]["value"], values["serial-number"]["value"]]
            checks.equal("devicenet check", frame, own, [number(row[name]) for name in names[2:]])
    compare_group_3(checks, documents, folder)
    compare_cip(checks, documents, folder)


def compare_group_3(checks: object, documents: list[dict], folder: Path) -> None:
    """The dissector decodes explicit messages only in group 3."""
    explicit = [document for document in documents if document["message"].startswith("explicit")]
    bodies = ["63F#" + document["frame"].split("#")[1] for document in explicit]
    names = ["devicenet.fragment_type", "devicenet.fragment_count", "devicenet.rr", "devicenet.service"]
    names += ["devicenet.class", "devicenet.instance", "devicenet.attribute"]
    services = {"get": 0x0E, "set": 0x10, "allocate": 0x4B, "release": 0x4C, "error": 0x14}
    for document, row in zip(explicit, dissect(bodies, folder, "devicenet", names), strict=True):
        frame, text = document["frame"], document["message"]
        count = re.match(r"explicit \w+, (?:acknowledge of )?fragment (\d+)", text)
        if count:
            checks.equal("devicenet fragment", frame, int(count[1]), number(row["devicenet.fragment_count"]))
            continue
        # The dissector reads allocate and release as the messages that open and close a connection.
        service = services.get(re.match(r"explicit \w+, (\w+)", text)[1])
        if row["devicenet.service"] and service is not None and service < 0x4B:
            checks.equal("devicenet service", frame, service, number(row["devicenet.service"]) & 0x7F)
        own = re.search(r"class ([0-9A-F]+)h instance (\d+)(?: attribute (\d+))?", text)
        for place, name in enumerate(names[4:], start=1):
            if own and own[place] and row[name] and text.startswith("explicit request"):
                checks.equal(name.replace(".", " "), frame, int(own[place], 16 if place == 1 else 10), number(row[name]))


def answers(documents: list[dict]) -> list[dict]:
    """The responses to requests of one frame, as `pairs` finds them."""
    found, is_whole = [], False
    for document in documents:
        text = document["message"]
        if text.startswith("explicit request") and "acknowledge" not in text:
            is_whole = "fragment" not in text
        elif re.match(r"explicit response, (?!fragment \d+$|acknowledge)", text) and is_whole:
            found.append(document)
            is_whole = False
    return found


def compare_cip(checks: object, documents: list[dict], folder: Path) -> None:
    """Requests and their responses as EtherNet/IP: object, service, status and the identity."""
    frames = [document["frame"].split("#") for document in documents]
    lines = [(int(digits, 16), bytes.fromhex(data)) for digits, data in frames]
    found = pairs(lines)
    out = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)]
    for at, pair in enumerate(found):
        for client, data in zip((True, False), cip(*pair), strict=True):
            packet = ethernet_ip(data, at + 1, client)
            out.append(struct.pack("<IIII", 1_700_000_000 + at, 0 if client else 1000, len(packet), len(packet)) + packet)
    capture = folder / "mixed.pcap"
    capture.write_bytes(b"".join(out))
    names = ["cip.class", "cip.instance", "cip.attribute", "cip.genstat", "cip.id.vendor_id", "cip.id.serial_number", "cip.id.product_name"]
    rows = fields(capture, names)
    responses = answers(documents)
    checks.equal("devicenet answers", "all", len(responses), len(found))
    for document, asked, answer in zip(responses, rows[::2], rows[1::2], strict=False):
        frame, text, values = document["frame"], document["message"], document["values"]
        if "reason" in values:
            code = int(re.search(r"\(([0-9A-F]{2})h", values["reason"]["value"])[1], 16)
            checks.equal("cip refusal", frame, code, number(answer["cip.genstat"]))
            continue
        checks.equal("cip status", frame, 0, number(answer["cip.genstat"]))
        own = re.search(r"class ([0-9A-F]+)h instance (\d+)(?: attribute (\d+))?", text)
        other = [number(asked[name]) for name in names[:3]]
        checks.equal("cip object", frame, [int(own[1], 16), int(own[2]), int(own[3]) if own[3] else None], other)
        for name, field in (("serial-number", "cip.id.serial_number"), ("product-name", "cip.id.product_name"), ("data", "cip.id.vendor_id")):
            if name in values and answer[field]:
                data = values[name]["value"]
                told = answer[field] if name == "product-name" else number(answer[field])
                checks.equal(f"cip {name}", frame, int.from_bytes(bytes.fromhex(data), "little") if name == "data" else data, told)
