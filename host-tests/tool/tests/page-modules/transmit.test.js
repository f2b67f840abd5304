// The transmit list and the replay of a log.

import assert from "node:assert/strict";
import test from "node:test";
import { open, Refusal, STATUS } from "./page.js";

const LINES = [
  { number: 1, frame: "181#0102", every: 100, running: true, sent: 7, leftOut: 1 },
  { number: 3, frame: "080#", every: null, running: false, sent: 0, leftOut: 0 },
];
const rows = (page) => page.element("transmit-rows").children.map((line) => line.children.map((cell) => cell.textContent));
const buttons = (page, row) => page.element("transmit-rows").children[row].children[0].children;

test("each_line_of_the_list_is_added_started_stopped_and_removed_with_its_number", async () => {
  const page = await open();
  assert.ok(page.element("transmit-scroll").hidden);
  page.element("transmit-every").value = "100";
  await page.dispatch("transmit-frame", "input", "181#0102");
  await page.dispatch("transmit-form", "submit");
  assert.deepEqual(page.requests.pop(), { path: "api/transmit", body: { add: { frame: "181#0102", every: 100 } }, sensor: null });
  assert.equal(page.element("transmit-frame").value, "");
  page.element("transmit-every").value = "";
  page.reply("api/transmit", new Refusal("bad-value", "this is no frame"));
  await page.dispatch("transmit-frame", "input", "181");
  await page.dispatch("transmit-form", "submit");
  assert.deepEqual(page.requests.pop().body, { add: { frame: "181", every: null } });
  assert.deepEqual([page.text("message"), page.element("transmit-frame").value], ["this is no frame", "181"]);
  page.reply("api/transmit", {});
  await page.status({});
  await page.event("transmission", { lines: LINES, log: null });
  assert.deepEqual(rows(page), [["StopRemove", "181#0102", "100 ms", "7", "1"], ["SendRemove", "080#", "once", "0", "0"]]);
  const sent = [];
  for (const [row, place] of [[0, 0], [1, 0], [1, 1]]) {
    buttons(page, row)[place].click();
    await page.pass(0);
    sent.push(page.requests.pop().body);
  }
  assert.deepEqual(sent, [{ stop: 1 }, { start: 3 }, { remove: 3 }]);
  const [kept] = page.element("transmit-rows").children;
  await page.event("transmission", { lines: [{ ...LINES[0], running: false, sent: 8 }], log: null });
  assert.deepEqual(rows(page), [["StartRemove", "181#0102", "100 ms", "8", "1"]]);
  assert.equal(page.element("transmit-rows").children[0], kept);
  await page.change("language", "de");
  assert.deepEqual(rows(page), [["StartenEntfernen", "181#0102", "100 ms", "8", "1"]]);
});

test("nothing_can_be_started_where_nothing_can_be_sent", async () => {
  const page = await open();
  await page.event("transmission", { lines: LINES, log: null });
  for (const [state, busy, isOff] of [["closed", null, true], ["listening", null, true], ["open", null, false], ["active", "save", true], ["active", null, false]]) {
    await page.event("status", { ...STATUS, state, busy });
    const [stop, start] = [0, 1].map((row) => buttons(page, row)[0].disabled);
    assert.deepEqual([stop, start, page.element("replay-start").disabled], [false, isOff, isOff], state);
  }
});

test("log_is_sent_with_its_speed_and_interface_and_the_page_tells_how_far_it_is", async () => {
  const page = await open();
  await page.status({});
  page.element("replay-file").files = [Object.assign(new Blob(["(1) can0 123#"]), { name: "crane.log" })];
  page.element("replay-speed").value = "0,5";
  page.element("replay-interface").value = " can0 ";
  await page.dispatch("replay-form", "submit");
  await page.pass(0);
  const log = { name: "crane.log", text: "(1) can0 123#", speed: 0.5, repeats: false, interface: "can0" };
  assert.deepEqual(page.requests.pop().body, { replay: log });
  const told = { name: "crane.log", frames: 10, sent: 3, running: true };
  await page.event("transmission", { lines: [], log: told });
  assert.equal(page.text("replay-state"), "Sends crane.log: frames sent 3, frames in the log 10.");
  await page.click("replay-stop");
  assert.equal(page.requests.pop().body, "stop-replay");
  await page.event("transmission", { lines: [], log: { ...told, running: false } });
  assert.equal(page.text("replay-state"), "crane.log has ended: frames sent 3, frames in the log 10.");
  assert.ok(page.element("replay-stop").disabled);
});
