// The file: a text that the browser keeps. The server reads and changes it; the sensor is not needed.

import { which } from "./actions.js";
import { post } from "./api.js";
import { download } from "./chart.js";
import { ask } from "./dialog.js";
import { sentence } from "./failure.js";
import { textOf } from "./reading.js";
import { attempt, element, emit, isReady, on, press, sensor, shown, state } from "./state.js";
import { onLanguage, t } from "./texts.js";

/**
 * @typedef {object} File
 * @property {string} product
 * @property {string} sheet the name of the product, or the key of a data sheet
 * @property {string} text
 * @property {Record<string, import("./state.js").Value>} values
 * @property {string | null} [label] the name of the sensor
 * @property {string} [name]
 */

/** @type {File | null} */
let file = null;
let isDirty = false;
/** The inputs that were refused, with the reason: they are not in the file. @type {Map<string, {value: string, why: string}>} */
const refused = new Map();

/** The input of a value that was refused. @param {string} name */
export function refusal(name) {
  return refused.get(name);
}

/** @returns {File | null} */
export function current() {
  return file;
}

/** The names whose values differ from the sensor. @returns {string[]} */
export function differences() {
  if (!file || !state.values || state.device?.product !== file.product) return [];
  const { values } = file;
  return Object.keys(values).filter((name) => {
    const own = state.values?.[name];
    return own !== undefined && own !== null && shown(own) !== shown(values[name]);
  });
}

/** The name of the sensor in the file, if the sensor has another one. @returns {string | null} */
function label() {
  const device = state.device;
  if (!file?.label || !device || device.product !== file.product || device.serial === null) return null;
  return file.label === device.label ? null : file.label;
}

/** Whether the sensor stores its settings on command: a restore that was interrupted can be finished. */
function stores() {
  return state.device?.saves ?? true;
}

/** Another file. @param {any} next @param {string} name @param {boolean} changed */
function take(next, name, changed) {
  refused.clear();
  put(next, name, changed);
}

/** @param {any} next @param {string} name @param {boolean} changed */
function put(next, name, changed) {
  file = { ...next, name };
  isDirty = changed;
  emit("file", file);
  show();
}

/** Whether the file can be replaced. */
async function mayReplace() {
  if (!isDirty && refused.size === 0) return true;
  return (await ask({ title: t("lose-title"), text: t("lose-text"), yes: t("replace") })) !== null;
}

async function backup() {
  const own = sensor();
  if (!(await mayReplace())) return;
  const next = await post("api/backup", {}, own);
  take(next, named(next.product, next.serial), true);
}

/** The name of a new file, valid on every system. @param {string} product @param {number | null} [serial] */
export function named(product, serial = null) {
  const name = serial === null ? product : `${product}-${serial}`;
  return `${name.replace(/[^\p{L}\p{N}._-]+/gu, "-")}.toml`;
}

async function open() {
  const field = element("file");
  const [chosen] = field.files;
  if (!chosen) return;
  try {
    if (await mayReplace()) take(await post("api/file", { text: await textOf(chosen, { isDataSheet: false }), sheet: state.device?.sheet ?? (element("product").value || null) }), chosen.name, false);
  } finally {
    // The same file can be opened again.
    field.value = "";
  }
}

async function create() {
  const product = element("template").value;
  if (!(await mayReplace())) return;
  const next = await post("api/file", { product });
  take(next, named(next.product), true);
}

function save() {
  if (!file) return;
  download(file.name ?? "sensor.toml", "application/toml", file.text);
  isDirty = false;
  show();
}

/** Changes a value of the file. An input that is refused is kept. @param {string} name @param {string} value */
export async function change(name, value) {
  await tryChange(name, value);
  if (refused.has(name)) return;
  // An input that did not fit the value before can fit this one.
  for (const [other, input] of [...refused]) await tryChange(other, input.value);
}

/** @param {string} name @param {string} value */
async function tryChange(name, value) {
  try {
    await send(name, value);
  } catch (error) {
    refused.set(name, { value, why: sentence(error) });
    emit("file", file);
    show();
  }
}

/** @param {string} name @param {string} value */
async function send(name, value) {
  if (!file) return;
  const { device } = state;
  const next = await post("api/file/set", { text: file.text, name, value, file: file.name, sheet: device?.product === file.product ? device.sheet : file.sheet });
  refused.delete(name);
  put(next, file.name ?? "sensor.toml", true);
}

async function restore() {
  if (!file) return;
  const [names, own, given] = [differences(), sensor(), label()];
  if (names.length === 0 && given === null) {
    const yes = await ask({ title: t("store"), text: `${t("store-text")}\n${which()}`, yes: t("store") });
    if (yes) await post("api/run", "save", own);
    return;
  }
  const checks = names.map((name) => ({ text: `${name}: ${shown(state.values?.[name])} → ${shown(file?.values[name])}`, checked: true }));
  // A sensor that has a name keeps it, unless the user wants the one of the file.
  const present = state.device?.label;
  if (given !== null) checks.push({ text: t("restore-label", present ?? "-", given), checked: !present });
  const answer = await ask({
    title: t("restore-title", names.length), text: `${t("restore-text")}\n${which()}`, checks, yes: t("write"),
  });
  const chosen = names.filter((_, place) => answer?.checked[place]);
  const isNamed = given !== null && (answer?.checked[names.length] ?? false);
  // Without names all values are written, also those that the question has not shown.
  if (chosen.length > 0) await post("api/restore", { text: file.text, name: file.name, only: chosen, label: isNamed }, own);
  else if (isNamed) await post("api/run", { label: { name: given } }, own);
}

function show() {
  const place = element("file-state");
  const product = state.device?.product;
  let text = t("file-none");
  if (file) {
    const name = file.name ?? "";
    if (!product) text = t("file-offline", name, file.product);
    else if (product !== file.product) text = t("file-other", name, file.product, product);
    else text = t("file-is", name, file.product, differences().length);
    if (isDirty) text += ` ${t("file-dirty")}`;
    if (refused.size > 0) text += ` ${t("file-refused", [...refused.keys()].join(", "))}`;
  }
  if (place.textContent !== text) place.textContent = text;
  element("backup").disabled = !isReady();
  element("read").disabled = !isReady();
  const canWrite = product !== undefined && product === file?.product && (stores() || differences().length > 0 || label() !== null);
  element("restore").disabled = !isReady() || !canWrite || refused.size > 0;
  element("download").disabled = file === null || refused.size > 0;
}

/** Starts the buttons of the file. */
export function start() {
  press("read", () => post("api/run", { get: {} }, sensor()));
  press("backup", backup);
  press("restore", restore);
  element("file").addEventListener("change", () => attempt(open));
  element("download").addEventListener("click", save);
  press("new-file", create);
  addEventListener("beforeunload", (event) => { if (isDirty || refused.size > 0) event.preventDefault(); });
  for (const kind of ["status", "device", "values"]) on(kind, show);
  onLanguage(show);
}
