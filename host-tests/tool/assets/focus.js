// A button is disabled while its command runs, and loses the focus. It gets it back, so that the keyboard stays where it was.

import { element, on } from "./state.js";

/** The element that had the focus. @type {HTMLElement | null} */
let last = null;

function giveBack() {
  if (!last?.isConnected || document.activeElement !== document.body || element("question").open || last.matches(":disabled")) return;
  last.focus({ preventScroll: true });
}

/** Keeps the focus. */
export function start() {
  const dialog = element("question");
  document.addEventListener("focusin", ({ target }) => {
    if (target instanceof HTMLElement && !dialog.contains(target)) last = target;
  });
  // A click beside all controls takes the focus away.
  document.addEventListener("pointerdown", () => { last = null; });
  dialog.addEventListener("close", giveBack);
  on("status", giveBack);
}
