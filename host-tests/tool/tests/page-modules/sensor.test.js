// What the page shows of a sensor: the large angles, the status in words, the drawing, the frames, the calibration.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, CLOSED, open, STATUS, texts } from "./page.js";

const angles = (page) => [0, 1].map((number) => page.text(`angle-${number}`));

test("angles_have_two_decimals_and_the_unit_of_the_sensor", async () => {
  const page = await open();
  await page.connected("is2");
  await page.samples([[0.01, 1, 1], [0.02, 12.504, -5]]);
  await page.pass(400);
  assert.deepEqual(angles(page), ["12.50", "-5.00"]);
  assert.match(page.text("angle-values"), /angle-x12\.50 °angle-y-5\.00 °/);
  assert.ok(page.element("angles-empty").hidden);
  // An angle that the sensor does not know.
  await page.samples([[0.03, null, 7]], 2);
  await page.pass(400);
  assert.deepEqual(angles(page), ["-", "7.00"]);
});

test("numbers_have_a_comma_in_german", async () => {
  const page = await open({ language: "de-DE" });
  await page.connected("is2");
  await page.samples([[0, 12.5, -5]]);
  await page.pass(1000);
  assert.deepEqual(angles(page), ["12,50", "-5,00"]);
  assert.match(page.text("box-title"), /angle-x 12,5 deg, angle-y -5,0 deg/);
  const { options } = page.plots.at(-1);
  assert.deepEqual([options.series[1].value(null, 1.5), options.series[1].value(null, null)], ["1,50", "-"]);
  assert.deepEqual(options.axes.map((axis) => axis.values(null, [-2.5, 0])), [["-2,5", "0"], ["-2,5", "0"]]);
});

test("old_angles_are_not_shown", async () => {
  const page = await open();
  const shows = async () => {
    await page.samples([[page.now / 1000, 1, 2]]);
    await page.pass(400);
    assert.deepEqual(angles(page), ["1.00", "2.00"]);
    await page.pass(100);
    assert.ok(!page.element("box").classList.contains("old"));
  };
  const hides = async (why) => {
    await page.pass(400);
    assert.deepEqual(angles(page), ["-", "-"], why);
    await page.pass(1000);
    assert.ok(page.element("box").classList.contains("old"), why);
    assert.match(page.text("box-title"), /angle-x - deg/, why);
  };
  await page.connected("is2");
  await shows();
  await page.pass(1500);
  await hides("no samples for more than a second");
  await shows();
  await page.status({ samples: 0 });
  await hides("sampling is off");
  assert.match(page.text("angles-empty"), /Sampling is off: choose the samples per second/);
  await page.status({});
  await shows();
  await page.status({ silent: true });
  await hides("the sensor does not answer");
  assert.match(page.text("angles-empty"), /does not answer: check power and wiring/);
  await page.status({});
  await shows();
  await page.event("status", CLOSED);
  await hides("not connected");
  assert.match(page.text("angles-empty"), /connect to a sensor/);
  await page.status({});
  await shows();
  await page.end();
  await hides("the server is gone");
});

test("one_sample_per_second_is_new_for_two_seconds_and_a_half", async () => {
  const page = await open();
  await page.connected("is2");
  await page.status({ samples: 1 });
  await page.samples([[0, 1, 2]]);
  await page.pass(2400);
  assert.deepEqual(angles(page), ["1.00", "2.00"]);
  await page.pass(400);
  assert.deepEqual(angles(page), ["-", "-"]);
});

test("data_sheet_without_angles_says_where_the_values_are", async () => {
  const page = await open();
  await page.connected("tiltix080", { angles: [], zero: [] });
  assert.match(page.text("angles-empty"), /does not say which values are angles.*Read again/);
  assert.equal(page.element("angles-empty").hidden, false);
});

test("status_is_told_in_words_of_both_languages", async () => {
  const page = await open();
  await page.connected("is2");
  const condition = page.element("condition");
  await page.event("condition", []);
  assert.equal(condition.textContent, "Status: no error");
  await page.event("condition", [{ name: "DefaultParam", error: false }]);
  assert.equal(condition.textContent, "Status: no error, factory values");
  assert.ok(!condition.classList.contains("bad"));
  await page.event("condition", [{ name: "SensorErrorX", error: true }, { name: "unheard of", error: false }]);
  assert.equal(condition.textContent, "Status: the X axis failed or is out of range (SensorErrorX), unheard of");
  assert.ok(condition.classList.contains("bad"));
  await page.change("language", "de");
  assert.match(condition.textContent, /die X-Achse ist gestört oder außerhalb ihres Bereichs \(SensorErrorX\)/);
  await page.event("condition", [{ name: "voltage", error: true }, { name: "refused", texts: texts("refused", "abgelehnt"), error: true }]);
  assert.equal(condition.textContent, "Status: Spannung, abgelehnt");
  await page.event("condition", []);
  assert.match(condition.textContent, /kein Fehler/);
  assert.ok(!condition.classList.contains("bad"));
});

test("status_of_a_sensor_that_does_not_answer_or_is_not_asked_is_unknown", async () => {
  const page = await open();
  await page.connected("is2");
  await page.event("condition", [{ name: "SensorErrorX", error: true }]);
  for (const change of [{ silent: true }, { samples: 0 }]) {
    await page.status(change);
    assert.equal(page.text("condition"), "Status: unknown");
    assert.ok(!page.element("condition").classList.contains("bad"));
    await page.status({});
    assert.match(page.text("condition"), /SensorErrorX/);
  }
  await page.event("device", null);
  assert.equal(page.text("condition"), "");
});

test("drawing_turns_with_the_angles_and_tells_them", async () => {
  const page = await open();
  await page.connected("is2");
  const faces = () => page.element("box").querySelectorAll("polygon").map((face) => face.getAttribute("points"));
  const pictures = new Set();
  for (const [x, y] of [[20, 10], [-20, 10], [-20, -10]]) {
    await page.samples([[0, x, y]]);
    await page.pass(1000);
    assert.equal(page.text("box-title"), `Attitude of the sensor: angle-x ${x}.0 deg, angle-y ${y}.0 deg`);
    assert.deepEqual(faces().map((points) => points.split(" ").length), [4, 4, 4, 4, 4, 4]);
    pictures.add(faces().join("/"));
  }
  assert.equal(pictures.size, 3);
});

test("drawing_names_the_axes_of_a_sensor_with_two_angles", async () => {
  const page = await open();
  await page.connected("is2");
  const names = () => page.element("box").querySelectorAll("text");
  const place = (name) => ["x", "y"].map((key) => Number(name.getAttribute(key)));
  await page.samples([[0, 0, 0]]);
  await page.pass(100);
  assert.deepEqual(names().map((name) => [name.textContent, name.getAttribute("visibility")]), [["X", "visible"], ["Y", "visible"]]);
  const level = names().map(place);
  // A positive X lowers the X axis, a positive Y raises the Y axis; in the picture, down is positive.
  await page.samples([[1, 20, 0]], 1);
  await page.pass(100);
  assert.ok(place(names()[0])[1] > level[0][1]);
  await page.samples([[2, 0, 20]], 2);
  await page.pass(100);
  assert.ok(place(names()[1])[1] < level[1][1]);
  const { angles: [angle] } = answers.devices.is2.device;
  await page.connected("is2", { angles: [angle] });
  await page.samples([[3, 5]], 3);
  await page.pass(100);
  assert.deepEqual(names().map((name) => name.getAttribute("visibility")), ["hidden", "hidden"]);
});

test("drawing_shows_a_turned_corner_at_its_place", async () => {
  const page = await open();
  const { project } = page.import("attitude.js");
  const [turn, tilt, third] = [35, 20, 30].map((angle) => (angle * Math.PI) / 180);
  const [sine, cosine] = [Math.sin(third), Math.cos(third)];
  // The viewer looks along `ahead`, 35 deg to the left of the Y axis and 20 deg down; right, down and ahead are the axes of the picture.
  const level = [-Math.sin(turn), Math.cos(turn)];
  const right = [Math.cos(turn), Math.sin(turn), 0];
  const down = [-Math.sin(tilt) * level[0], -Math.sin(tilt) * level[1], -Math.cos(tilt)];
  const ahead = [Math.cos(tilt) * level[0], Math.cos(tilt) * level[1], -Math.sin(tilt)];
  for (const [corner, angles, place] of [
    // The X axis moves down, the Y axis moves up.
    [[1, 0, 0], [30, 0], [cosine, 0, -sine]],
    [[0, 1, 0], [30, 0], [0, 1, 0]],
    [[0, 0, 1], [30, 0], [sine, 0, cosine]],
    [[1, 0, 0], [0, 30], [1, 0, 0]],
    [[0, 1, 0], [0, 30], [0, cosine, sine]],
    [[0, 0, 1], [0, 30], [0, -sine, cosine]],
    [[1, 0, 0], [30], [cosine, 0, sine]],
    [[0, 1, 0], [30], [0, 1, 0]],
  ]) {
    const shown = project(corner, angles);
    [right, down, ahead].forEach((axis, number) => {
      const along = axis.reduce((sum, part, at) => sum + part * place[at], 0);
      assert.ok(Math.abs(shown[number] - along) < 1e-9, `${corner} ${angles} ${number}: ${shown[number]}, not ${along}`);
    });
  }
});

test("faces_are_painted_from_the_back_to_the_front", async () => {
  const page = await open();
  const { paint, faces, look } = page.import("attitude.js");
  const painted = faces();
  paint(painted, look);
  assert.deepEqual(painted.slice(-3).map((face) => face.getAttribute("class")).sort(), ["front", "side", "top"], "the sides towards the viewer");
});

test("frames_are_listed_and_a_silent_bus_says_what_to_check", async () => {
  const page = await open();
  assert.match(page.text("frames-empty"), /connect/);
  await page.event("status", { ...STATUS, state: "listening" });
  assert.match(page.text("frames-empty"), /^Listening, nothing heard\. Check the bit rate/);
  const frame = { id: "301h", data: "04 00", remote: false, count: 3, period: 20_000, own: false, meaning: "canopen 10: SDO" };
  await page.event("frames", [{ ...frame, id: "300h", own: true, period: null, meaning: null }, frame, { ...frame, id: "722h", remote: true }]);
  assert.ok(page.element("frames-empty").hidden);
  const rows = () => page.element("frame-rows").children.map((line) => line.children.map((cell) => cell.textContent));
  assert.deepEqual(rows(), [
    ["300h (sent)", "04 00", "-", "3", ""], ["301h", "04 00", "20.0 ms", "3", "canopen 10: SDO"], ["722h", "RTR", "20.0 ms", "3", "canopen 10: SDO"],
  ]);
  for (const [text, ids] of [["722", ["722h"]], ["sdo", ["301h", "722h"]], ["nothing", []]]) {
    await page.dispatch("frames-filter", "input", text);
    assert.deepEqual(rows().map(([id]) => id), ids, text);
  }
  await page.dispatch("frames-filter", "input", "");
  const [, kept] = page.element("frame-rows").children;
  await page.event("frames", [{ ...frame, count: 4 }]);
  assert.deepEqual(rows(), [["301h", "04 00", "20.0 ms", "4", "canopen 10: SDO"]]);
  assert.equal(page.element("frame-rows").children[0], kept);
  await page.event("frames", []);
  assert.equal(page.element("frames-empty").hidden, false);
});

test("calibration_leads_through_the_positions_and_only_the_button_takes_one", async () => {
  const page = await open();
  const states = () => page.element("calibrate-positions").children.map((item) => item.textContent);
  const off = (ids) => ids.map((id) => page.element(`calibrate-${id}`).disabled);
  const buttons = ["start", "take", "again", "stop"];
  assert.match(page.text("calibrate-step"), /There is no unit/);
  assert.deepEqual(off(buttons), [true, true, true, true]);
  await page.event("calibration", { state: "idle", line: "plumbline calibrate", demo: true });
  assert.deepEqual([page.text("calibrate-line"), ...off(buttons)], ["plumbline calibrate", false, true, true, true]);
  await page.click("calibrate-start");
  assert.deepEqual(page.requests.pop(), { path: "api/calibrate", body: "start", sensor: null });
  const asking = { state: "asking", place: 1, side: "+z", taken: [], question: 5,
    measured: { state: "ready", up: "+z", acceleration: [1, 2, 1000], spread: 0.5, temperature: 25 } };
  await page.event("calibration", asking);
  assert.equal(page.text("calibrate-step"), "Position 1 of 6: place the sensor at rest on a level surface with +z up. +z is up and at rest.");
  assert.equal(page.text("calibrate-numbers"), "x 1.0 mg, y 2.0 mg, z 1000.0 mg, spread 0.50 mg, 25.0 °C");
  assert.deepEqual(states(), ["+z: now", "-z: missing", "+x: missing", "-x: missing", "+y: missing", "-y: missing"]);
  assert.deepEqual(off(buttons), [true, false, false, false]);
  for (const id of ["again", "take"]) {
    await page.click(`calibrate-${id}`);
    assert.deepEqual(page.requests.pop().body, { [id]: 5 });
  }
  const measured = { ...asking.measured, state: "other-side", up: "+x" };
  await page.event("calibration", { ...asking, state: "measuring", place: 2, side: "-z", taken: ["+z"], question: null, measured });
  assert.match(page.text("calibrate-step"), /with -z up\. \+x is up, not -z\./);
  assert.deepEqual(states().slice(0, 2), ["+z: taken", "-z: now"]);
  assert.deepEqual(off(buttons), [true, true, true, false]);
  await page.click("calibrate-stop");
  assert.equal(page.requests.pop().body, "stop");
  await page.event("calibration", { state: "failed", error: texts("stopped: the positions are in the file") });
  assert.ok(page.element("calibrate-step").classList.contains("bad"));
  assert.match(page.text("calibrate-step"), /^stopped/);
  assert.deepEqual(off(buttons), [false, true, true, true]);
  await page.event("calibration", { state: "done", result: { offset_mg: [1, -2.5, 0] }, next: texts("flash is2.bin") });
  assert.deepEqual([page.text("calibrate-numbers"), page.text("calibrate-next")],
    ["offset x 1.00 mg, offset y -2.50 mg, offset z 0.00 mg", "flash is2.bin"]);
  assert.ok(states().every((text) => text.endsWith("taken")));
});
