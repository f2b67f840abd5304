// The offset of the mounting: two questions beside the page, between which the user turns the sensor.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, open, Refusal, texts } from "./page.js";

const TURN = [{ id: "turn", angles: [] }, "angle-x 3.00 deg. Turn the sensor", "angle-x 3.00 deg. Drehen Sie den Sensor"];
const ZERO = [{ id: "align", angles: [] }, "Compensate the mounting offset?", "Den Versatz zu Null machen?"];
const REPORT = { angles: [{ name: "angle-x", spread: 0.01, mounting: 1.234, surface: -2 }] };

/** A page with a sensor; the server asks both questions. */
async function connected(name = "is2", options = {}) {
  const page = await open(options);
  page.reply("api/align", ({ yes }) => (yes.length === 2 ? REPORT : Refusal.asks(yes.length === 0 ? TURN : ZERO)));
  await page.connected(name);
  page.requests.length = 0;
  return page;
}

test("align_asks_for_the_turn_and_for_zero_and_shows_the_offset", async () => {
  const page = await connected();
  const asked = await page.question("align");
  assert.match(asked.text, /180°.*\n.*serial number 1/);
  assert.match(asked.field, /Save it in the sensor/);
  await page.yes({ checks: { 0: true } });
  assert.match(page.asked().text, /Turn the sensor/);
  await page.yes();
  assert.match(page.asked().text, /offset\?/);
  await page.yes();
  const sensor = String(answers.devices.is2.device.connection);
  const sent = [[], [TURN[0]], [TURN[0], ZERO[0]]].map((yes) => ({ path: "api/align", body: { save: true, yes }, sensor }));
  assert.deepEqual(page.requests, sent);
  assert.equal(page.text("align-state"), "angle-x: the mounting offset was 1.23° and is compensated now; the surface is inclined by -2.00°, spread 0.01°.");
  // The result of another sensor is not shown.
  await page.connected("jn2101", { connection: 9 });
  assert.equal(page.text("align-state"), "");
});

test("align_shows_what_is_measured_and_why_it_waits", async () => {
  const page = await connected();
  /** @type {(report: unknown) => void} */
  let end = () => {};
  page.reply("api/align", () => new Promise((resolve) => { end = resolve; }));
  await page.question("align");
  await page.yes();
  assert.match(page.text("align-state"), /^Measuring: /);
  await page.event("note", { n: 1, texts: texts("the sensor is not at rest") });
  assert.match(page.text("align-state"), /the sensor is not at rest$/);
  assert.ok(page.element("align").disabled);
  end(REPORT);
  await page.pass(0);
  assert.match(page.text("align-state"), /1\.23/);
});

test("align_after_a_no_or_an_error_changes_nothing", async () => {
  const page = await connected();
  await page.question("align");
  await page.no();
  assert.equal(page.requests.length, 0);
  await page.question("align");
  await page.yes();
  await page.no();
  assert.equal(page.requests.length, 1);
  assert.equal(page.text("align-state"), "");
  page.reply("api/align", new Refusal("not-at-rest", "the sensor was not at rest for 60 s", 409));
  await page.question("align");
  await page.yes();
  assert.equal(page.text("message"), "the sensor was not at rest for 60 s");
  assert.equal(page.element("align").disabled, false);
});

test("align_is_offered_for_a_sensor_with_an_offset", async () => {
  const page = await connected("is2", { language: "de-DE" });
  for (const [name, change, isOffered] of [
    ["is2", {}, true], ["tiltix080", {}, true], ["ims360/j1939", {}, true], ["jn2101", {}, false], ["is2", { foreign: true }, false],
  ]) {
    await page.connected(name, change);
    assert.equal(page.element("align").hidden, !isOffered, name);
  }
  await page.connected("tiltix080");
  const asked = await page.question("align");
  assert.equal(asked.title, "Ausrichten");
  assert.equal(asked.field, "");
});
