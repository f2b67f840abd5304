// Zero, teach, save, restart, factory values, addresses: each with a question before.

import { Failure, post } from "./api.js";
import { ask } from "./dialog.js";
import { element, isReady, on, press, sensor, shown, state } from "./state.js";
import { onLanguage, t } from "./texts.js";

/** Which sensor, in words. */
export function which() {
  const device = state.device;
  if (!device) return "";
  const rate = device.rate === null ? "" : t("at-rate", device.rate);
  const name = device.label ? ` "${device.label}"` : "";
  return t("of", `${device.maker} ${device.product}${name}`, device.serial ?? "-", t(`address-${device.protocol}`, device.address), rate);
}

/** The angles of this moment: the newest samples can be old. @param {number | null} own */
async function angles(own) {
  const names = (state.device?.angles ?? []).map(({ name }) => name);
  if (names.length === 0) return "-";
  /** @type {Record<string, import("./state.js").Value>} */
  let values = {};
  try {
    values = await post("api/run", { get: { names } }, own);
  } catch (error) {
    // An angle can be out of its range.
    if (!(error instanceof Failure) || error.code !== "refused") throw error;
  }
  return names.map((name) => `${name} ${shown(values[name])}`).join(", ");
}

/** @param {string} key @param {(save: boolean) => unknown} command @param {boolean} saves */
async function adjust(key, command, saves) {
  const text = t(key === "teach" ? "teach-text" : "zero-text");
  const [own, device] = [sensor(), which()];
  const answer = await ask({
    title: t(key), text: [text, device, t("now", await angles(own))].join("\n"), yes: t(key),
    checks: saves ? [t("also-save")] : [],
  });
  if (answer) await post("api/run", command(answer.checked[0] ?? false), own);
}

/** @param {string} key */
async function simple(key) {
  const own = sensor();
  const answer = await ask({ title: t(key), text: `${t(`${key}-text`)}\n${which()}`, yes: t(key) });
  if (answer) await post("api/run", key, own);
}

/** What the server says of the protocol of the sensor. */
const protocol = () => state.protocols.find(({ name }) => name === state.device?.protocol);

async function address() {
  const own = sensor();
  const { name = "", command = "", least, most } = protocol() ?? {};
  await ask({
    title: title(`new-address-${name}`), text: `${t(`new-address-text-${name}`)}\n${which()}`, yes: t("write"),
    field: { label: t("new-number"), min: least, max: most, value: state.device?.address },
  }, ({ value }) => post("api/run", { [command ?? ""]: { new: Number(value) } }, own));
}

/** The title of the question of a button. @param {string} key */
const title = (key) => t(key).replace(/\.+$/, "");

/** The rate that the sensor has stored; the setting of a GEMAC sensor has the code 0 for automatic detection. */
function stored() {
  const value = state.values?.["baud-rate"];
  if (state.device?.protocol === "fsc" && value?.raw === 0) return "auto";
  const text = `${value?.value} ${value?.unit}`;
  const number = Number.parseFloat(text) * (text.includes("Mbit") ? 1000 : text.includes("kbit") ? 1 : 0.001);
  return state.rates.includes(number) ? String(number) : String(state.device?.rate ?? 125);
}

async function rate() {
  const own = sensor();
  const automatic = state.device?.protocol === "fsc" ? ["auto"] : [];
  await ask({
    title: title("bit-rate"), text: `${t("bit-rate-text")}\n${which()}`, yes: t("write"),
    field: { label: `${t("rate")} / (kbit/s)`, choices: [...automatic, ...state.rates.map(String)], value: stored() },
  }, ({ value }) => post("api/run", { rate: { new: value } }, own));
}

async function label() {
  const own = sensor();
  await ask({
    title: title("label"), text: `${t("label-text")}\n${which()}`, yes: t("label-yes"),
    field: { label: t("name"), value: state.device?.label ?? "", optional: true },
  }, ({ value }) => post("api/run", { label: { name: value || null } }, own));
}

function show() {
  const device = state.device;
  const axes = device?.zero ?? [];
  const { name, command } = protocol() ?? {};
  // A data sheet does not say how an address is changed.
  const isOurs = !device?.foreign;
  const offered = {
    "zero": axes.length > 0 || !device,
    "zero-x": axes.includes("x"),
    "zero-y": axes.includes("y") && (device?.angles.length ?? 0) > 1,
    "teach": device?.teach ?? false,
    "save": device?.saves ?? true,
    "restart": true,
    "load-factory": true,
    "new-address": isOurs && Boolean(command),
    "bit-rate": isOurs,
    "label": device === null || device.serial !== null,
  };
  for (const [id, isOffered] of Object.entries(offered)) {
    const button = element(id);
    button.hidden = !isOffered;
    button.disabled = !isReady();
  }
  element("new-address").textContent = t(offered["new-address"] ? `new-address-${name}` : "protocol");
}

/** Starts the buttons. */
export function start() {
  const saves = () => state.device?.saves ?? true;
  /** @type {Record<string, () => Promise<unknown>>} */
  const actions = {
    "zero": () => adjust("zero", (save) => ({ zero: { save } }), saves()),
    "zero-x": () => adjust("zero-x", (save) => ({ zero: { axis: "x", save } }), saves()),
    "zero-y": () => adjust("zero-y", (save) => ({ zero: { axis: "y", save } }), saves()),
    "teach": () => adjust("teach", (save) => ({ teach: { save } }), saves()),
    "save": () => simple("save"),
    "restart": () => simple("restart"),
    "load-factory": () => simple("load-factory"),
    "new-address": address,
    "bit-rate": rate,
    "label": label,
  };
  for (const [id, run] of Object.entries(actions)) press(id, run);
  on("device", show);
  on("status", show);
  on("protocols", show);
  onLanguage(show);
}
