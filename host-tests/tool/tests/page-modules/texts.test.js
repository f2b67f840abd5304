// The texts: both languages say the same, and everything that needs a name has one.

import assert from "node:assert/strict";
import test from "node:test";
import { answers, open } from "./page.js";

test("languages_have_the_same_texts_with_the_same_places", async () => {
  const page = await open();
  const { texts: { en, de } } = page.import("texts.js");
  const places = (text) => (text.match(/\{\w+\}/g) ?? []).sort().join();
  const keys = [...new Set([...Object.keys(en), ...Object.keys(de)])];
  assert.deepEqual(keys.filter((key) => !en[key] || !de[key] || places(en[key]) !== places(de[key])), []);
  const used = document.root.all().flatMap(({ dataset: { t, tLabel } }) => [t, tLabel]).filter(Boolean);
  assert.ok(used.length > 60);
  assert.deepEqual(used.filter((key) => !en[key]), []);
});

test("each_protocol_has_its_texts", async () => {
  const page = await open();
  const { texts: { en } } = page.import("texts.js");
  assert.ok(answers.protocols.length >= 4);
  for (const { name, command } of answers.protocols) {
    const keys = ["protocol", "address", "address-help", ...(command ? ["new-address", "new-address-text"] : [])];
    assert.deepEqual(keys.filter((key) => !en[`${key}-${name}`]), [], name);
  }
  // The choice has the language of the page.
  for (const [language, shown] of [["de", "J1939-Adresse"], ["en", "J1939 address"]]) {
    await page.change("language", language);
    assert.equal(page.element("protocol").options.find(({ value }) => value === "j1939").textContent, shown);
  }
});

test("page_has_the_language_of_the_browser_until_another_one_is_chosen", async () => {
  for (const [language, title] of [["de-CH", "Winkel"], ["fr", "Angles"]]) {
    const page = await open({ language });
    assert.equal(page.text("angles-title"), title);
  }
  const page = await open();
  await page.change("language", "de");
  assert.deepEqual([page.text("angles-title"), document.documentElement.lang, localStorage.getItem("plumbline-language")], ["Winkel", "de", "de"]);
});

test("theme_is_kept", async () => {
  const page = await open();
  assert.equal(document.documentElement.dataset.theme, "auto");
  await page.change("theme", "dark");
  assert.deepEqual([document.documentElement.dataset.theme, localStorage.getItem("plumbline-theme")], ["dark", "dark"]);
});

/** What a screen reader says of an element. */
function name(element) {
  const label = element.getAttribute("aria-label");
  if (label) return label;
  const by = element.getAttribute("aria-labelledby");
  if (by) return document.getElementById(by)?.textContent ?? "";
  for (let outer = element.parent; outer; outer = outer.parent) if (outer.tag === "label") return outer.textContent;
  return element.textContent;
}

test("form_of_each_product_has_names_in_both_languages", async () => {
  const page = await open();
  for (const { sheet, name: product } of answers.products) {
    const own = Object.fromEntries(answers.parameters[sheet].entries.map(({ name, factory }) => [name, factory]));
    page.reply("api/file", { product, sheet, text: "", values: own });
    page.element("template").value = sheet;
    await page.click("new-file");
    // The file before it is not saved.
    if (page.isAsking) await page.yes();
    assert.match(page.text("file-state"), new RegExp(`\\(${product}\\)`));
    for (const language of ["de", "en"]) {
      await page.change("language", language);
      const fields = page.element("rows").all().filter(({ tag }) => ["input", "select", "button"].includes(tag));
      assert.ok(fields.some(({ disabled }) => !disabled), product);
      assert.deepEqual(fields.filter((field) => !name(field).trim() || name(field).includes("{")), [], `${product} ${language}`);
      const controls = document.root.all().filter(({ tag }) => ["input", "select", "button", "progress", "svg"].includes(tag));
      const unnamed = controls.filter((control) => !page.element("question").contains(control) && !name(control).trim());
      assert.deepEqual(unnamed.map(({ id }) => id), [], `${product} ${language}`);
    }
  }
});
