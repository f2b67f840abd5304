// The requests to the server, and its events. The address that `plumbline serve` prints has the secret behind `#`.

const KEPT = "plumbline-token";
const GIVEN = /^#[0-9a-f]{32}$/;

/** @returns {string} the secret of this tab */
function secret() {
  if (GIVEN.test(location.hash)) {
    sessionStorage.setItem(KEPT, location.hash.slice(1));
    // It does not stay in the history of the browser.
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem(KEPT) ?? "";
}

const token = secret();

/** The name of this tab: only one tab is in charge. */
export const TAB = Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join("");

// The address of a server that was started again changes only the part behind `#`.
addEventListener("hashchange", () => { if (GIVEN.test(location.hash)) location.reload(); });

/** A request that failed: its code and its texts, and whether the bus or the sensor is the cause. */
export class Failure extends Error {
  /**
   * @param {string} code @param {import("./texts.js").Texts | null} [texts] of the program @param {boolean} [isOfBus]
   * @param {import("./texts.js").Question[]} [questions] that must be answered first
   */
  constructor(code, texts = null, isOfBus = false, questions = []) {
    super(code);
    this.code = code;
    this.texts = texts;
    this.isOfBus = isOfBus;
    this.questions = questions;
  }
}

/** @param {Response} response */
async function failure(response) {
  try {
    const { error, texts, asks } = await response.json();
    return new Failure(error.code, texts, [502, 504].includes(response.status), asks);
  } catch {
    const text = `HTTP ${response.status}`;
    return new Failure("http", { en: text, de: text });
  }
}

/** @param {string} path @param {RequestInit} options */
async function ask(path, options) {
  let response;
  try {
    response = await fetch(path, { ...options, headers: { ...options.headers, "X-Plumbline-Token": token, "X-Plumbline-Tab": TAB } });
  } catch {
    throw new Failure("gone");
  }
  if (!response.ok) throw await failure(response);
  return response;
}

/** @param {string} path @returns {Promise<any>} */
export async function get(path) {
  return (await ask(path, {})).json();
}

/**
 * A request. One to a sensor has the number of the sensor that the user has seen: another one is not changed.
 * @param {string} path @param {unknown} body @param {number | null} [sensor] @returns {Promise<any>}
 */
export async function post(path, body, sensor = null) {
  const headers = { "Content-Type": "application/json", ...(sensor === null ? {} : { "X-Plumbline-Sensor": String(sensor) }) };
  return (await ask(path, { method: "POST", headers, body: JSON.stringify(body) })).json();
}

/**
 * Reads the events until the tab is closed; connects again after a pause.
 * @param {(kind: string, data: any) => void} take
 * @param {(failure: Failure | null) => void} changed
 */
export async function events(take, changed) {
  for (;;) {
    try {
      const response = await ask("api/events", {});
      changed(null);
      await read(response, take);
      changed(new Failure("gone"));
    } catch (error) {
      changed(error instanceof Failure ? error : new Failure("gone"));
    }
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
}

/** @param {Response} response @param {(kind: string, data: any) => void} take */
async function read(response, take) {
  const reader = /** @type {ReadableStream<Uint8Array>} */ (response.body).getReader();
  const decoder = new TextDecoder();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    text += decoder.decode(value, { stream: true });
    let end;
    while ((end = text.indexOf("\n\n")) >= 0) {
      const lines = text.slice(0, end).split("\n");
      text = text.slice(end + 2);
      const field = (/** @type {string} */ name) => lines.find((line) => line.startsWith(name))?.slice(name.length);
      const [kind, data] = [field("event: "), field("data: ")];
      if (kind !== undefined && data !== undefined) take(kind, JSON.parse(data));
    }
  }
}
