// The virtual sensor of a demonstration: sliders that move it, and buttons that break it. A real bus has none.

import { post } from "./api.js";
import { attempt, element, mayAct, on, press, state } from "./state.js";
import { decimal, onLanguage, t } from "./texts.js";

/** @typedef {{x: number, y: number, temperature: number, supply: number, fault: string | null, memory: boolean, on: boolean}} StandIn */

/** @type {StandIn | null} */
let standIn = null;
/** The sliders with their digits. @type {Record<string, number>} */
const SLIDERS = { x: 1, y: 1, temperature: 0, supply: 1 };
/** The faults of the accelerometer by button. @type {Record<string, string>} */
const FAULTS = { "fault-x": "axis-x", "fault-y": "axis-y", "fault-clipping": "clipping", "fault-stale": "frozen" };
/** What the sliders wait to send, each kind once. @type {Map<string, object>} */
const waiting = new Map();
let isSending = false;

/** @param {object} request */
const send = (request) => post("api/stand-in", request);

/** @param {string} name */
const slider = (name) => element(`stand-in-${name}`);

/** Whether the sensor measures one angle of a full turn. */
const isOneAxis = () => state.device?.angles.length === 1;

/** Sends the newest position of each slider, one after the other. */
async function drain() {
  if (isSending) return;
  isSending = true;
  try {
    for (let [next] = waiting; next; [next] = waiting) {
      waiting.delete(next[0]);
      await send(next[1]);
    }
  } finally {
    isSending = false;
    waiting.clear();
    show();
  }
}

/** @param {string} name */
function move(name) {
  const value = Number(slider(name).value);
  const request = {
    x: () => ({ do: "tilt", x: value, y: Number(slider("y").value) }),
    y: () => ({ do: "tilt", x: Number(slider("x").value), y: value }),
    temperature: () => ({ do: "temperature", celsius: value }),
    supply: () => ({ do: "supply", volts: value }),
  }[name]?.();
  if (!request || !standIn) return;
  // The answer comes before the event with the new position.
  standIn = { ...standIn, [name]: value };
  waiting.set(name === "y" ? "x" : name, request);
  showValues();
  attempt(drain);
}

function showValues() {
  for (const [name, digits] of Object.entries(SLIDERS)) {
    const unit = { temperature: "°C", supply: "V" }[name] ?? "°";
    element(`stand-in-${name}-value`).textContent = `${decimal(Number(slider(name).value), digits)} ${unit}`;
  }
}

/** @param {string} id @param {boolean} isOn */
function pressed(id, isOn) {
  element(id).setAttribute("aria-pressed", String(isOn));
}

function show() {
  element("stand-in").hidden = standIn === null;
  if (standIn === null) return;
  const [limit, oneAxis] = [isOneAxis() ? 180 : 45, isOneAxis()];
  [slider("x").min, slider("x").max] = [String(-limit), String(limit)];
  element("stand-in-y-label").hidden = oneAxis;
  element("fault-y").hidden = oneAxis;
  // A slider that the user moves keeps its position.
  if (waiting.size === 0 && !isSending) {
    const { x, y, temperature, supply } = standIn;
    const shown = { x: oneAxis && x > 180 ? x - 360 : x, y: oneAxis ? 0 : y, temperature, supply };
    for (const [name, value] of Object.entries(shown)) slider(name).value = String(value);
  }
  for (const name of Object.keys(SLIDERS)) slider(name).disabled = !mayAct();
  for (const button of element("stand-in-faults").querySelectorAll("button")) button.disabled = !mayAct();
  for (const [id, fault] of Object.entries(FAULTS)) pressed(id, standIn.fault === fault);
  pressed("fault-memory", standIn.memory);
  pressed("fault-power", !standIn.on);
  showValues();
}

/** Starts the section. */
export function start() {
  for (const name of Object.keys(SLIDERS)) slider(name).addEventListener("input", () => move(name));
  for (const [id, fault] of Object.entries(FAULTS)) press(id, () => send({ do: "accelerometer", fault: standIn?.fault === fault ? null : fault }));
  press("fault-memory", () => send({ do: "memory", fault: standIn?.memory ? null : "programming" }));
  press("fault-power", () => send({ do: "power", on: !standIn?.on }));
  press("fault-restart", () => send({ do: "restart" }));
  press("fault-bus-off", () => send({ do: "bus-off" }));
  press("fault-lose", () => send({ do: "lose", count: 10, from: "sensors" }));
  press("fault-delay", () => send({ do: "delay", count: 10, from: "sensors", seconds: 0.2 }));
  press("fault-corrupt", () => send({ do: "corrupt", count: 10 }));
  on("stand-in", (/** @type {StandIn | null} */ next) => { standIn = next; show(); });
  for (const kind of ["device", "gone", "restarted", "owner"]) on(kind, show);
  onLanguage(show);
}
