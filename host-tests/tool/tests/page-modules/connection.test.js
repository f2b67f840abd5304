// The connection bar: what it sends, which questions it asks, what it says of the bus and of the sensors that were found.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, CLOSED, open, Refusal, STATUS, texts, TOKEN } from "./page.js";

const value = (page, id) => page.element(id).value;

test("page_offers_ports_rates_and_products_of_the_server", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  const offered = page.element("ports").children.map((option) => option.value);
  assert.ok(["demo:is2", "demo:ims360/j1939"].every((port) => offered.includes(port)), offered.join());
  assert.deepEqual(page.element("rate").options.slice(1).map((option) => Number(option.value)), answers.ports.rates);
  assert.deepEqual(page.element("template").options.map((option) => option.value), answers.products.map(({ sheet }) => sheet));
  assert.equal(page.text("state"), "not connected");
});

test("page_fills_in_the_sensor_of_the_command_line", async () => {
  const first = { port: "can0", rate: 250, protocol: "canopen", address: "10", product: "jn2101" };
  const page = await open({ prepare: (own) => own.reply("api/ports", { ...answers.ports, first }) });
  assert.deepEqual(["port", "rate", "protocol", "address", "product"].map((id) => value(page, id)), ["can0", "250", "canopen", "10", "jn2101"]);
  assert.equal(page.element("address-label").hidden, false);
});

test("connect_sends_what_the_bar_says", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  assert.equal(page.element("address-label").hidden, true);
  page.element("port").value = " can0 ";
  await page.dispatch("connection", "submit");
  const sent = { port: "can0", rate: null, mode: "active", protocol: null, address: null, product: null, yes: [] };
  assert.deepEqual(page.requests.pop(), { path: "api/connect", body: sent, sensor: null });
  page.element("rate").value = "62.5";
  page.element("mode").value = "listen";
  await page.change("protocol", "j1939");
  assert.deepEqual([page.element("address-label").hidden, page.element("address").required], [false, true]);
  page.element("address").value = "160";
  page.element("product").value = "ims360";
  await page.dispatch("connection", "submit");
  const all = { port: "can0", rate: 62.5, mode: "listen", protocol: "j1939", address: "160", product: "ims360", yes: [] };
  assert.deepEqual(page.requests.pop().body, all);
});

test("find_without_a_port_asks_for_it_and_sends_nothing", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  page.element("port").value = "";
  await page.click("find");
  assert.equal(document.activeElement.id, "port");
  assert.ok(!page.isAsking);
  assert.deepEqual(page.requests, []);
});

test("scan_asks_first_and_sends_the_boxes", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  page.element("port").value = "can0";
  assert.equal((await page.question("find")).title, "Find sensors at can0");
  await page.no();
  assert.deepEqual(page.requests, []);
  for (const [checks, active, search] of [[{}, false, false], [{ 0: true }, true, false], [{ 1: true }, true, true]]) {
    await page.click("find");
    await page.yes({ checks });
    assert.deepEqual(page.requests.pop().body, { port: "can0", rate: null, active, search, yes: [] });
  }
});

test("question_of_the_program_goes_on_only_after_its_yes", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  page.element("port").value = "can0";
  const question = { id: "more" };
  page.reply("api/scan", ({ yes }) => (yes.some(({ id }) => id === "more") ? [] : Refusal.asks([question, "More?"])));
  await page.click("find");
  await page.yes({ checks: { 1: true } });
  assert.equal(page.asked().text, "More?");
  assert.equal(page.asked().yes, "Yes");
  await page.no();
  assert.equal(page.requests.length, 1);
  assert.equal(page.text("message"), "");
  await page.click("find");
  await page.yes({ checks: { 1: true } });
  await page.yes();
  assert.deepEqual(page.requests.map(({ body }) => body.yes), [[], [], [question]]);
  assert.ok(!page.isAsking);
  assert.equal(page.text("message"), "");
});

test("no_to_the_first_product_leads_to_the_question_about_the_second_one", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  const [one, other] = ["is2", "is2d"].map((product) => ({ id: "which-product", article: "PR-23020-00", products: "is2 or is2d", product }));
  page.reply("api/connect", ({ yes }) => (yes.some(({ product }) => product === "is2d") ? {} : Refusal.asks([one, "Is it is2?"], [other, "Is it is2d?"])));
  await page.dispatch("connection", "submit");
  assert.equal(page.asked().text, "Is it is2?");
  await page.no();
  assert.equal(page.asked().text, "Is it is2d?");
  await page.yes();
  assert.deepEqual(page.requests.map(({ body }) => body.yes), [[], [other]]);
});

test("question_of_the_program_is_in_the_language_of_the_page", async () => {
  const page = await open({ language: "de-DE" });
  await page.event("status", CLOSED);
  const question = { id: "likely", protocol: "fsc", address: "300" };
  page.reply("api/connect", ({ yes }) => (yes.length > 0 ? {} : Refusal.asks([question, "Ask it?", "Ihn fragen?"])));
  await page.dispatch("connection", "submit");
  assert.equal(page.asked().text, "Ihn fragen?");
  await page.yes();
  assert.deepEqual(page.requests.at(-1).body.yes, [question], "the yes is the question");
});

test("page_says_that_it_connects_and_how_it_ended", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  let end;
  page.reply("api/connect", () => new Promise((resolve) => { end = resolve; }));
  await page.dispatch("connection", "submit");
  assert.match(page.text("found-empty"), /^Connecting/);
  end(new Refusal("no-answer", "nobody answers", 504));
  await page.pass(0);
  assert.match(page.text("found-empty"), /^No sensor yet/);
  assert.equal(page.text("message"), "nobody answers");
  // The next action takes the message away.
  page.reply("api/connect", {});
  await page.dispatch("connection", "submit");
  assert.equal(page.text("message"), "");
});

test("scan_without_a_result_names_the_next_step", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  page.element("port").value = "can0";
  for (const [code, empty] of [
    ["nothing-found", /Press Find sensors again.*Send requests as well/],
    ["stopped", /^Stopped/],
    ["adapter-lost", /^No sensor yet. Choose a port/],
  ]) {
    page.reply("api/scan", new Refusal(code, code, 502));
    await page.click("find");
    await page.yes();
    assert.match(page.text("found-empty"), empty, code);
    assert.equal(page.text("message"), code);
  }
});

test("progress_of_a_scan_is_shown_until_its_end", async () => {
  const page = await open();
  await page.event("status", { ...CLOSED, busy: "scan" });
  assert.deepEqual(["connect", "find", "disconnect", "stop"].map((id) => page.element(id).disabled), [true, true, true, false]);
  assert.equal(page.text("state"), "busy: scan");
  await page.event("progress", { done: 2, total: 10, texts: texts("listened at 125 kbit/s") });
  const bar = page.element("progress-bar");
  assert.deepEqual([bar.value, bar.max, bar.hidden, page.text("progress")], ["2", 10, false, "2/10 listened at 125 kbit/s"]);
  await page.click("stop");
  assert.equal(page.requests.pop().path, "api/stop");
  await page.event("action", { n: 1, at: 0, line: "plumbline scan", state: "failed", error: {}, texts: texts("stopped") });
  assert.deepEqual([bar.hidden, page.text("progress")], [true, ""]);
});

const ROW = { product: "jn2101", label: null, rate: 125, protocol: "canopen", address: "10", serial: 1, article: "JN2101", firmware: "1.0" };

test("found_sensor_is_listed_and_connected_by_its_button", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  page.element("port").value = "demo:jn2101";
  await page.event("found", [ROW, { ...ROW, product: null, address: null, serial: null, article: null, firmware: null }]);
  assert.equal(page.element("found-scroll").hidden, false);
  const [first, second] = page.element("found").children;
  assert.deepEqual(first.children.slice(1).map((cell) => cell.textContent), ["jn2101", "", "125", "node-ID 10", "1", "JN2101", "1.0"]);
  assert.equal(second.querySelector("button"), null, "without an address there is nothing to connect");
  const button = first.querySelector("button");
  button.focus();
  button.click();
  await page.pass(0);
  assert.deepEqual(["rate", "protocol", "address", "mode"].map((id) => value(page, id)), ["125", "canopen", "10", "active"]);
  assert.equal(page.requests.pop().body.address, "10");
  // A row that stays the same keeps the focus.
  await page.event("found", [ROW, { ...ROW, product: null, address: null, serial: null, article: null, firmware: null }]);
  assert.equal(document.activeElement, button);
});

test("found_sensor_is_connected_during_the_scan_after_its_stop", async () => {
  const page = await open();
  await page.event("status", CLOSED);
  page.element("port").value = "demo:jn2101";
  let end;
  page.reply("api/scan", () => new Promise((resolve) => { end = resolve; }));
  await page.click("find");
  await page.yes();
  await page.event("found", [ROW]);
  page.element("found").children[0].querySelector("button").click();
  await page.pass(0);
  assert.deepEqual(page.requests.map(({ path }) => path), ["api/scan", "api/stop"]);
  end(new Refusal("stopped", "stopped by the user: start the command again to finish it", 502));
  await page.event("action", { n: 1, at: 0, line: "plumbline scan", state: "failed" });
  assert.equal(page.requests.at(-1).path, "api/connect");
  assert.equal(page.text("message"), "", "a scan that gave way is no failure");
});

test("bar_shows_rate_frames_per_second_errors_and_lost_samples", async () => {
  const page = await open();
  const texts = () => ["state", "bus", "frames-per-second", "errors", "lost"].map((id) => page.text(id));
  await page.event("status", { ...CLOSED, errors: null });
  assert.deepEqual(texts(), ["not connected", "-", "0", "unknown", "0"]);
  await page.status({ port: "can0", rate: 250, perSecond: 110, errors: 7, lost: 2 });
  assert.deepEqual(texts(), ["connected", "can0 250 kbit/s", "110", "7", "2"]);
  await page.status({ port: "can0", rate: 250, errors: 0, unread: { lines: 19, first: "y123" } });
  assert.equal(page.text("errors"), "0; lines of the adapter that are not slcan: 19, the first is y123");
  await page.status({ port: "can0", rate: null, errors: null, silent: true });
  assert.deepEqual(texts(), ["the sensor does not answer", "can0", "100", "unknown", "0"]);
  await page.status({ state: "listening", port: "can0", rate: 125 });
  assert.equal(page.text("state"), "listening");
});

test("command_lines_that_record_the_same_are_shown_while_connected", async () => {
  const page = await open();
  await page.status({ samples: 200 });
  assert.equal(page.text("record-line"), "plumbline --port demo:is2 --rate 125 --id 300 record angles.csv --every 5");
  assert.equal(page.text("log-line"), "plumbline --port demo:is2 --rate 125 --id 300 log frames.log");
  assert.deepEqual([page.element("record-note").hidden, page.element("log-note").hidden], [false, false]);
  await page.status({ state: "listening" });
  assert.deepEqual([page.element("record-note").hidden, page.element("log-note").hidden], [true, false]);
  await page.event("status", CLOSED);
  assert.deepEqual([page.element("record-note").hidden, page.element("log-note").hidden], [true, true]);
});

test("page_without_its_server_says_so_and_offers_no_action", async () => {
  const page = await open();
  await page.connected("is2");
  await page.event("found", [ROW]);
  await page.end();
  assert.match(page.text("state"), /start `plumbline serve` again/);
  assert.match(page.text("message"), /start `plumbline serve` again/);
  assert.equal(page.text("frames-per-second"), "-");
  assert.equal(page.text("condition"), "Status: unknown");
  const off = ["connect", "disconnect", "find", "stop", "zero", "save", "restart", "read", "backup", "send", "samples", "calibrate-start", "new-file"];
  assert.deepEqual(off.filter((id) => !page.element(id).disabled), []);
  assert.ok(page.element("found").querySelector("button").disabled);
  // It connects again by itself.
  page.isGone = false;
  await page.pass(1000);
  await page.connected("is2");
  assert.deepEqual([page.text("state"), page.text("message")], ["connected", ""]);
});

test("sixth_tab_says_what_to_close_and_connects_then", async () => {
  const prepare = (own) => { own.refused = new Refusal("too-many-tabs", "5 tabs are already open", 503).response(); };
  const page = await open({ prepare });
  assert.equal(page.text("message"), "5 tabs are already open");
  assert.match(page.text("state"), /five tabs are open/);
  assert.ok(page.element("disconnect").disabled);
  await page.change("language", "de");
  page.refused = null;
  await page.pass(1000);
  await page.event("status", CLOSED);
  assert.deepEqual([page.text("state"), page.text("message")], ["nicht verbunden", ""]);
});

test("secret_is_kept_for_the_tab_and_not_in_the_address", async () => {
  const page = await open();
  assert.equal(location.hash, "");
  // A secret that another server has given is taken.
  location.hash = "#nothing";
  page.window.dispatchEvent(new Event("hashchange"));
  assert.equal(page.reloads, 0);
  location.hash = `#${"0".repeat(32)}`;
  page.window.dispatchEvent(new Event("hashchange"));
  assert.equal(page.reloads, 1);
  await open({ hash: "", kept: { "plumbline-token": TOKEN } });
});

test("page_without_the_secret_says_what_to_open", async () => {
  const prepare = (own) => { own.refused = new Refusal("forbidden", "open the address that `plumbline serve` has printed", 401).response(); };
  const page = await open({ prepare });
  assert.match(page.text("message"), /open the address that `plumbline serve` has printed/);
});

test("event_in_two_pieces_of_the_stream_is_one_event", async () => {
  const page = await open();
  const bytes = new TextEncoder().encode(`event: status\ndata: ${JSON.stringify({ ...STATUS, port: "ä" })}\n\nevent: note\ndata: {"texts":{"en":"x","de":"x"}}\n\n`);
  const cut = bytes.indexOf(0xC3) + 1;
  await page.bytes(bytes.slice(0, cut));
  assert.equal(page.text("state"), "-");
  await page.bytes(bytes.slice(cut));
  assert.deepEqual([page.text("bus"), page.text("progress")], ["ä 125 kbit/s", "x"]);
});

test("end_of_a_connection_tells_its_reason_once", async () => {
  const page = await open();
  await page.connected("is2");
  const error = texts("the adapter is gone");
  await page.event("status", { ...CLOSED, error });
  assert.equal(page.text("message"), "the adapter is gone");
  page.element("port").value = "can0";
  await page.click("find");
  assert.equal(page.text("message"), "");
  await page.event("status", { ...CLOSED, error });
  assert.equal(page.text("message"), "", "the same reason again is not new");
});

test("tab_that_is_not_in_charge_says_so_offers_no_action_and_can_take_over", async () => {
  const page = await open();
  const { TAB } = page.import("api.js");
  await page.connected("is2");
  await page.event("owner", "another");
  assert.match(page.text("owner-text"), /Another tab of this page controls the sensor/);
  for (const id of ["zero", "connect", "find", "disconnect", "samples", "read"]) assert.ok(page.element(id).disabled, id);
  await page.click("take-over");
  assert.equal(page.requests.pop().path, "api/owner");
  await page.event("owner", TAB);
  assert.ok(page.element("owner").hidden);
  assert.equal(page.element("zero").disabled, false);
  await page.event("owner", "another");
  assert.match(page.text("owner-text"), /has taken over/);
  await page.change("language", "de");
  assert.match(page.text("owner-text"), /hat übernommen/);
  // Nobody is in charge: the first action decides.
  await page.event("owner", null);
  assert.ok(page.element("owner").hidden);
});

test("page_that_is_opened_again_has_the_port_of_the_connection", async () => {
  const page = await open({ prepare: (own) => own.events.push(new TextEncoder().encode(`event: status\ndata: ${JSON.stringify({ ...STATUS, port: "can0" })}\n\n`)) });
  assert.equal(page.element("port").value, "can0");
});

test("address_of_each_protocol_is_explained_where_it_is_typed", async () => {
  const page = await open();
  assert.ok(page.element("address-help").hidden);
  for (const [protocol, words] of [["fsc", /requests/], ["canopen", /1 to 127/], ["devicenet", /0 to 63/], ["j1939", /0 to 253/]]) {
    await page.change("protocol", protocol);
    assert.match(page.text("address-help"), words);
  }
  await page.change("language", "de");
  assert.match(page.text("address-help"), /Nummer des Sensors am Bus/);
});
