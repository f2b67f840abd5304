// The offset of the mounting by the reversal: the sensor is measured at rest, turned by the user, and measured again.

import { which } from "./actions.js";
import { post } from "./api.js";
import { answered, ask } from "./dialog.js";
import { element, isReady, on, press, sensor, state } from "./state.js";
import { decimal, inLanguage, onLanguage, t } from "./texts.js";

/** @typedef {{name: string, spread: number, mounting: number, surface: number}} Angle */

/** What is measured now: `first` or `turned`. @type {string | null} */
let measures = null;
/** What the sensor does meanwhile. @type {import("./texts.js").Texts | null} */
let note = null;
/** @type {Angle[] | null} */
let aligned = null;

/** A number of degrees. @param {number} value */
const degrees = (value) => decimal(value, 2);

function show() {
  const device = state.device;
  const button = element("align");
  button.hidden = device !== null && (device.foreign || !device.align);
  button.disabled = !isReady() || measures !== null;
  const found = (aligned ?? []).map(({ name, mounting, surface, spread }) => t("align-done", name, degrees(mounting), degrees(surface), degrees(spread)));
  const step = measures === null ? found.join(" ") : [t(`align-${measures}`), note ? inLanguage(note) : ""].join(" ").trim();
  const place = element("align-state");
  if (place.textContent !== step) place.textContent = step;
}

async function align() {
  const own = sensor();
  const checks = state.device?.saves === false ? [] : [t("also-save")];
  const answer = await ask({ title: t("align-title"), text: `${t("align-text")}\n${which()}`, yes: t("align-measure"), checks });
  if (!answer) return;
  aligned = null;
  const save = answer.checked[0] ?? false;
  /** @param {object[]} yes */
  const send = async (yes) => {
    [measures, note] = [yes.length === 0 ? "first" : "turned", null];
    show();
    try {
      return await post("api/align", { save, yes }, own);
    } finally {
      measures = null;
      show();
    }
  };
  const report = await answered(send, t("align-title"), true);
  aligned = report?.angles ?? null;
  show();
}

/** Starts the button. */
export function start() {
  press("align", align);
  on("note", ({ texts }) => {
    note = texts;
    if (measures !== null) show();
  });
  let connected = sensor();
  on("device", () => {
    // The result is that of the sensor which is shown.
    if (sensor() !== connected) aligned = null;
    connected = sensor();
    show();
  });
  on("status", show);
  onLanguage(show);
}
