// The connection bar, the found sensors, and the state of the bus.

import { which } from "./actions.js";
import { Failure, get, post } from "./api.js";
import { answered, ask } from "./dialog.js";
import { textOf } from "./reading.js";
import { attempt, element, emit, fail, goneText, isReady, make, mayAct, on, press, sensor, state } from "./state.js";
import { currentLanguage, inLanguage, onLanguage, t } from "./texts.js";
import { missed } from "./trace.js";

const input = (/** @type {string} */ id) => /** @type {HTMLInputElement & HTMLSelectElement} */ (element(id));
/** @type {any[] | null} */
let found = null;
/** The rows that the page shows, as text. */
let drawn = "";
/** What the user waits for: `finding` or `connecting`. */
let waits = "";
/** The number of the newest request of the bar. */
let turn = 0;
/** The text without rows. */
let ended = "found-empty";
/** What waits for the end of the running action. @type {(() => void)[]} */
const ending = [];
/** The products of the catalogue. @type {Product[]} */
let catalogue = [];
/** The data sheets. @type {Product[]} */
let sheets = [];

/** @typedef {{sheet: string, name: string, maker: string, protocol: string, file?: string, entries?: number, leftOut?: number}} Product */

/** What the fields of the bar say. */
export function wanted() {
  const protocol = input("protocol").value;
  return {
    port: input("port").value.trim(),
    rate: input("rate").value === "" ? null : Number(input("rate").value),
    mode: input("mode").value,
    protocol: protocol || null,
    address: protocol ? input("address").value.trim() : null,
    product: input("product").value || null,
  };
}

/** Offers the products and the data sheets. */
function showProducts() {
  for (const id of ["product", "template"]) {
    const place = input(id);
    const chosen = place.value;
    const options = [...catalogue, ...sheets].map(({ sheet, name, maker, file }) => new Option(`${name} (${file ?? maker})`, sheet));
    place.replaceChildren(...[...place.options].filter(({ value }) => value === ""), ...options);
    place.value = options.some(({ value }) => value === chosen) ? chosen : place.options[0]?.value ?? "";
  }
  showSheet();
}

function showSheet() {
  const own = sheets.find(({ sheet }) => sheet === input("product").value);
  const place = element("eds-state");
  place.hidden = own === undefined;
  place.textContent = own ? t("data-sheet-is", own.file ?? "", own.entries ?? 0, own.leftOut ?? 0) : "";
}

/** Hands the file of a data sheet to the server. */
async function openSheet() {
  const field = input("eds");
  const [chosen] = field.files ?? [];
  if (!chosen) return;
  try {
    const row = await post("api/eds", { name: chosen.name, text: await textOf(chosen, { isDataSheet: true }) });
    if (!sheets.some(({ sheet }) => sheet === row.sheet)) sheets = [...sheets, row];
    input("product").value = "";
    showProducts();
    input("product").value = row.sheet;
    if (input("protocol").value !== row.protocol) input("address").value = "";
    input("protocol").value = row.protocol;
    showAddress();
    showSheet();
    input("address").focus();
  } finally {
    // The same file can be chosen again.
    field.value = "";
  }
}

/** Offers the ports that are there now. */
async function showPorts() {
  const { ports } = await get("api/ports");
  element("ports").replaceChildren(...ports.map((/** @type {any} */ port) => new Option(port.maker ?? port.kind, port.port)));
}

/** Offers the kinds of addresses. */
function showProtocols() {
  const place = input("protocol");
  const chosen = place.value;
  const options = state.protocols.map(({ name }) => new Option(t(`protocol-${name}`), name));
  place.replaceChildren(...[...place.options].filter(({ value }) => value === ""), ...options);
  place.value = chosen;
}

function showAddress() {
  const protocol = input("protocol").value;
  const isGiven = protocol !== "";
  element("address-help").hidden = !isGiven;
  element("address-help").textContent = isGiven ? t(`address-help-${protocol}`) : "";
  element("address-label").hidden = !isGiven;
  input("address").required = isGiven;
}

/** @param {{port: string, rate: number | null, protocol: string | null, address: string | null, product: string | null}} values */
function fill(values) {
  input("port").value = values.port;
  input("rate").value = values.rate === null ? "" : String(values.rate);
  input("protocol").value = values.protocol ?? "";
  input("address").value = values.address ?? "";
  input("product").value = values.product ?? "";
  showAddress();
  showSheet();
}

/**
 * Sends a request, and says meanwhile what the user waits for. Where the program asks before it sends to the bus, the user answers: the
 * request with the yes goes on after the question.
 * @param {string} path @param {object} sent @param {string} name of the button @param {string} doing
 */
async function asking(path, sent, name, doing) {
  turn += 1;
  const own = turn;
  waits = doing;
  showFound();
  let end = doing === "finding" ? "found-nothing" : "found-empty";
  try {
    await answered((yes) => post(path, { ...sent, yes }), name);
  } catch (error) {
    // A scan that gave way to a connection is over.
    if (own !== turn) return;
    const code = error instanceof Failure ? error.code : "";
    if (code !== "nothing-found") end = code === "stopped" ? "found-stopped" : "found-empty";
    throw error;
  } finally {
    if (own === turn) {
      [waits, ended] = ["", end];
      showFound();
    }
  }
}

const connect = () => asking("api/connect", wanted(), t("connect"), "connecting");

async function find() {
  const { port, rate } = wanted();
  if (!input("port").reportValidity()) return;
  const answer = await ask({
    title: t("find-title", port), text: t("find-text"), yes: t("find-listen"), checks: [t("find-ask"), t("find-search")],
  });
  if (!answer) return;
  const [active, search] = answer.checked;
  // Who wants to search wants to ask.
  await asking("api/scan", { port, rate, active: active || search, search }, t("find"), "finding");
}

/** The button that shows another sensor of the same bus in the chart. @param {any} row */
function adders(row) {
  const { device, status } = state;
  const isHere = device !== null && status?.state === "active" && device.rate === row.rate;
  if (!isHere || (device.protocol === row.protocol && device.address === row.address)) return [];
  const { protocol, address, product } = row;
  const button = /** @type {HTMLButtonElement} */ (make("button", t("add-to-chart")));
  button.type = "button";
  button.dataset.kind = "add";
  button.setAttribute("aria-label", t("add-of", `${product ?? protocol} ${address}`));
  const own = sensor();
  // The sensor says its product, except one that is known by its data sheet only.
  button.addEventListener("click", () => attempt(() => answered((yes) => post("api/chart", { add: { protocol, address, yes } }, own), t("add-to-chart")), button));
  return [button];
}

/** @param {any} row */
function row(row) {
  const line = document.createElement("tr");
  const cells = [row.product ?? t("unknown"), row.label ?? "", row.rate ?? "-", row.address === null || row.address === undefined ? "-" : t(`address-${row.protocol}`, row.address), row.serial ?? "-", row.article ?? row.heard ?? "-", row.firmware ?? "-"];
  const button = /** @type {HTMLButtonElement} */ (make("button", t("use", row.product ?? row.address ?? row.protocol)));
  button.type = "button";
  button.addEventListener("click", () => attempt(async () => {
    // The sensor is shown while the scan goes on.
    if (waits === "finding") {
      turn += 1;
      await stopped();
    }
    const port = state.status?.port ?? input("port").value;
    // A device that is not in the catalogue can have the data sheet that was chosen.
    const own = input("product").value;
    const product = row.product === null && own.startsWith("eds:") ? own : null;
    fill({ port, rate: row.rate, protocol: row.protocol, address: row.address, product });
    input("mode").value = "active";
    await connect();
  }, button));
  const cell = make("td", undefined, "buttons");
  // A node without node-ID has no address, and one that was only heard need not tell it.
  if (/^[0-9a-f]+$/i.test(row.address ?? "")) cell.append(button, ...adders(row));
  line.append(cell, ...cells.map((text) => make("td", String(text))));
  return line;
}

function showFound() {
  const rows = found ?? [];
  // A row that stays the same keeps the focus.
  const next = JSON.stringify([rows, currentLanguage(), state.device, state.status?.state]);
  if (next !== drawn) element("found").replaceChildren(...rows.map(row));
  drawn = next;
  element("found-scroll").hidden = rows.length === 0;
  const empty = element("found-empty");
  empty.hidden = rows.length > 0;
  const device = state.device;
  if (waits) empty.textContent = t(waits);
  else if (device) empty.textContent = [which(), device.article, device.firmware].filter(Boolean).join(" ");
  else empty.textContent = t(ended);
}

function showStatus() {
  const { status, gone } = state;
  const isGone = gone !== null;
  const busy = (status?.busy ?? null) !== null;
  for (const id of ["connect", "find"]) input(id).disabled = busy || !mayAct();
  input("disconnect").disabled = busy || !mayAct() || (status?.state ?? "closed") === "closed";
  input("stop").disabled = !busy || !mayAct();
  for (const id of ["eds", "file", "new-file"]) input(id).disabled = isGone;
  for (const button of element("found").querySelectorAll("button")) button.disabled = !mayAct() || (button.dataset.kind === "add" && !isReady());
  if (isGone) {
    set("state", t(goneText()));
    set("frames-per-second", "-");
    set("errors", t("unknown"));
    return;
  }
  if (!status) return;
  let text = t(`state-${status.state}`);
  if (status.silent) text = t("state-silent");
  if (status.busy) text = t("state-busy", status.busy);
  set("state", text);
  set("bus", status.state === "closed" ? "-" : `${status.port ?? ""} ${status.rate === null ? "" : `${status.rate} kbit/s`}`.trim());
  set("frames-per-second", String(status.perSecond));
  const errors = status.errors === null ? t("unknown") : String(status.errors);
  const unread = status.unread ?? null;
  set("errors", unread === null ? errors : `${errors}; ${t("unread", unread.lines, unread.first)}`);
  set("lost", String(status.lost + missed.count));
  element("unsaved-row").hidden = status.unsaved.length === 0;
  set("unsaved", status.unsaved.join(", "));
  showLines();
}

/** The commands that record the same on the command line. */
function showLines() {
  const line = state.status?.line ?? null;
  const every = Math.max(1, Math.round(1000 / (state.status?.samples || 50)));
  element("record-note").hidden = line === null || state.status?.state !== "active";
  element("log-note").hidden = line === null;
  set("record-line", `${line} record angles.csv --every ${every}`);
  set("log-line", `${line} log frames.log`);
}

/** Stops the running action, and waits for its end. */
async function stopped() {
  const end = new Promise((/** @type {(value: void) => void} */ resolve) => ending.push(resolve));
  await post("api/stop", {});
  await end;
}

/** Writes a text only when it is new: the page is redrawn less. @param {string} id @param {string} text */
function set(id, text) {
  const place = element(id);
  if (place.textContent !== text) place.textContent = text;
}

/** Starts the bar: ports, rates and products come from the server. */
export async function start() {
  element("connection").addEventListener("submit", (/** @type {Event} */ event) => {
    event.preventDefault();
    attempt(connect, element("connect"));
  });
  press("disconnect", () => post("api/disconnect", {}));
  press("find", find);
  press("stop", () => post("api/stop", {}));
  element("protocol").addEventListener("change", showAddress);
  element("product").addEventListener("change", showSheet);
  element("eds").addEventListener("change", () => attempt(openSheet));
  // The user can plug in an adapter meanwhile.
  element("port").addEventListener("focus", () => showPorts().catch(fail));
  on("sheets", (rows) => { sheets = rows; showProducts(); });
  on("status", () => { showFound(); showStatus(); });
  on("device", showFound);
  on("found", (rows) => { found = rows; showFound(); });
  on("note", ({ texts }) => { element("progress").textContent = inLanguage(texts); });
  on("progress", ({ done, total, texts }) => {
    const bar = input("progress-bar");
    [bar.max, bar.value, bar.hidden] = [total, done, false];
    element("progress").textContent = `${done}/${total} ${inLanguage(texts)}`;
  });
  on("action", ({ state: end }) => {
    if (end === "running") return;
    ending.splice(0).forEach((resolve) => resolve());
    element("progress").textContent = "";
    element("progress-bar").hidden = true;
  });
  onLanguage(() => { showFound(); showStatus(); showSheet(); showProtocols(); showAddress(); });
  const [{ ports, rates, first }, products, protocols] = await Promise.all([get("api/ports"), get("api/products"), get("api/protocols")]);
  emit("protocols", protocols);
  showProtocols();
  element("ports").replaceChildren(...ports.map((/** @type {any} */ port) => new Option(port.maker ?? port.kind, port.port)));
  input("rate").append(...rates.map((/** @type {number} */ rate) => new Option(`${rate} kbit/s`, String(rate))));
  catalogue = products.filter((/** @type {Product} */ { file }) => file === undefined);
  sheets = products.filter((/** @type {Product} */ { file }) => file !== undefined);
  showProducts();
  fill(first);
  // A page that is opened again has the port of the connection.
  if (state.status?.port) input("port").value = state.status.port;
  state.rates = rates;
  emit("products", products);
}
