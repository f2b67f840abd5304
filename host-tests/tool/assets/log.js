// Each action with its command line.

import { element, fail, make, on } from "./state.js";
import { currentLanguage, inLanguage, onLanguage, t } from "./texts.js";

/** @typedef {{n: number, at: number, line: string, state: string, notes?: import("./texts.js").Texts[], texts?: import("./texts.js").Texts, asks?: import("./texts.js").Question[]}} Action */
/** The most actions. */
const MOST = 100;
/** The actions with their rows. @type {Map<number, {action: Action, row: HTMLElement}>} */
const actions = new Map();

/** @param {Action} action */
function item(action) {
  const entry = document.createElement("li");
  const row = make("div", undefined, "row");
  const head = document.createElement("div");
  const time = make("time", new Date(action.at).toLocaleTimeString(currentLanguage()));
  head.append(time, make("code", action.line), ` ${t(action.state)}`);
  const copy = /** @type {HTMLButtonElement} */ (make("button", t("copy")));
  copy.type = "button";
  copy.setAttribute("aria-label", t("copy-line", action.line));
  copy.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(action.line);
      copy.textContent = t("copied");
    } catch (error) {
      // Without the permission the line is selected, so that the user can copy it.
      const code = head.querySelector("code");
      if (code) getSelection()?.selectAllChildren(code);
      else fail(error);
    }
  });
  row.append(head, copy);
  entry.append(row);
  const text = action.texts ? inLanguage(action.texts) : "";
  const ends = action.asks?.map(({ texts }) => inLanguage(texts)) ?? text.split("\n").filter((line) => line !== "");
  const kind = action.state === "failed" ? "failed" : "note";
  for (const note of (action.notes ?? []).slice(-6)) entry.append(make("div", inLanguage(note), "note"));
  for (const line of ends) entry.append(make("div", line, kind));
  return entry;
}

/** Shows an action. The other rows stay in the document, so that a control in them keeps the focus. @param {Action} action */
function show(action) {
  const earlier = actions.get(action.n)?.row;
  const row = item(action);
  actions.set(action.n, { action, row });
  if (earlier) {
    const hadFocus = earlier.contains(document.activeElement);
    earlier.replaceWith(row);
    if (hadFocus) row.querySelector("button")?.focus({ preventScroll: true });
  } else {
    // The newest is the first.
    const older = [...actions.keys()].filter((n) => n < action.n);
    const next = actions.get(Math.max(...older))?.row ?? null;
    element("log-rows").insertBefore(row, next);
  }
  if (actions.size <= MOST) return;
  const oldest = Math.min(...actions.keys());
  actions.get(oldest)?.row.remove();
  actions.delete(oldest);
}

/** Starts the log. */
export function start() {
  const empty = element("log-empty");
  on("action", (/** @type {Action} */ action) => {
    show(action);
    empty.hidden = true;
  });
  on("restarted", () => {
    actions.clear();
    element("log-rows").replaceChildren();
    empty.hidden = false;
  });
  onLanguage(() => { for (const { action } of [...actions.values()]) show(action); });
}
