// Another program for a sensor: what the question says, the backup, the downgrade, progress and result.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, CLOSED, open, Refusal, texts } from "./page.js";

const ABOUT = { product: "is2", version: "1.2.3", board: "bluepill", signed: false };
const DONE = { product: "is2", version: "1.2.3", before: "1.2.2", crc: 7, loaded: true, different: 0 };
const OLDER = [{ id: "downgrade", file: "1.2.3", own: "1.3.0" }, "The file has the older version 1.2.3.", "Die Datei hat die ältere Version 1.2.3."];

/** Chooses an image file of these bytes. */
async function choose(page, bytes = [1, 2, 255]) {
  page.element("update-file").files = [Object.assign(new Blob([new Uint8Array(bytes)]), { name: "is2.plu" })];
  await page.dispatch("update-file", "change");
  await page.pass(0);
}

async function ready(options = {}) {
  const page = await open(options);
  page.reply("api/image", ABOUT);
  page.reply("api/backup", { product: "is2", serial: 7, text: "settings" });
  page.reply("api/update", DONE);
  await page.connected("is2");
  page.requests.length = 0;
  await choose(page);
  return page;
}

test("update_reads_a_backup_loads_the_file_and_tells_both_versions", async () => {
  const page = await ready();
  assert.deepEqual(page.requests.shift(), { path: "api/image", body: { name: "is2.plu", image: [1, 2, 255] }, sensor: null });
  assert.equal(page.text("update-state"), "is2.plu: is2, version 1.2.3, for the board bluepill.");
  const asked = await page.question("update-start");
  assert.match(asked.text, /is2, version 1\.2\.3, for the board bluepill.*\n.*serial number 1/);
  await page.yes();
  const sensor = String(answers.devices.is2.device.connection);
  const body = { name: "is2.plu", image: [1, 2, 255], backup: "settings", waiting: null, yes: [] };
  assert.deepEqual(page.requests, [{ path: "api/backup", body: {}, sensor }, { path: "api/update", body, sensor }]);
  assert.equal(page.text("update-state"), "The sensor runs version 1.2.3, before it was 1.2.2. All settings are the same as before.");
  await page.click("update-backup");
  assert.deepEqual(await page.saved(), [{ name: "is2-7.toml", text: "settings" }]);
});

test("update_shows_its_progress_and_keeps_the_backup_after_an_error", async () => {
  const page = await ready({ language: "de-DE" });
  let end = () => {};
  page.reply("api/update", () => new Promise((resolve) => { end = resolve; }));
  await page.question("update-start");
  await page.yes();
  assert.equal(page.text("update-state"), "Der Sensor startet in seinen Bootloader.");
  await page.event("progress", { n: 1, done: 30, total: 60, texts: texts("loads", "lädt") });
  assert.equal(page.text("update-state"), "50 % lädt");
  assert.equal(Number(page.element("update-bar").value), 30);
  assert.ok(page.element("update-start").disabled && page.element("update-file").disabled);
  end(new Refusal("no-answer", "the bootloader does not answer", 504));
  await page.pass(0);
  assert.equal(page.text("message"), "the bootloader does not answer");
  assert.equal(page.element("update-backup").hidden, false);
  assert.equal(page.element("update-bar").hidden, true);
  // A sensor that does not answer has no settings to read.
  await page.status({ silent: true });
  assert.equal((await page.question("update-start")).field, "");
});

test("update_asks_before_an_older_version", async () => {
  const page = await ready();
  page.reply("api/update", ({ yes }) => (yes.length === 0 ? Refusal.asks(OLDER) : { ...DONE, before: "1.3.0", different: 2 }));
  await page.question("update-start");
  await page.yes({ checks: { 0: false } });
  assert.match(page.asked().text, /older version/);
  await page.yes();
  assert.deepEqual(page.requests.pop().body.yes, [OLDER[0]]);
  assert.match(page.text("update-state"), /before it was 1\.3\.0\. Settings that differ from those before: 2\./);
  assert.ok(page.element("update-backup").hidden, "no backup was wanted");
  page.reply("api/update", { ...DONE, before: null, loaded: false, different: null });
  await page.question("update-start");
  await page.no();
  assert.equal(page.requests.at(-1).path, "api/update", "a no sends nothing");
});

test("update_without_a_sensor_is_for_one_that_waits_at_the_address_of_the_bar", async () => {
  const page = await ready();
  await page.event("device", null);
  await page.event("status", CLOSED);
  page.element("port").value = "can0";
  await page.change("protocol", "canopen");
  page.element("address").value = "11";
  page.requests.length = 0;
  const asked = await page.question("update-start");
  assert.match(asked.text, /waits in its bootloader, at can0, node-ID 11\./);
  assert.equal(asked.field, "");
  page.reply("api/update", { ...DONE, before: null, different: null });
  await page.yes();
  const [{ path, body }] = page.requests;
  assert.equal(path, "api/update");
  assert.deepEqual([body.waiting.port, body.waiting.protocol, body.waiting.address, body.backup], ["can0", "canopen", "11", null]);
  assert.equal(page.text("update-state"), "The sensor runs version 1.2.3, before it was none.");
});

test("file_that_is_no_image_is_told_and_cannot_be_loaded", async () => {
  const page = await ready();
  page.reply("api/image", new Refusal("bad-file", "is2.plu is not valid: it is damaged"));
  await choose(page);
  assert.equal(page.text("message"), "is2.plu is not valid: it is damaged");
  assert.ok(page.element("update-start").disabled);
  page.requests.length = 0;
  // Header, signature, and the 128 KiB of the largest slot.
  const longest = 64 + 2508 + (128 << 10);
  await choose(page, new Array(longest + 1).fill(0));
  assert.match(page.text("message"), /longer than any image file/);
  assert.deepEqual(page.requests, []);
  await choose(page, new Array(longest).fill(0));
  assert.equal(page.requests.length, 1);
});
