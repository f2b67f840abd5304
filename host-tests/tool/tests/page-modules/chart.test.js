// The chart: the samples that are kept, the edges of the picture, gaps, the file with the samples, and what is missing.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, CLOSED, open } from "./page.js";

/** Samples every 10 ms from this number on. */
const rows = (first, count) => Array.from({ length: count }, (_, place) => [(first + place) / 100, first + place, -1]);

/** A page that has these samples, and its chart. */
async function running(count) {
  const page = await open();
  await page.connected("is2");
  await page.samples(rows(0, count));
  await page.pass(100);
  return { page, plot: page.plots.at(-1) };
}

test("window_is_the_width_of_the_chart", async () => {
  const { page, plot } = await running(1000);
  assert.deepEqual(plot.options.series.map(({ label }) => label), ["time / s", "angle-x / deg", "angle-y / deg"]);
  for (const width of [5, 30]) {
    await page.change("window", String(width));
    await page.pass(100);
    assert.deepEqual(plot.edges, [-width, 0], "the newest sample is at 0");
    assert.equal(plot.data[0].at(-1), 0);
  }
  // Samples that are older than the window are not drawn.
  await page.change("window", "5");
  await page.pass(100);
  assert.deepEqual([plot.data[0][0], plot.data[0].length], [-5, 501]);
});

test("paused_chart_stays_and_goes_on_afterwards", async () => {
  const { page, plot } = await running(100);
  await page.click("pause");
  await page.pass(100);
  const still = [plot.data[0].length, plot.data[1].at(-1)];
  assert.deepEqual(still, [100, 99]);
  assert.equal(page.element("pause").getAttribute("aria-pressed"), "true");
  await page.samples(rows(100, 100), 100);
  await page.pass(100);
  assert.deepEqual([plot.data[0].length, plot.data[1].at(-1)], still);
  // The space bar is the same.
  const key = Object.assign(new Event("keydown", { cancelable: true }), { key: " " });
  page.element("chart").dispatchEvent(key);
  await page.pass(100);
  assert.ok(key.defaultPrevented);
  assert.equal(page.element("pause").getAttribute("aria-pressed"), "false");
  assert.deepEqual([plot.edges[1], plot.data[0].at(-1), plot.data[1].at(-1)], [0, 0, 199]);
});

test("arrow_keys_move_the_cursor", async () => {
  const { page, plot } = await running(100);
  const press = (name) => page.element("chart").dispatchEvent(Object.assign(new Event("keydown", { cancelable: true }), { key: name }));
  const places = ["ArrowRight", "ArrowRight", "ArrowLeft", "Tab"].map((name) => [press(name), plot.cursor.left]);
  assert.deepEqual(places, [[false, 300], [false, 304], [false, 300], [true, 300]]);
});

test("samples_are_saved_as_a_table_also_after_the_end_of_the_connection", async () => {
  const { page } = await running(3);
  await page.event("device", null);
  await page.event("status", CLOSED);
  await page.change("theme", "dark");
  assert.equal(page.element("chart").hidden, false);
  await page.click("csv");
  await page.click("clear");
  await page.pass(100);
  assert.ok(page.element("csv").disabled);
  assert.equal(page.element("chart-empty").hidden, false);
  assert.match(page.text("chart-empty"), /No samples yet/);
  await page.connected("is2");
  await page.samples(rows(3, 2), 3);
  await page.pass(100);
  await page.click("csv");
  assert.deepEqual(await page.saved(), [
    { name: "angles.csv", text: "time_s,angle-x_deg,angle-y_deg\n0.000,0,-1\n0.010,1,-1\n0.020,2,-1\n" },
    { name: "angles.csv", text: "time_s,angle-x_deg,angle-y_deg\n0.030,3,-1\n0.040,4,-1\n" },
  ]);
});

test("missing_samples_are_counted_and_a_new_connection_starts_again", async () => {
  const { page } = await running(10);
  assert.deepEqual(globalThis.plumbline, { count: 0, got: 10, streams: 1 });
  await page.samples(rows(15, 5), 15);
  await page.status({ lost: 2 });
  assert.deepEqual(globalThis.plumbline, { count: 5, got: 15, streams: 1 });
  assert.equal(page.text("lost"), "7");
  // The samples of a new connection to the same sensor begin at 0.
  await page.samples(rows(0, 2), 0);
  await page.pass(100);
  assert.equal(page.plots.at(-1).data[0].length, 2);
});

test("gap_in_the_samples_is_a_gap_in_the_lines", async () => {
  const { page, plot } = await running(3);
  await page.samples([[5], [9, 1, 1]], 3);
  await page.pass(100);
  const drawn = { data: plot.data, valToPos: (at) => at * 10 };
  const holes = plot.options.series[1].gaps(drawn, 1, 0, plot.data[0].length - 1, []);
  assert.deepEqual(holes, [[-90, 0]]);
  assert.deepEqual(plot.options.series[1].gaps(drawn, 1, 0, 2, [[1, 2]]), [[1, 2]]);
});

test("samples_per_second_go_to_the_server", async () => {
  const { page } = await running(1);
  await page.change("samples", "200");
  assert.deepEqual(page.requests.pop(), { path: "api/samples", body: { perSecond: 200 }, sensor: null });
  document.activeElement = document.body;
  await page.status({ samples: 10 });
  assert.equal(page.element("samples").value, "10");
});

test("ring_keeps_the_newest_rows_in_memory_of_a_fixed_size", async () => {
  const { page } = await running(1);
  const { Ring } = page.import("ring.js");
  const ring = new Ring(2, 10);
  const memory = ring.columns.map((column) => column.buffer);
  assert.deepEqual([ring.newest(), ring.since(0)[0].length], [0, 0]);
  for (let time = 0; time < 1005; time += 1) ring.push([time]);
  assert.deepEqual([...ring.since(-Infinity)[0]], [995, 996, 997, 998, 999, 1000, 1001, 1002, 1003, 1004]);
  assert.deepEqual([...ring.since(1001.5)[0]], [1002, 1003, 1004]);
  assert.ok(ring.since(1003)[1].every(Number.isNaN), "a value that is missing");
  assert.deepEqual(ring.columns.map((column) => column.buffer), memory);
  ring.clear();
  assert.deepEqual([ring.newest(), ring.length], [0, 0]);
});

test("samples_and_actions_need_no_more_memory_with_time", async () => {
  const { page, plot } = await running(1);
  const kept = [];
  for (let batch = 0; batch < 300; batch += 1) {
    const first = 1 + batch * 1000;
    // A pause of the sensor after each batch.
    await page.samples([...rows(first, 999), [(first + 999) / 100]], first);
    await page.event("action", { n: batch, at: 0, line: "plumbline get", state: "done" });
    if (batch % 150 === 149) kept.push([document.root.all().length, page.timers.length]);
  }
  assert.deepEqual(globalThis.plumbline, { count: 0, got: 300_001, streams: 1 });
  assert.deepEqual(kept[0], kept[1], "elements and timers");
  assert.equal(page.element("log-rows").children.length, 100);
  await page.change("window", "300");
  page.element("window").append(new Option("all", "10000"));
  await page.change("window", "10000");
  await page.pass(100);
  assert.equal(plot.data[0].length, 120_000, "10 minutes at 200 samples per second");
  const drawn = { data: plot.data, valToPos: (at) => at };
  assert.equal(plot.options.series[1].gaps(drawn, 1, 0, plot.data[0].length - 1, []).length, 51);
});

test("angles_that_the_sensor_sends_by_itself_are_named_with_their_period", async () => {
  const { page } = await running(10);
  assert.ok(page.element("sends").hidden);
  await page.status({ sendsEvery: 2.5 });
  assert.match(page.text("sends"), /by itself every 2\.5 ms/);
  await page.change("language", "de");
  assert.match(page.text("sends"), /alle 2,5 ms/);
});

/** A page with two sensors in the chart, and the number of the second one. */
async function beside() {
  const { page } = await running(3);
  const other = { ...answers.devices.jn2101.device, connection: 7, label: null };
  await page.event("others", [other]);
  await page.event("other-samples", { sensor: 7, first: 0, lost: 0, rows: [[0.005, 5, 6], [0.015, 7, 8]] });
  await page.pass(100);
  return { page, plot: page.plots.at(-1) };
}

test("samples_of_two_sensors_are_in_one_chart_on_one_axis_of_time", async () => {
  const { page, plot } = await beside();
  const labels = plot.options.series.map(({ label }) => label);
  assert.deepEqual(labels.slice(1, 4), ["is2 300: angle-x / deg", "is2 300: angle-y / deg", "jn2101 10: slope-long32 / deg"]);
  const rounded = plot.data[0].map((time) => Math.round(time * 1000));
  assert.deepEqual(rounded, [-20, -15, -10, -5, 0]);
  const column = (number) => [...plot.data[number]].map((value) => value ?? null);
  assert.deepEqual(column(1), [0, null, 1, null, 2]);
  assert.deepEqual(column(3), [null, 5, null, 7, null]);
  // The value at the cursor is the nearest one of each line.
  assert.equal(plot.options.cursor.dataIdx(plot, 3, 2), 1);
  await page.click("csv");
  const [{ text }] = await page.saved();
  assert.match(text, /^time_s,is2 300 angle-x_deg,is2 300 angle-y_deg,jn2101 10 slope-long32_deg,.*\n0\.000,0,-1,,\n0\.005,,,5,6\n/);
});

test("angle_of_a_sensor_that_is_switched_off_is_not_drawn", async () => {
  const { page } = await beside();
  page.element("drawn-1-0").checked = false;
  await page.change("drawn-1-0");
  assert.deepEqual(page.plots.at(-1).options.series.slice(1).map(({ show }) => show), [true, true, false, true]);
});

test("sensor_is_added_from_the_found_ones_and_removed", async () => {
  const { page } = await beside();
  const { rate } = answers.devices.is2.device;
  const row = { protocol: "canopen", address: "50", product: "ims360", rate };
  await page.event("found", [row, { ...row, address: "51", rate: 1000 }]);
  const [add, ...more] = page.element("found").all().filter((element) => element.dataset.kind === "add");
  assert.equal(more.length, 0, "a sensor at another bit rate is on another bus");
  add.click();
  await page.pass(0);
  const { connection } = answers.devices.is2.device;
  const expected = { path: "api/chart", body: { add: { protocol: "canopen", address: "50", yes: [] } }, sensor: String(connection) };
  assert.deepEqual(page.requests.pop(), expected);
  const [remove] = page.element("traces").querySelectorAll("button");
  remove.click();
  await page.pass(0);
  assert.deepEqual(page.requests.pop().body, { remove: 7 });
  await page.event("others", []);
  assert.equal(page.plots.at(-1).options.series.length, 3);
});

test("other_sensors_stay_after_the_end_of_the_connection_and_go_with_the_next_one", async () => {
  const { page } = await beside();
  await page.event("device", null);
  await page.event("status", CLOSED);
  await page.event("others", []);
  assert.equal(page.plots.at(-1).options.series.length, 5);
  await page.connected("is2");
  assert.equal(page.plots.at(-1).options.series.length, 3);
});
