// The virtual sensor: its sliders and fault buttons are there in a demonstration only.

import assert from "node:assert/strict";
import test from "node:test";
import { open } from "./page.js";

const STATE = { x: 3.5, y: -2, temperature: 25, supply: 24, fault: null, memory: false, on: true };

async function demonstration(name = "is2", options = {}) {
  const page = await open(options);
  await page.connected(name);
  await page.event("stand-in", STATE);
  page.requests.length = 0;
  return page;
}

const sent = (page) => page.requests.map(({ path, body }) => {
  assert.equal(path, "api/stand-in");
  return body;
});

test("virtual_sensor_is_shown_in_a_demonstration_only", async () => {
  const page = await open({ language: "de-DE" });
  await page.connected("is2");
  assert.ok(page.element("stand-in").hidden);
  await page.event("stand-in", STATE);
  assert.equal(page.element("stand-in").hidden, false);
  assert.equal(page.text("stand-in-x-value"), "3,5 °");
  assert.equal(page.text("stand-in-temperature-value"), "25 °C");
  await page.event("stand-in", null);
  assert.ok(page.element("stand-in").hidden);
});

test("sliders_send_the_newest_position_when_the_one_before_is_done", async () => {
  const page = await demonstration();
  /** @type {(value: object) => void} */
  let end = () => {};
  page.reply("api/stand-in", () => new Promise((resolve) => { end = resolve; }));
  for (const value of ["1", "2", "3"]) await page.dispatch("stand-in-x", "input", value);
  await page.dispatch("stand-in-supply", "input", "9.5");
  assert.deepEqual(sent(page), [{ do: "tilt", x: 1, y: -2 }]);
  assert.equal(page.text("stand-in-x-value"), "3.0 °");
  page.reply("api/stand-in", {});
  end({});
  await page.pass(0);
  assert.deepEqual(sent(page).slice(1), [{ do: "tilt", x: 3, y: -2 }, { do: "supply", volts: 9.5 }]);
});

test("fault_buttons_switch_a_fault_on_and_off", async () => {
  const page = await demonstration();
  for (const [id, state, request] of [
    ["fault-x", {}, { do: "accelerometer", fault: "axis-x" }],
    ["fault-x", { fault: "axis-x" }, { do: "accelerometer", fault: null }],
    ["fault-clipping", { fault: "axis-x" }, { do: "accelerometer", fault: "clipping" }],
    ["fault-stale", {}, { do: "accelerometer", fault: "frozen" }],
    ["fault-memory", {}, { do: "memory", fault: "programming" }],
    ["fault-memory", { memory: true }, { do: "memory", fault: null }],
    ["fault-power", {}, { do: "power", on: false }],
    ["fault-power", { on: false }, { do: "power", on: true }],
    ["fault-restart", {}, { do: "restart" }],
    ["fault-bus-off", {}, { do: "bus-off" }],
    ["fault-lose", {}, { do: "lose", count: 10, from: "sensors" }],
    ["fault-delay", {}, { do: "delay", count: 10, from: "sensors", seconds: 0.2 }],
    ["fault-corrupt", {}, { do: "corrupt", count: 10 }],
  ]) {
    await page.event("stand-in", { ...STATE, ...state });
    await page.click(id);
    assert.deepEqual(sent(page).pop(), request, id);
  }
  await page.event("stand-in", { ...STATE, fault: "axis-x" });
  assert.equal(page.element("fault-x").getAttribute("aria-pressed"), "true");
  assert.equal(page.element("fault-clipping").getAttribute("aria-pressed"), "false");
});

test("sensor_with_one_axis_has_one_slider_of_a_full_turn", async () => {
  const page = await demonstration();
  await page.connected("is2", { angles: [{ name: "angle", unit: "deg" }] });
  await page.event("stand-in", { ...STATE, x: 350 });
  assert.ok(page.element("stand-in-y-label").hidden);
  assert.deepEqual([page.element("stand-in-x").max, page.element("stand-in-x").value], ["180", "-10"]);
});
