// The form of the parameters and the file: values, ranges, differences, what is written and what is refused.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, CLOSED, open, Refusal } from "./page.js";

const { values } = answers.devices.is2;

/** A file of an IS2 as the server reads it. */
const file = (change = {}, more = {}) => ({ product: "is2", sheet: "is2", text: "text", serial: 1, label: null, values: { ...settings, ...change }, ...more });
const settings = Object.fromEntries(answers.parameters.is2.entries.filter(({ setting }) => setting).map(({ name }) => [name, values[name]]));

async function connected() {
  const page = await open();
  await page.connected("is2");
  page.reply("api/backup", file());
  return page;
}

/** The page after `Sensor to file`. */
async function backed() {
  const page = await connected();
  await page.click("backup");
  return page;
}

async function opened(page, own, name = "crane.toml") {
  page.reply("api/file", own);
  page.element("file").files = [{ name, size: 1, arrayBuffer: async () => Uint8Array.from(own.bytes ?? new TextEncoder().encode(own.text ?? "")).buffer }];
  await page.change("file");
}

const MS = (value) => ({ value, unit: "ms", raw: value });
const shown = (page) => page.element("rows").children.filter((line) => !line.hidden).length;

test("table_shows_value_factory_value_and_range", async () => {
  const page = await connected();
  assert.deepEqual(page.row("cyclic-time").cells, ["Cyclic Time", "250 ms", "Set...", "", "250 ms", "1..65535 ms"]);
  assert.equal(page.row("filter-type").cells[1], "critically damped");
  assert.ok(page.element("parameters-empty").hidden);
  await page.event("values", { ...values, "cyclic-time": null });
  assert.equal(page.row("cyclic-time").cells[1], "-");
  // The factory value contains the node-ID.
  await page.connected("jn2101");
  assert.equal(page.row("cob-id-emcy").cells[4], "80h + node-ID");
  await page.change("language", "de");
  assert.equal(page.row("cob-id-emcy").cells[4], "80h + Node-ID");
});

test("names_of_values_are_german_in_the_german_page", async () => {
  const page = await open();
  await page.connected("is2");
  await page.event("values", { ...values, "filter-type": { value: "critically damped", unit: "", raw: 2 } });
  assert.equal(page.row("filter-type").cells[1], "critically damped");
  await page.change("language", "de");
  assert.equal(page.row("filter-type").cells[1], "kritisch gedämpft");
  assert.match(page.row("filter-type").cells[5], /aus \(0\).*kritisch gedämpft \(2\)/);
  await page.change("language", "en");
});

test("numbers_of_the_german_table_have_a_decimal_comma", async () => {
  const page = await connected();
  await page.event("values", { ...values, "zero-x": { value: -1.25, unit: "deg", raw: -125 } });
  const cells = () => [1, 5].map((cell) => page.row("zero-x").cells[cell]);
  const [english, range] = cells();
  assert.equal(english, "-1.25 deg");
  assert.match(range, /\d\.\d/);
  await page.change("language", "de");
  assert.deepEqual(cells(), ["-1,25 deg", range.replace(/(\d)\.(\d)/g, "$1,$2")]);
  await page.change("language", "en");
});

test("choice_has_its_unit_once_and_is_preselected", async () => {
  const page = await open();
  await page.connected("tiltix080");
  assert.equal(page.row("resolution").cells[1], "0.01 deg");
  for (const [value, raw] of [["0.01 deg", 10], ["0.1 deg", 100]]) {
    await page.event("values", { resolution: { value: Number.parseFloat(value), unit: "deg", raw } });
    page.setter("resolution").click();
    await page.pass(0);
    assert.equal(page.element("question-input").value, value);
    await page.no();
  }
});

test("angles_in_the_table_are_those_of_now", async () => {
  const page = await connected();
  await page.samples([[0, 1.5, 2]]);
  await page.pass(400);
  assert.equal(page.row("angle-x").cells[1], "1.50 deg");
  await page.samples([[0.1, -3, 2]], 1);
  await page.pass(400);
  assert.equal(page.row("angle-x").cells[1], "-3.00 deg");
  await page.status({ samples: 0 });
  await page.pass(400);
  assert.equal(page.row("angle-x").cells[1], "-");
});

test("value_is_set_after_its_question_with_the_range", async () => {
  const page = await connected();
  page.setter("cut-off").click();
  await page.pass(0);
  assert.match(page.asked().text, /serial number 1, identifier 300h/);
  assert.match(page.text("question-hint"), /100\.\.25000 mHz/);
  await page.yes({ value: "2.5Hz", checks: { 0: true } });
  const sent = { set: { assignments: ["cut-off=2.5Hz"], save: true } };
  assert.deepEqual(page.requests.pop(), { path: "api/run", body: sent, sensor: String(answers.devices.is2.device.connection) });
});

test("value_that_the_sensor_refuses_stays_in_its_question_with_the_reason", async () => {
  const page = await connected();
  page.reply("api/run", new Refusal("out-of-range", "cyclic-time is out of range: 1..65535 ms"));
  page.setter("cyclic-time").click();
  await page.pass(0);
  await page.yes({ value: "0" });
  const input = page.element("question-input");
  const state = () => [page.isAsking, input.value, input.getAttribute("aria-invalid"), page.text("question-wrong"), page.text("message")];
  assert.deepEqual(state(), [true, "0", "true", "cyclic-time is out of range: 1..65535 ms", ""]);
  assert.equal(document.activeElement, input);
  let end;
  page.reply("api/run", () => new Promise((resolve) => { end = resolve; }));
  await page.yes({ value: "100" });
  assert.deepEqual([...state(), page.element("question-yes").getAttribute("aria-busy")], [true, "100", null, "", "", "true"]);
  await page.yes();
  assert.equal(page.requests.length, 2, "a second yes sends nothing");
  end({});
  await page.pass(0);
  assert.deepEqual([page.isAsking, page.element("question-yes").getAttribute("aria-busy")], [false, null]);
  // Another question has no reason of this one.
  page.setter("cyclic-time").click();
  await page.pass(0);
  assert.equal(page.text("question-wrong"), "");
});

test("failure_after_the_end_of_its_question_is_told_on_the_page", async () => {
  const page = await connected();
  let end;
  page.reply("api/run", () => new Promise((resolve) => { end = resolve; }));
  page.setter("cyclic-time").click();
  await page.pass(0);
  await page.yes({ value: "100" });
  await page.no();
  end(new Refusal("no-answer", "the sensor does not answer", 504));
  await page.pass(0);
  assert.equal(page.text("message"), "the sensor does not answer");
});

test("refusal_is_told_until_the_next_action_of_this_user", async () => {
  const page = await connected();
  page.reply("api/run", new Refusal("refused", "the sensor refuses it"));
  await page.click("save");
  await page.yes();
  assert.equal(page.text("message"), "the sensor refuses it");
  // What another tab does, does not take it away.
  await page.event("action", { n: 5, at: 0, line: "plumbline get cut-off", state: "done" });
  await page.event("device", answers.devices.is2.device);
  await page.event("values", values);
  await page.status({ silent: true });
  await page.status({});
  assert.equal(page.text("message"), "the sensor refuses it");
  page.reply("api/run", {});
  await page.click("read");
  assert.deepEqual([page.requests.pop().body, page.text("message")], [{ get: {} }, ""]);
});

test("search_and_differences_hide_the_other_rows", async () => {
  const page = await connected();
  page.reply("api/backup", file({ "cyclic-time": MS(100), "filter-type": { value: "Butterworth", unit: "", raw: 1 } }));
  await page.click("backup");
  assert.match(page.text("file-state"), /differ from the sensor: 2\./);
  const only = page.element("only-differences");
  only.checked = true;
  await page.change("only-differences");
  assert.equal(shown(page), 2);
  await page.dispatch("search", "input", "CYCLIC");
  assert.equal(shown(page), 1);
  assert.deepEqual([page.row("cyclic-time").line.classList.contains("differs"), page.row("cyclic-time").cells[3]], [true, "≠"]);
  only.checked = false;
  await page.change("only-differences");
  await page.dispatch("search", "input", "zzz");
  assert.equal(shown(page), 0);
  assert.match(page.text("parameters-empty"), /change Search/);
  assert.deepEqual([page.element("parameters-empty").hidden, page.element("parameters-scroll").hidden], [false, true]);
  await page.dispatch("search", "input", "");
  assert.ok(shown(page) > 10);
});

test("value_of_the_file_is_changed_by_the_server_and_refused_with_its_reason", async () => {
  const page = await backed();
  assert.match(page.text("file-state"), /^File: is2-1\.toml \(is2\).*Not saved/);
  page.reply("api/file/set", new Refusal("out-of-range", "cyclic-time is out of range: 1..65535 ms"));
  await page.change("file-cyclic-time", "0");
  assert.equal(page.element("file-cyclic-time").getAttribute("aria-invalid"), "true");
  assert.match(page.text("wrong-cyclic-time"), /1\.\.65535 ms/);
  page.reply("api/file/set", file({ "cyclic-time": MS(100) }));
  await page.change("file-cyclic-time", "0.1s");
  const sent = { text: "text", name: "cyclic-time", value: "0.1s", file: "is2-1.toml", sheet: "is2" };
  assert.deepEqual(page.requests.pop().body, sent);
  assert.equal(page.element("file-cyclic-time").value, "100 ms");
  assert.deepEqual([page.text("wrong-cyclic-time"), page.element("file-cyclic-time").getAttribute("aria-invalid")], ["", null]);
});

test("value_that_is_refused_stays_in_its_field_and_the_file_is_not_saved_until_it_fits", async () => {
  const page = await backed();
  const why = "cut-off is at most 8000 mHz, because filter-type is critically damped";
  const fits = file({ "cut-off": { value: 9000, unit: "mHz", raw: 9000 } });
  let isButterworth = false;
  page.reply("api/file/set", ({ name }) => {
    isButterworth ||= name === "filter-type";
    if (name === "cyclic-time") return file({ "cyclic-time": MS(100) });
    return name === "cut-off" && !isButterworth ? new Refusal("out-of-range", why) : fits;
  });
  const state = () => [page.element("file-cut-off").value, page.text("wrong-cut-off"), page.element("download").disabled, page.element("restore").disabled];
  await page.change("file-cut-off", "9000 mHz");
  assert.deepEqual(state(), ["9000 mHz", why, true, true]);
  assert.match(page.text("file-state"), /correct cut-off\./);
  // Neither another value, nor news of the sensor, nor the language takes the input away.
  await page.change("file-cyclic-time", "0.1s");
  await page.event("values", values);
  await page.change("language", "de");
  assert.deepEqual(state(), ["9000 mHz", why, true, true]);
  await page.change("file-filter-type", "Butterworth");
  assert.deepEqual(state(), ["9000 mHz", "", false, false]);
  assert.equal(page.element("file-cut-off").getAttribute("aria-invalid"), null);
  // Another file has no refused value.
  isButterworth = false;
  await page.change("file-cut-off", "1");
  await opened(page, file());
  await page.yes();
  assert.deepEqual(state().slice(1, 3), ["", false]);
});

test("checked_differences_are_written", async () => {
  const page = await connected();
  page.reply("api/backup", file({ "cyclic-time": MS(100), "filter-type": { value: "Butterworth", unit: "", raw: 1 } }));
  await page.click("backup");
  const asked = await page.question("restore");
  assert.equal(asked.title, "Values for the sensor: 2");
  assert.match(asked.field, /cyclic-time: 250 ms → 100 ms/);
  assert.match(asked.field, /filter-type: critically damped → Butterworth/);
  const place = asked.field.indexOf("cyclic-time") < asked.field.indexOf("filter-type") ? 0 : 1;
  await page.yes({ checks: { [place]: false } });
  const sent = { text: "text", name: "is2-1.toml", only: ["filter-type"], label: false };
  assert.deepEqual(page.requests.pop(), { path: "api/restore", body: sent, sensor: String(answers.devices.is2.device.connection) });
  // Without a checked value nothing is written.
  await page.question("restore");
  const { length } = page.requests;
  await page.yes({ checks: { 0: false, 1: false } });
  assert.equal(page.requests.length, length);
});

test("restore_that_was_interrupted_is_finished_by_a_save", async () => {
  const page = await backed();
  const asked = await page.question("restore");
  assert.deepEqual([asked.yes, /serial number 1/.test(asked.text)], ["Store", true]);
  await page.yes();
  assert.equal(page.requests.pop().body, "save");
});

test("file_gives_its_name_to_a_sensor_that_has_none", async () => {
  const page = await connected();
  page.reply("api/backup", file({}, { label: "boom" }));
  await page.click("backup");
  assert.match((await page.question("restore")).field, /name of the sensor: - → boom/);
  await page.yes();
  assert.deepEqual(page.requests.pop().body, { label: { name: "boom" } });
  await page.connected("is2", { label: "boom" });
  assert.equal((await page.question("restore")).yes, "Store", "the sensor has this name");
  await page.no();
  // A sensor that has another name keeps it, unless its box is checked.
  await page.connected("is2", { label: "mast" });
  page.reply("api/file/set", file({ "cyclic-time": MS(100) }, { label: "boom" }));
  await page.change("file-cyclic-time", "100 ms");
  assert.match((await page.question("restore")).field, /cyclic-time: 250 ms → 100 ms.*mast → boom/);
  await page.yes();
  assert.equal(page.requests.at(-1).body.label, false);
  await page.question("restore");
  await page.yes({ checks: { 1: true } });
  assert.deepEqual([page.requests.at(-1).body.label, page.requests.at(-1).body.only], [true, ["cyclic-time"]]);
});

test("file_is_saved_and_its_changes_are_not_lost_without_a_question", async () => {
  const page = await backed();
  const leaves = () => {
    const event = new Event("beforeunload", { cancelable: true });
    page.window.dispatchEvent(event);
    return !event.defaultPrevented;
  };
  assert.ok(!leaves());
  await opened(page, file({}, { text: "other" }));
  assert.match(page.asked().text, /not saved/);
  await page.no();
  assert.match(page.text("file-state"), /is2-1\.toml/);
  await page.click("download");
  assert.deepEqual(await page.saved(), [{ name: "is2-1.toml", text: "text" }]);
  assert.doesNotMatch(page.text("file-state"), /Not saved/);
  assert.ok(leaves());
  await opened(page, file({}, { text: "other" }));
  assert.ok(!page.isAsking);
  assert.match(page.text("file-state"), /^File: crane\.toml/);
});

test("new_file_is_edited_without_a_sensor", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  assert.match(page.text("file-state"), /open a file/);
  assert.match(page.text("parameters-empty"), /open a file/);
  page.reply("api/file", { product: "jn2101", sheet: "jn2101", text: "t", values: { heating: { value: "on", unit: "", raw: 1 } } });
  page.element("template").value = "jn2101";
  await page.click("new-file");
  assert.deepEqual(page.requests.pop().body, { product: "jn2101" });
  assert.equal(page.element("file-heating").value, "on");
  assert.match(page.text("file-state"), /^File: jn2101\.toml \(jn2101\)\. No sensor is connected/);
  assert.equal(page.element("download").disabled, false);
  // A file of another product is not written.
  await page.connected("is2");
  assert.match(page.text("file-state"), /open a file of is2, or press Sensor to file/);
  assert.ok(page.element("restore").disabled);
});

test("new_file_of_a_data_sheet_has_a_name_that_is_valid_on_every_system", async () => {
  const page = await open();
  page.reply("api/file", { product: "Encoder: 1/2 <b>", sheet: "eds:1", text: "t", values: {} });
  await page.click("new-file");
  assert.match(page.text("file-state"), /^File: Encoder-1-2-b-\.toml /);
});

test("file_that_cannot_be_read_names_the_next_step", async () => {
  const page = await connected();
  const told = "this is not a file of settings: `plumbline backup` writes a valid one";
  await opened(page, new Refusal("bad-file", told));
  assert.equal(page.text("message"), told);
  assert.match(page.text("file-state"), /Press Sensor to file/);
});

test("file_in_utf_16_is_read_and_one_that_is_no_text_is_refused", async () => {
  const page = await connected();
  page.reply("api/file", { product: "is2", sheet: "is2", text: "t", values: {} });
  await opened(page, { bytes: [0xFF, 0xFE, 0x4D, 0, 0xFC, 0] });
  assert.equal(page.requests.pop().body.text, "Mü");
  await opened(page, { bytes: [0x4D, 0xFC] });
  assert.deepEqual(page.requests, []);
  assert.match(page.text("message"), /not a text in UTF-8 or UTF-16/);
});

const SHEET = { sheet: "eds:1", name: "jn2101-eds", maker: "Müller", protocol: "canopen", file: "one.eds", entries: 12, leftOut: 1 };

test("data_sheet_is_handed_to_the_server_and_the_address_is_asked_for", async () => {
  const page = await open();
  page.reply("api/eds", SHEET);
  const choose = async (bytes, size = bytes.length) => {
    page.element("eds").files = [{ name: "one.eds", size, arrayBuffer: async () => Uint8Array.from(bytes).buffer }];
    await page.change("eds");
    await page.pass(0);
  };
  // A letter in Latin-1, and the same letter in UTF-8 and UTF-16, with and without byte order mark.
  for (const bytes of [
    [0x4D, 0xFC], [0x4D, 0xC3, 0xBC], [0xEF, 0xBB, 0xBF, 0x4D, 0xC3, 0xBC], [0xFF, 0xFE, 0x4D, 0, 0xFC, 0], [0x4D, 0, 0xFC, 0],
    [0xFE, 0xFF, 0, 0x4D, 0, 0xFC], [0, 0x4D, 0, 0xFC],
  ]) {
    await choose(bytes);
    assert.deepEqual(page.requests.pop(), { path: "api/eds", body: { name: "one.eds", text: "Mü" }, sensor: null });
  }
  assert.deepEqual([page.element("product").value, page.element("protocol").value, document.activeElement.id], ["eds:1", "canopen", "address"]);
  assert.match(page.text("eds-state"), /one\.eds: 12 values and parameters.*Give the address/);
  await page.change("language", "de");
  assert.match(page.text("eds-state"), /Geben Sie die Adresse/);
  assert.equal(page.element("template").options.filter(({ value }) => value === "eds:1").length, 1);
  await page.change("product", "");
  assert.ok(page.element("eds-state").hidden);
  // One that is too long is not sent.
  await choose([0x20], (1 << 20) + 1);
  assert.deepEqual([page.requests.length, /1 MiB/.test(page.text("message"))], [0, true]);
  page.reply("api/eds", new Refusal("bad-file", "x is not a data sheet"));
  await choose([0x20], 1 << 20);
  assert.match(page.text("message"), /is not a data sheet/);
  // Another tab has sent one.
  await page.event("sheets", [SHEET, { ...SHEET, sheet: "eds:2" }]);
  assert.ok(page.element("product").options.some(({ value }) => value === "eds:2"));
});

test("parameter_has_its_name_in_the_manual_and_the_name_of_the_command_line_as_tooltip", async () => {
  const page = await open();
  await page.connected("jn2101");
  const words = ["node-id", "tpdo2-event-timer"].map((name) => page.row(name).cells[0]);
  assert.deepEqual(words, ["Node ID", "TPDO 2: Event timer"]);
});
