// The frames that the program sends beside its requests: a list with a start and a stop for each line, and the replay of a log.

import { post } from "./api.js";
import { LONGEST_LOG, textOf } from "./reading.js";
import { attempt, element, make, mayAct, on, press, state } from "./state.js";
import { onLanguage, t } from "./texts.js";

/** @typedef {{number: number, frame: string, every: number | null, running: boolean, sent: number, leftOut: number}} Line */
/** @typedef {{name: string, frames: number, sent: number, running: boolean}} Log */

/** @type {Line[]} */
let list = [];
/** @type {Log | null} */
let log = null;
/** The rows of the table by the number of their line. @type {Map<number, {row: HTMLElement, cells: HTMLElement[], toggle: HTMLButtonElement, remove: HTMLButtonElement}>} */
const rows = new Map();

const transmit = (/** @type {unknown} */ body) => post("api/transmit", body);

/** Whether frames can be sent. */
const isOpen = () => mayAct() && !state.status?.busy && ["active", "open"].includes(state.status?.state ?? "closed");

/** @param {number} number @param {() => unknown} body */
function button(number, body) {
  const made = /** @type {HTMLButtonElement} */ (make("button"));
  made.type = "button";
  made.dataset.line = String(number);
  made.addEventListener("click", () => attempt(() => transmit(body()), made));
  return made;
}

/** @param {number} number */
function add(number) {
  const row = document.createElement("tr");
  const cells = [make("code"), make("span"), make("span"), make("span")];
  const isRunning = () => list.find((line) => line.number === number)?.running ?? false;
  const toggle = button(number, () => ({ [isRunning() ? "stop" : "start"]: number }));
  const remove = button(number, () => ({ remove: number }));
  const place = make("td", undefined, "buttons");
  place.append(toggle, remove);
  row.append(place, ...cells.map((cell) => {
    const box = make("td", undefined, "number");
    box.append(cell);
    return box;
  }));
  element("transmit-rows").append(row);
  return { row, cells, toggle, remove };
}

/** @param {Line} line */
function showLine({ number, frame, every, running, sent, leftOut }) {
  const shown = rows.get(number) ?? add(number);
  rows.set(number, shown);
  const texts = [frame, every === null ? t("once") : `${every} ms`, String(sent), String(leftOut)];
  shown.cells.forEach((cell, place) => { if (cell.textContent !== texts[place]) cell.textContent = texts[place]; });
  const [word, removes] = [t(running ? "stop" : every === null ? "transmit-send" : "transmit-start"), t("remove")];
  for (const [own, text] of /** @type {[HTMLButtonElement, string][]} */ ([[shown.toggle, word], [shown.remove, removes]])) {
    if (own.textContent !== text) own.textContent = text;
    own.setAttribute("aria-label", `${text} ${frame}`);
  }
  shown.toggle.disabled = running ? !mayAct() : !isOpen();
  shown.remove.disabled = !mayAct();
}

function show() {
  for (const [number, { row }] of rows) {
    if (list.some((line) => line.number === number)) continue;
    row.remove();
    rows.delete(number);
  }
  list.forEach(showLine);
  element("transmit-scroll").hidden = list.length === 0;
  for (const id of ["transmit-add", "transmit-file"]) element(id).disabled = !mayAct();
  element("replay-start").disabled = !isOpen();
  element("replay-stop").disabled = !mayAct() || !log?.running;
  const told = log ? t(log.running ? "replay-runs" : "replay-ended", log.name, log.sent, log.frames) : "";
  if (element("replay-state").textContent !== told) element("replay-state").textContent = told;
}

/** Adds the line of the form. */
async function addLine() {
  const every = element("transmit-every").value.trim();
  await transmit({ add: { frame: element("transmit-frame").value, every: every === "" ? null : Number(every) } });
  element("transmit-frame").value = "";
  element("transmit-frame").focus();
}

/** Adds the lines of a file. */
async function openList() {
  const field = element("transmit-file");
  const [chosen] = field.files ?? [];
  if (!chosen) return;
  try {
    await transmit({ open: { name: chosen.name, text: await textOf(chosen, { isDataSheet: false }) } });
  } finally {
    // The same file can be chosen again.
    field.value = "";
  }
}

async function replay() {
  const [chosen] = element("replay-file").files ?? [];
  if (!chosen) return;
  const text = await textOf(chosen, { isDataSheet: false, longest: LONGEST_LOG });
  const speed = Number(element("replay-speed").value.trim().replace(",", "."));
  const wanted = element("replay-interface").value.trim();
  await transmit({ replay: { name: chosen.name, text, speed, repeats: element("replay-repeats").checked, interface: wanted || null } });
}

/** Starts the section. */
export function start() {
  on("transmission", ({ lines, log: next }) => { [list, log] = [lines, next]; show(); });
  on("status", show);
  for (const [form, run, id] of /** @type {[string, () => Promise<void>, string][]} */ ([["transmit-form", addLine, "transmit-add"], ["replay-form", replay, "replay-start"]])) {
    element(form).addEventListener("submit", (/** @type {Event} */ event) => {
      event.preventDefault();
      attempt(run, element(id));
    });
  }
  element("transmit-file").addEventListener("change", () => attempt(openList));
  press("replay-stop", () => transmit("stop-replay"));
  onLanguage(show);
}
