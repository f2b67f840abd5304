// Each action with its command line.

import { element, fail, make, on } from "./state.js";
import { currentLanguage, onLanguage, t } from "./texts.js";

/** @typedef {{n: number, at: number, line: string, state: string, notes?: string[], result?: any, error?: {message: string}}} Action */
/** The most actions. */
const MOST = 100;
/** @type {Map<number, Action>} */
const actions = new Map();

/** @param {Action} action */
function item(action) {
  const entry = document.createElement("li");
  const row = make("div", undefined, "row");
  const text = document.createElement("div");
  const time = make("time", new Date(action.at).toLocaleTimeString(currentLanguage()));
  text.append(time, make("code", action.line), ` ${t(action.state)}`);
  const copy = /** @type {HTMLButtonElement} */ (make("button", t("copy")));
  copy.type = "button";
  copy.setAttribute("aria-label", t("copy-line", action.line));
  copy.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(action.line);
      copy.textContent = t("copied");
    } catch (error) {
      // Without the permission the line is selected, so that the user can copy it.
      const code = text.querySelector("code");
      if (code) getSelection()?.selectAllChildren(code);
      else fail(error);
    }
  });
  row.append(text, copy);
  entry.append(row);
  const lines = [...(action.notes ?? []).slice(-6), ...(action.error ? [action.error.message] : []), ...done(action.result)];
  for (const line of lines) entry.append(make("div", line, line === action.error?.message ? "failed" : "note"));
  return entry;
}

/** @param {any} result @returns {string[]} */
function done(result) {
  return typeof result?.done === "string" ? [result.done] : [];
}

function show() {
  element("log-empty").hidden = actions.size > 0;
  const newest = [...actions.values()].sort((one, other) => other.n - one.n);
  element("log-rows").replaceChildren(...newest.map(item));
}

/** Starts the log. */
export function start() {
  on("action", (/** @type {Action} */ action) => {
    actions.set(action.n, action);
    if (actions.size > MOST) actions.delete(Math.min(...actions.keys()));
    show();
  });
  on("restarted", () => { actions.clear(); show(); });
  onLanguage(show);
}
