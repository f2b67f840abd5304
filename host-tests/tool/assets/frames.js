// The newest frame of each identifier with its meaning, and single requests.

import { which } from "./actions.js";
import { post } from "./api.js";
import { ask } from "./dialog.js";
import { attempt, element, isReady, make, on, sensor, state } from "./state.js";
import { onLanguage, t } from "./texts.js";

/** @typedef {{id: string, data: string, remote: boolean, count: number, period: number | null, own: boolean,
 *   meaning: string | null}} Row */
/** @type {Map<string, {line: HTMLElement, cells: HTMLElement[]}>} */
const lines = new Map();
/** @type {Row[]} */
let newest = [];

function show() {
  const empty = element("frames-empty");
  empty.hidden = newest.length > 0;
  empty.textContent = t(state.status?.state === "listening" ? "frames-listening" : "frames-empty");
  element("frames-scroll").hidden = newest.length === 0;
  const body = element("frame-rows");
  const wanted = element("frames-filter").value.trim().toLowerCase();
  const shown = newest.filter(({ id, data, meaning }) => `${id} ${data} ${meaning ?? ""}`.toLowerCase().includes(wanted));
  const ids = new Set(shown.map(({ id }) => id));
  for (const [id, { line }] of lines) {
    if (!ids.has(id)) {
      line.remove();
      lines.delete(id);
    }
  }
  shown.forEach((row, place) => {
    let known = lines.get(row.id);
    if (!known) {
      const cells = [make("code"), make("code"), make("span"), make("span"), make("span")];
      const line = document.createElement("tr");
      line.append(...cells.map((cell, number) => {
        const box = make("td", undefined, number === 4 ? "meaning" : "number");
        box.append(cell);
        return box;
      }));
      known = { line, cells };
      lines.set(row.id, known);
    }
    if (body.children[place] !== known.line) body.insertBefore(known.line, body.children[place] ?? null);
    const texts = [
      row.own ? `${row.id} (${t("sent")})` : row.id, row.remote ? "RTR" : row.data,
      row.period === null ? "-" : `${(row.period / 1000).toFixed(1)} ms`, String(row.count), row.meaning ?? "",
    ];
    known.cells.forEach((cell, number) => { if (cell.textContent !== texts[number]) cell.textContent = texts[number]; });
  });
}

async function send() {
  const [request, own] = [element("request").value.trim(), sensor()];
  const answer = await ask({ title: `${t("raw")} ${request}`, text: `${t("send-text")}\n${which()}`, yes: t("send") });
  if (!answer) return;
  element("answer").textContent = "";
  const { answer: bytes } = await post("api/run", { raw: { request } }, own);
  element("answer").textContent = bytes;
}

/** Starts the table. */
export function start() {
  on("frames", (rows) => { newest = rows; show(); });
  on("status", () => {
    element("send").disabled = !isReady();
    if (newest.length === 0) show();
  });
  element("raw").addEventListener("submit", (/** @type {Event} */ event) => {
    event.preventDefault();
    attempt(send, element("send"));
  });
  element("frames-filter").addEventListener("input", show);
  onLanguage(show);
}
