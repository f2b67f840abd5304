// Which tab is in charge: the others only look, and can take over.

import { post, TAB } from "./api.js";
import { element, mayAct, on, press, state } from "./state.js";
import { onLanguage, t } from "./texts.js";

/** This tab was in charge. */
let wasOwner = false;

function show() {
  const isShown = state.gone === null && !mayAct();
  element("owner").hidden = !isShown;
  const text = isShown ? t(wasOwner ? "owner-lost" : "owner-other") : "";
  if (element("owner-text").textContent !== text) element("owner-text").textContent = text;
}

/** Starts it. */
export function start() {
  press("take-over", () => post("api/owner", {}));
  on("owner", (owner) => {
    wasOwner ||= owner === TAB;
    show();
  });
  on("status", show);
  onLanguage(show);
}
