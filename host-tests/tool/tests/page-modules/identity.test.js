// The identity of a unit: it is shown, and written into the store file only after a yes.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, open, Refusal } from "./page.js";

const EDS = "[File]\n[Device]\nProdCode = 7;\n";
const { product, identity, sheet } = answers.identity;

/** The page of a server with this store file. */
const started = (store) => open({ prepare: (page) => page.reply("api/ports", { ...answers.ports, store }) });

/** The user chooses a file. */
async function choose(page, name, text) {
  page.element("identity-file").files = [{ name, size: text.length, arrayBuffer: async () => new TextEncoder().encode(text).buffer }];
  await page.change("identity-file");
  await page.pass(0);
}

const rows = (page) => page.element("identity-rows").children.map((row) => row.children.map((cell) => cell.textContent));

test("identity_of_the_sensor_is_shown_and_saved_as_a_sheet", async () => {
  const page = await started(null);
  const buttons = ["identity-read", "identity-download", "identity-write"];
  assert.deepEqual(buttons.filter((id) => !page.element(id).disabled), []);
  await page.connected("tiltix080");
  page.requests.length = 0;
  page.reply("api/run", answers.identity);
  await page.click("identity-read");
  assert.deepEqual(page.requests, [{ path: "api/run", body: "identity", sensor: String(answers.devices.tiltix080.device.connection) }]);
  assert.deepEqual(rows(page), Object.entries(identity).map(([name, value]) => [name, String(value)]));
  assert.match(page.text("identity-state"), /identity of a tiltix080.*serve --store/);
  assert.deepEqual(buttons.filter((id) => page.element(id).disabled), ["identity-write"]);
  await page.click("identity-download");
  assert.deepEqual(await page.saved(), [{ name: "tiltix080-identity.toml", text: sheet }]);
});

test("identity_of_a_file_is_written_into_the_store_file_only_after_a_yes", async () => {
  const page = await started("unit.bin");
  page.reply("api/identity", { product, identity: { ...identity, serial: null }, sheet });
  await page.change("product", "tiltix080");
  page.requests.length = 0;
  await choose(page, "old.eds", EDS);
  assert.deepEqual(page.requests.pop(), { path: "api/identity", body: { text: EDS, name: "old.eds", product: "tiltix080" }, sensor: null });
  assert.deepEqual(rows(page).find(([name]) => name === "serial"), ["serial", "as the product has it"]);
  const asked = await page.question("identity-write");
  assert.match(asked.text, /tiltix080 with the store file unit\.bin[^]*product-code: 80\n/);
  await page.no();
  assert.deepEqual(page.requests, []);
  await page.question("identity-write");
  await page.yes();
  assert.deepEqual(page.requests, [{ path: "api/identity/store", body: { text: sheet, name: "old.toml" }, sensor: null }]);
  assert.match(page.text("identity-state"), /is in unit\.bin/);
});

test("file_without_identity_is_told_and_the_previous_one_stays", async () => {
  const page = await started("unit.bin");
  page.reply("api/identity", answers.identity);
  await choose(page, "unit.toml", sheet);
  assert.equal(page.requests.pop().body.product, null, "a sheet names its product");
  page.reply("api/identity", new Refusal("bad-file", "bad.toml: it has no identity; nothing was written"));
  await choose(page, "bad.toml", "");
  assert.match(page.text("message"), /bad\.toml: it has no identity/);
  assert.equal(rows(page).length, Object.keys(identity).length);
  await page.end();
  assert.ok(page.element("identity-write").disabled);
});
