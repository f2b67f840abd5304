// Actions: each one asks first, for the sensor that the user has seen; a refusal is told. Their lines are in the log.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, open, Refusal, STATUS, texts } from "./page.js";

/** The page with a sensor, whose angles are asked for before a question. */
async function connected(name, change = {}) {
  const page = await open();
  page.reply("api/run", (body) => {
    const names = body.get?.names ?? [];
    return Object.fromEntries(names.map((own, place) => [own, { value: place + 0.25, unit: "deg", raw: 0 }]));
  });
  await page.connected(name, change);
  page.requests.length = 0;
  return page;
}

const number = (name) => String(answers.devices[name].device.connection);

test("page_without_a_sensor_offers_no_action", async () => {
  const page = await open();
  await page.event("device", null);
  const ids = ["zero", "save", "restart", "load-factory", "read", "backup", "restore", "send"];
  assert.deepEqual(ids.filter((id) => !page.element(id).disabled), []);
  await page.connected("is2");
  assert.deepEqual(ids.filter((id) => page.element(id).disabled), ["restore"]);
  await page.status({ busy: "get" });
  assert.deepEqual(ids.filter((id) => !page.element(id).disabled), []);
});

test("actions_are_those_of_the_sensor", async () => {
  const all = ["zero", "zero-x", "zero-y", "teach", "save", "new-address", "bit-rate", "label"];
  for (const [name, hidden, address] of [
    ["is2", ["teach", "new-address"], "Address"],
    ["jn2101", [], "Node-ID..."],
    ["tiltix080", ["teach", "save"], "MAC ID..."],
    ["ims360/j1939", [], "J1939 address..."],
  ]) {
    const page = await connected(name);
    const { zero, angles, teach } = answers.devices[name].device;
    const more = [["zero", zero.length > 0], ["zero-x", zero.includes("x")], ["zero-y", zero.includes("y") && angles.length > 1], ["teach", teach]];
    const own = all.filter((id) => hidden.includes(id) || more.some(([button, isOffered]) => button === id && !isOffered));
    assert.deepEqual(all.filter((id) => page.element(id).hidden), own, name);
    assert.equal(page.text("new-address"), address);
    // A data sheet does not say how an address is changed, or what is zeroed.
    await page.connected(name, { foreign: true, zero: [], teach: false });
    const foreign = ["zero", "zero-x", "zero-y", "teach", "new-address", "bit-rate"];
    assert.deepEqual(foreign.filter((id) => !page.element(id).hidden), [], name);
  }
});

test("zero_shows_sensor_and_present_angles_and_does_nothing_after_a_no", async () => {
  const page = await connected("is2");
  const asked = await page.question("zero");
  assert.equal(asked.title, "Zero");
  assert.match(asked.text, /becomes zero.*\n.*serial number 1, identifier 300h.*\nPresent angles: angle-x 0\.25 deg, angle-y 1\.25 deg\./);
  assert.equal(document.activeElement.id, "question-no", "a key pressed too much does nothing");
  await page.no();
  assert.deepEqual(page.requests.map(({ body }) => body), [{ get: { names: ["angle-x", "angle-y"] } }]);
  assert.equal(page.text("message"), "");
});

test("actions_send_their_command_for_the_sensor_that_was_shown", async () => {
  const page = await connected("is2");
  for (const [sensor, id, text, answer, command] of [
    ["is2", "zero", /becomes zero/, {}, { zero: { save: false } }],
    ["is2", "zero", /becomes zero/, { checks: { 0: true } }, { zero: { save: true } }],
    ["is2", "zero-x", /becomes zero/, { checks: { 0: true } }, { zero: { axis: "x", save: true } }],
    ["is2", "zero-y", /becomes zero/, {}, { zero: { axis: "y", save: false } }],
    ["jn2101", "teach", /reference frame/, {}, { teach: { save: false } }],
    ["tiltix080", "zero", /becomes zero/, {}, { zero: { save: false } }],
    ["is2", "save", /stores its present settings/, {}, "save"],
    ["is2", "restart", /restarts/, {}, "restart"],
    ["is2", "load-factory", /factory values/, {}, "load-factory"],
    ["jn2101", "new-address", /another node-ID/, { value: "11" }, { "node-id": { new: 11 } }],
    ["tiltix080", "new-address", /another MAC ID/, { value: "7" }, { mac: { new: 7 } }],
    ["ims360/j1939", "new-address", /another J1939 address/, { value: "160" }, { address: { new: 160 } }],
    ["is2", "bit-rate", /another bit rate/, { value: "250" }, { rate: { new: "250" } }],
    ["is2", "label", /name of the sensor/, { value: " boom " }, { label: { name: "boom" } }],
    ["is2", "label", /name of the sensor/, { value: "" }, { label: { name: null } }],
  ]) {
    await page.connected(sensor);
    const asked = await page.question(id);
    assert.match(asked.text, text, id);
    assert.match(asked.text, new RegExp(`(identifier|node-ID|MAC ID|J1939 address) ${answers.devices[sensor].device.address}h?\\b`), id);
    if (answer.checks) assert.match(asked.field, /Save it in the sensor/);
    await page.yes(answer);
    assert.deepEqual(page.requests.pop(), { path: "api/run", body: command, sensor: number(sensor) }, id);
  }
});

test("devicenet_sensor_has_no_box_to_save", async () => {
  const page = await connected("tiltix080");
  assert.equal((await page.question("zero")).field, "");
  await page.no();
  page.setter("resolution").click();
  await page.pass(0);
  assert.doesNotMatch(page.asked().field, /Save/);
});

test("addresses_have_the_range_of_their_protocol", async () => {
  for (const [sensor, range] of [["jn2101", ["1", "127"]], ["tiltix080", ["0", "63"]], ["ims360/j1939", ["0", "253"]]]) {
    const page = await connected(sensor);
    const asked = await page.question("new-address");
    assert.doesNotMatch(asked.title, /\./, "the title of a question has no dots");
    const field = page.element("question-input");
    assert.deepEqual([field.type, field.min, field.max, field.value], ["number", ...range, answers.devices[sensor].device.address]);
  }
});

test("yes_to_a_question_about_another_sensor_is_for_the_one_that_was_shown", async () => {
  const page = await connected("is2");
  await page.question("zero");
  await page.connected("jn2101", { connection: 7 });
  page.reply("api/run", new Refusal("sensor-changed", "another sensor is connected now", 409));
  await page.yes();
  assert.equal(page.requests.pop().sensor, number("is2"));
  assert.equal(page.text("message"), "another sensor is connected now");
});

test("stored_bit_rate_is_preselected", async () => {
  const page = await connected("is2");
  for (const [value, chosen] of [
    [{ value: "62.5 kbit/s", unit: "", raw: 3 }, "62.5"],
    [{ value: "1 Mbit/s", unit: "", raw: 9 }, "1000"],
    [{ value: 250000, unit: "bit/s", raw: 250000 }, "250"],
    [{ value: "automatic detection", unit: "", raw: 0 }, "auto"],
  ]) {
    await page.event("values", { "baud-rate": value });
    assert.equal((await page.question("bit-rate")).title, "Bit rate");
    assert.equal(page.element("question-input").value, chosen);
    await page.no();
  }
  // Only GEMAC sensors detect the rate.
  await page.connected("jn2101");
  await page.event("values", {});
  await page.question("bit-rate");
  const offered = page.element("question-input").options.map(({ value }) => value);
  assert.deepEqual(offered, answers.ports.rates.map(String));
  assert.equal(page.element("question-input").value, String(answers.devices.jn2101.device.rate ?? 125));
});

test("angle_out_of_range_does_not_keep_the_question_away", async () => {
  const page = await connected("is2");
  page.reply("api/run", new Refusal("refused", "the sensor refuses"));
  assert.match((await page.question("zero")).text, /angle-x -, angle-y -/);
  await page.no();
  page.reply("api/run", new Refusal("no-answer", "the sensor does not answer: check power and wiring", 504));
  await page.click("zero");
  assert.ok(!page.isAsking);
  assert.match(page.text("message"), /does not answer/);
});

test("request_goes_to_the_sensor_after_a_question_and_its_answer_is_shown", async () => {
  const page = await connected("is2");
  page.element("request").value = " 04 ";
  page.reply("api/run", { request: "04", answer: "04 01" });
  await page.dispatch("raw", "submit");
  assert.match(page.asked().text, /goes to the sensor as it is.*\n.*identifier 300h/);
  await page.yes();
  assert.deepEqual([page.requests.pop().body, page.text("answer")], [{ raw: { request: "04" } }, "04 01"]);
});

test("button_shows_that_its_action_runs_from_the_click_to_the_end", async () => {
  const page = await connected("is2");
  const isBusy = (id) => page.element(id).getAttribute("aria-busy");
  for (const [id, path] of [["zero", "api/run"], ["read", "api/run"], ["backup", "api/backup"], ["disconnect", "api/disconnect"]]) {
    let end;
    page.reply(path, () => new Promise((resolve) => { end = resolve; }));
    await page.click(id);
    assert.equal(isBusy(id), "true", id);
    end(new Refusal("refused", "the sensor refuses it"));
    await page.pass(0);
    if (page.isAsking) await page.no();
    assert.equal(isBusy(id), null, id);
  }
});

test("message_ends_with_its_cause", async () => {
  const page = await connected("is2");
  const fails = async (code, status) => {
    page.reply("api/backup", new Refusal(code, "a reason", status));
    await page.click("backup");
    assert.notEqual(page.text("message"), "", code);
  };
  await fails("no-answer", 504);
  await page.status({});
  assert.equal(page.text("message"), "a reason", "one answer was lost");
  await page.status({ silent: true });
  assert.equal(page.text("message"), "a reason");
  await page.status({});
  assert.equal(page.text("message"), "", "the sensor answers again");
  await page.event("status", { ...STATUS, state: "closed", error: texts("the adapter is gone: plug it in again") });
  assert.match(page.text("message"), /plug it in/);
  await page.status({});
  assert.equal(page.text("message"), "", "the adapter is back");
  await fails("not-connected", 400);
  await page.event("device", answers.devices.is2.device);
  assert.equal(page.text("message"), "");
});

test("values_that_are_not_stored_are_named_in_the_status", async () => {
  const page = await connected("is2");
  assert.ok(page.element("unsaved-row").hidden);
  await page.status({ unsaved: ["cut-off", "cyclic-time"] });
  assert.deepEqual([page.element("unsaved-row").hidden, page.text("unsaved")], [false, "cut-off, cyclic-time"]);
  await page.status({});
  assert.ok(page.element("unsaved-row").hidden);
});

test("second_question_does_not_replace_an_open_one", async () => {
  const page = await connected("is2");
  await page.question("save");
  await page.click("restart");
  assert.equal(page.asked().title, "Save in sensor");
  await page.yes();
  assert.deepEqual(page.requests.map(({ body }) => body), ["save"]);
});

test("log_has_the_newest_action_first_with_its_line_notes_and_end", async () => {
  const page = await open();
  assert.equal(page.element("log-empty").hidden, false);
  const row = (place) => page.element("log-rows").children[place];
  await page.event("action", { n: 1, at: 0, line: "plumbline get", state: "running" });
  await page.event("action", { n: 2, at: 0, line: "plumbline zero", state: "failed", notes: [texts("n1")], error: {}, texts: texts("a reason\nanother", "ein Grund") });
  assert.ok(page.element("log-empty").hidden);
  assert.match(row(0).textContent, /plumbline zero failed.*n1a reasonanother/);
  assert.deepEqual(row(0).children.slice(1).map(({ className }) => className), ["note", "failed", "failed"]);
  const button = row(1).querySelector("button");
  button.focus();
  await page.event("action", { n: 1, at: 0, line: "plumbline get", state: "done", notes: [texts("12 values")] });
  assert.match(row(1).textContent, /plumbline get done.*12 values/);
  assert.equal(document.activeElement, row(1).querySelector("button"), "the focus stays in a row that is replaced");
  row(1).querySelector("button").click();
  await page.pass(0);
  assert.deepEqual([page.copied, row(1).querySelector("button").textContent], [["plumbline get"], "Copied"]);
  // A question is no failure.
  await page.event("action", { n: 3, at: 0, line: "plumbline scan", state: "asks", error: {}, asks: [{ question: { id: "silent" }, texts: texts("Ask it?") }] });
  assert.deepEqual(row(0).children.slice(1).map(({ className }) => className), ["note"]);
  await page.change("language", "de");
  assert.match(row(0).textContent, /eine Frage/);
  assert.match(row(1).textContent, /ein Grund/);
  await page.end();
  page.isGone = false;
  await page.pass(1000);
  assert.equal(page.element("log-rows").children.length, 0, "the server tells its actions again");
});
