// The form of the parameters: sensor, file, factory.

import { which } from "./actions.js";
import { get, post } from "./api.js";
import { ask } from "./dialog.js";
import { change, current, differences, refusal } from "./document.js";
import { attempt, choice, element, fail, isReady, make, on, sensor, shown, state } from "./state.js";
import { decimal, inLanguage, named, numbers, onLanguage, setNames, t } from "./texts.js";

/**
 * @typedef {object} Entry
 * @property {string} name
 * @property {string} title
 * @property {string} kind
 * @property {string} unit
 * @property {import("./texts.js").Texts | null} ranges
 * @property {import("./state.js").Value | null} factory
 * @property {boolean} plusNode
 * @property {boolean} writable
 * @property {boolean} setting
 * @property {import("./state.js").Choice[]} choices
 * @typedef {{line: HTMLElement, entry: Entry, sensor: HTMLElement, set: HTMLButtonElement | null,
 *   file: (HTMLInputElement | HTMLSelectElement) | null, wrong: HTMLElement, mark: HTMLElement}} Row
 */

/** @type {{product: string, german: Record<string, string>, entries: Entry[]} | null} */
let sheet = null;
/** The pause between two values of the angles in ms. */
const PAUSE = 400;
/** @type {Row[]} */
let rows = [];
/** The key of the sheet that is being asked for. */
let asked = "";

/** The file decides without a sensor. */
function key() {
  return state.device?.sheet ?? current()?.sheet ?? "";
}

async function load() {
  const wanted = key();
  if (wanted === asked) return show();
  asked = wanted;
  const next = wanted ? await get(`api/parameters/${encodeURIComponent(wanted)}`) : null;
  if (asked !== wanted) return undefined;
  sheet = next;
  setNames(sheet?.german ?? {});
  return build();
}

/** The name in the manual; that of a PDO has its number before it. @param {Entry} entry */
function words({ name, title }) {
  const [, kind, number] = name.match(/^([rt]pdo)(\d+)-/) ?? [];
  return kind ? `${kind.toUpperCase()} ${number}: ${title}` : title;
}

/** The permitted values. @param {Entry} entry */
function range({ ranges }) {
  return ranges ? numbers(inLanguage(ranges)) : "";
}

/** @param {Entry} entry @returns {Row} */
function row(entry) {
  const line = document.createElement("tr");
  const name = /** @type {HTMLTableCellElement} */ (make("th", words(entry)));
  name.scope = "row";
  name.title = entry.name;
  const sensor = make("td", "-", "value");
  const action = document.createElement("td");
  const [file, wrong] = [document.createElement("td"), make("span", "", "wrong")];
  wrong.id = `wrong-${entry.name}`;
  /** @type {HTMLButtonElement | null} */
  let set = null;
  if (entry.writable) {
    set = /** @type {HTMLButtonElement} */ (make("button", t("set-short")));
    set.type = "button";
    set.setAttribute("aria-label", t("set", entry.name));
    const button = set;
    button.addEventListener("click", () => attempt(() => write(entry), button));
    action.append(set);
  }
  const field = entry.setting ? input(entry, wrong) : null;
  const mark = make("span", "", "mark");
  if (field) file.append(field, mark, wrong);
  else file.textContent = entry.writable ? "" : t("read-only");
  const factory = entry.factory && entry.kind === "parameter" ? shown(entry.factory) : "";
  line.append(name, sensor, action, file,
    make("td", entry.plusNode && factory ? t("plus-node", factory) : factory, "value"),
    make("td", range(entry) || entry.unit, "range"));
  return { line, entry, sensor, set, file: field, wrong, mark };
}

/** The field of the file. @param {Entry} entry @param {HTMLElement} wrong */
function input(entry, wrong) {
  const field = document.createElement(entry.choices.length > 0 ? "select" : "input");
  if (field instanceof HTMLSelectElement) field.append(...entry.choices.map(({ name }) => new Option(named(name), name)));
  else {
    field.autocomplete = "off";
    field.spellcheck = false;
    field.size = 14;
  }
  field.id = `file-${entry.name}`;
  field.setAttribute("aria-label", t("file-value", entry.name));
  field.setAttribute("aria-describedby", wrong.id);
  field.addEventListener("change", () => change(entry.name, field.value));
  return field;
}

/** The value in the sensor. Angles move: theirs are the newest samples. @param {Entry} entry */
function read(entry) {
  const place = state.device?.angles.findIndex(({ name }) => name === entry.name) ?? -1;
  if (place < 0) return state.values === null ? "-" : shown(state.values[entry.name]);
  const angle = state.angles?.[place] ?? NaN;
  return Number.isFinite(angle) ? `${decimal(angle, 2)} ${state.device?.angles[place].unit}` : "-";
}

function showAngles() {
  for (const { entry, sensor } of rows) {
    const text = read(entry);
    if (sensor.textContent !== text) sensor.textContent = text;
  }
}

/** Sets one value in the sensor. @param {Entry} entry */
async function write(entry) {
  const [present, own] = [state.values?.[entry.name], sensor()];
  await ask({
    title: t("set-title", entry.name), text: which(), yes: t("write"),
    field: { label: t("value"), value: entry.choices.length > 0 ? choice(entry.choices, present) : present ? shown(present) : "", hint: range(entry),
      choices: entry.choices.map(({ name }) => name) },
    checks: state.device?.saves === false ? [] : [t("also-save")],
  }, ({ value, checked }) => post("api/run", { set: { assignments: [`${entry.name}=${value}`], save: checked[0] ?? false } }, own));
}

function build() {
  rows = (sheet?.entries ?? []).map(row);
  rows.sort((one, other) => Number(other.entry.setting) - Number(one.entry.setting) || Number(other.entry.writable) - Number(one.entry.writable));
  element("rows").replaceChildren(...rows.map(({ line }) => line));
  show();
}

function show() {
  const file = current();
  const differing = new Set(differences());
  const fits = file !== null && file.product === sheet?.product;
  const [search, only] = [element("search").value.trim().toLowerCase(), element("only-differences").checked];
  for (const { line, entry, sensor, set, file: field, wrong, mark } of rows) {
    const text = read(entry);
    if (sensor.textContent !== text) sensor.textContent = text;
    if (set) set.disabled = !isReady();
    if (field) {
      const value = fits ? file.values[entry.name] : undefined;
      field.disabled = !fits;
      const input = fits ? refusal(entry.name) : undefined;
      const own = value === undefined ? "" : field instanceof HTMLSelectElement ? choice(entry.choices, value) : shown(value);
      const kept = input?.value ?? own;
      if (field.value !== kept) field.value = kept;
      if (input) field.setAttribute("aria-invalid", "true"); else field.removeAttribute("aria-invalid");
      const why = input?.why ?? "";
      if (wrong.textContent !== why) wrong.textContent = why;
    }
    line.classList.toggle("differs", differing.has(entry.name));
    mark.textContent = differing.has(entry.name) ? "≠" : "";
    const isWanted = `${entry.name} ${entry.title}`.toLowerCase().includes(search) && (!only || differing.has(entry.name));
    line.hidden = !isWanted;
  }
  const isShown = rows.some(({ line }) => !line.hidden);
  const empty = element("parameters-empty");
  empty.hidden = isShown;
  element("parameters-scroll").hidden = !isShown;
  const words = t(sheet === null ? "parameters-empty" : "parameters-hidden");
  if (empty.textContent !== words) empty.textContent = words;
}

/** Starts the form. */
export function start() {
  // A message stays until the next action of the user.
  on("device", () => load().catch(fail));
  on("file", () => load().catch(fail));
  on("values", show);
  setInterval(showAngles, PAUSE);
  let ready = false;
  on("status", () => {
    if (ready !== isReady()) show();
    ready = isReady();
  });
  element("search").addEventListener("input", show);
  element("only-differences").addEventListener("change", show);
  onLanguage(build);
}
