// What the server has told, for all parts of the page.

import { TAB } from "./api.js";
import { named, numbers } from "./texts.js";

/**
 * @typedef {{value: number | string, unit: string, raw: number}} Value
 * @typedef {{name: string, unit: string}} Angle
 * @typedef {{name: string, raw: number}} Choice
 * @typedef {{name: string, command: string | null, least: number, most: number}} Protocol
 * @typedef {{connection: number, product: string, sheet: string, foreign: boolean, maker: string, protocol: string, address: string, serial: number | null, rate: number | null,
 *   article: string | null, firmware: string | null, label?: string, angles: Angle[], zero: string[], align: boolean, teach: boolean, saves: boolean}} Device
 * @typedef {{state: string, port: string | null, rate: number | null, perSecond: number, errors: number | null, unread?: {lines: number, first: string} | null, samples: number,
 *   lost: number, silent: boolean, unsaved: string[], sendsEvery?: number | null, busy: string | null, error: import("./texts.js").Texts | null, line: string | null}} Status
 */

export const state = {
  /** @type {Status | null} */
  status: null,
  /** @type {Device | null} */
  device: null,
  /** The values of the sensor by name. @type {Record<string, Value | null> | null} */
  values: null,
  /** The newest angles. @type {number[] | null} */
  angles: null,
  /** The bit rates in kbit/s. @type {number[]} */
  rates: [],
  /** The protocols, with the command that changes the address. @type {Protocol[]} */
  protocols: [],
  /** The tab that is in charge; null: none. @type {string | null} */
  owner: null,
  /** Why there are no events: the code of the failure. @type {string | null} */
  gone: null,
};

/** @type {Map<string, ((data: any) => void)[]>} */
const listeners = new Map();

/** Calls it for each event of a kind. @param {string} kind @param {(data: any) => void} listener */
export function on(kind, listener) {
  listeners.set(kind, [...(listeners.get(kind) ?? []), listener]);
}

/** @param {string} kind @param {any} data */
export function emit(kind, data) {
  if (kind === "status") state.status = data;
  if (kind === "device") state.device = data;
  if (kind === "protocols") state.protocols = data;
  if (kind === "values") state.values = data;
  if (kind === "owner") state.owner = data;
  if (kind === "gone") state.gone = data;
  if (kind === "restarted") state.gone = null;
  for (const listener of listeners.get(kind) ?? []) listener(data);
  // What depends on the status depends on the server as well.
  if (["gone", "restarted", "owner"].includes(kind)) emit("status", state.status);
}

/** Whether this tab can act: the server answers, and no other tab is in charge. @returns {boolean} */
export const mayAct = () => state.gone === null && (state.owner === null || state.owner === TAB);

/** Whether a command can be given to a sensor. @returns {boolean} */
export function isReady() {
  return mayAct() && state.status?.state === "active" && state.device !== null && !state.status.busy;
}

/** The key of the text for a server without events. */
export const goneText = () => (state.gone === "too-many-tabs" ? "state-tabs" : "state-gone");

/** The number of the sensor that the page shows. It is taken before a question, for the request after it. @returns {number | null} */
export function sensor() {
  return state.device?.connection ?? null;
}

/** A value with its unit, which the name of a choice can contain. @param {Value | null | undefined} value @returns {string} */
export function shown(value) {
  if (value === null || value === undefined) return "-";
  const text = typeof value.value === "number" ? numbers(String(value.value)) : value.raw === undefined ? String(value.value) : named(String(value.value));
  return text.endsWith(` ${value.unit}`) ? text : `${text} ${value.unit}`.trim();
}

/** The name of the choice that a value is. @param {Choice[]} choices @param {Value | null | undefined} value @returns {string} */
export function choice(choices, value) {
  return choices.find(({ raw }) => raw === value?.raw)?.name ?? "";
}

/** @template T @param {string} id @returns {T} */
export function element(id) {
  return /** @type {any} */ (document.getElementById(id));
}

/** Shows a failure in words. @param {unknown} error */
export function fail(error) {
  emit("failure", error);
}

/** Runs something; a failure is shown. Until its end its button shows that it is busy. @param {() => Promise<unknown>} run @param {HTMLElement} [button] */
export async function attempt(run, button) {
  button?.setAttribute("aria-busy", "true");
  try {
    emit("failure", null);
    await run();
  } catch (error) {
    fail(error);
  } finally {
    button?.removeAttribute("aria-busy");
  }
}

/** Runs something when a button is pressed. @param {string} id @param {() => Promise<unknown>} run */
export function press(id, run) {
  /** @type {HTMLElement} */
  const button = element(id);
  button.addEventListener("click", () => attempt(run, button));
}

/** Whether the sensor is connected and answers. */
export function isAnswering() {
  return state.status?.state === "active" && !state.status.silent;
}

/** @param {string} tag @param {string} [text] @param {string} [name] of the class */
export function make(tag, text, name) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (name) made.className = name;
  return made;
}
