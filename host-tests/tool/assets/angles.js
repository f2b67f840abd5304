// The large angles, and the status in words.

import { element, goneText, make, on, state } from "./state.js";
import { decimal, inLanguage, onLanguage, t } from "./texts.js";

/** The pause between two values in ms: a person, also with a screen reader, must be able to follow. */
const PAUSE = 400;
/** The age in ms at which angles are old, if more should have come. */
const OLD = 1000;
/** The time of the newest angles in ms. */
let newest = 0;
/** @type {HTMLOutputElement[]} */
let outputs = [];
/** @type {{name: string, texts?: import("./texts.js").Texts, error: boolean}[] | null} */
let condition = null;

function build() {
  const place = element("angle-values");
  outputs = [];
  place.replaceChildren(...(state.device?.angles ?? []).map((angle, number) => {
    const block = make("div", undefined, "angle");
    const label = make("span", angle.name);
    label.id = `angle-name-${number}`;
    const line = document.createElement("div");
    const output = document.createElement("output");
    output.id = `angle-${number}`;
    output.setAttribute("aria-labelledby", label.id);
    output.setAttribute("aria-live", "off");
    output.textContent = "-";
    outputs.push(output);
    line.append(output, " ", make("span", angle.unit === "deg" ? "°" : angle.unit, "unit"));
    block.append(label, line);
    return block;
  }));
  show();
}

/** @param {number} value */
function number(value) {
  return Number.isFinite(value) ? decimal(value, 2) : "-";
}

/** Old angles are not shown: the sensor does not answer, sampling is off, or the server is gone. */
function forget() {
  const { samples = 0, silent = true, state: now = "closed" } = state.status ?? {};
  if (state.gone !== null || now !== "active" || silent || samples === 0 || performance.now() - newest > OLD + 1500 / samples) state.angles = null;
}

function show() {
  forget();
  const isActive = state.gone === null && state.status?.state === "active";
  outputs.forEach((output, place) => {
    const text = isActive && state.angles ? number(state.angles[place]) : "-";
    if (output.textContent !== text) output.textContent = text;
  });
  const empty = element("angles-empty");
  const silent = state.status?.silent ?? false;
  const stopped = state.status?.samples === 0;
  const none = state.device?.angles.length === 0;
  empty.hidden = isActive && !silent && !stopped && !none;
  const shown = silent ? "angles-silent" : none ? "angles-none" : "angles-stopped";
  empty.textContent = t(state.gone !== null ? goneText() : isActive ? shown : "angles-empty");
}

function showCondition() {
  const place = element("condition");
  const { samples = 0, silent = true } = state.status ?? {};
  const isKnown = state.gone === null && !silent && samples > 0;
  const bits = condition ?? [];
  const isBad = isKnown && bits.some(({ error }) => error);
  const words = bits.map(({ name, texts }) => (texts ? inLanguage(texts) : word(name)));
  if (!isBad) words.unshift(t("ok"));
  const text = state.device === null ? "" : t("status", isKnown ? words.join(", ") : t("unknown"));
  if (place.textContent !== text) place.textContent = text;
  place.classList.toggle("bad", isBad);
}

/** A bit of the status in words, or its name in the manual. @param {string} name */
function word(name) {
  const key = `status-${name}`;
  const text = t(key);
  return text === key ? name : text;
}

/** Starts the angles. */
export function start() {
  let shape = "";
  on("device", (device) => {
    const next = JSON.stringify(device?.angles ?? []);
    if (next !== shape) build();
    shape = next;
    if (!device) state.angles = null;
    showCondition();
  });
  on("samples", ({ rows }) => {
    const last = rows[rows.length - 1];
    if (!last || last.length < 2) return;
    state.angles = last.slice(1);
    newest = performance.now();
  });
  on("status", () => { show(); showCondition(); });
  on("gone", () => { newest = -Infinity; });
  on("condition", (words) => { condition = words; showCondition(); });
  onLanguage(() => { show(); showCondition(); });
  setInterval(show, PAUSE);
}
