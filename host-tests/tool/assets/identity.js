// The identity of a unit: that of the sensor or of a file, for the store file of its replacement.

import { get, post } from "./api.js";
import { download } from "./chart.js";
import { ask } from "./dialog.js";
import { textOf } from "./reading.js";
import { attempt, element, isReady, make, mayAct, on, press, sensor, state } from "./state.js";
import { onLanguage, t } from "./texts.js";

/** @typedef {{product: string, identity: Record<string, number | string | null>, sheet: string, from: string}} Identity */

/** @type {Identity | null} */
let identity = null;
/** The store file of the command line. @type {string | null} */
let store = null;

async function read() {
  const answer = await post("api/run", "identity", sensor());
  identity = { ...answer, from: `${answer.product}.toml` };
  show();
}

async function open() {
  const field = element("identity-file");
  const [chosen] = field.files;
  if (!chosen) return;
  try {
    const { name } = chosen;
    // A sheet names its product, an EDS does not.
    const product = name.endsWith(".toml") ? null : state.device?.product ?? (element("product").value || null);
    identity = { ...await post("api/identity", { text: await textOf(chosen, { isDataSheet: !name.endsWith(".toml") }), name, product }), from: name };
    show();
  } finally {
    // The same file can be opened again.
    field.value = "";
  }
}

/** The lines of the identity. @param {Identity} own */
const lines = (own) => Object.entries(own.identity).map(([name, value]) => [name, value === null ? t("identity-own") : String(value)]);

async function write() {
  if (!identity || store === null) return;
  const { product, sheet, from } = identity;
  const text = [t("identity-write-text", product, store), ...lines(identity).map(([name, value]) => `${name}: ${value}`)].join("\n");
  if (!(await ask({ title: t("identity-write-title"), text, yes: t("write") }))) return;
  await post("api/identity/store", { text: sheet, name: from.replace(/\.[^.]*$/, ".toml") });
  element("identity-state").textContent = t("identity-written", store);
}

function enable() {
  const isGone = state.gone !== null;
  element("identity-read").disabled = !isReady();
  element("identity-file").disabled = isGone;
  element("identity-download").disabled = identity === null;
  element("identity-write").disabled = !mayAct() || identity === null || store === null;
}

function show() {
  enable();
  element("identity-scroll").hidden = identity === null;
  const rows = identity ? lines(identity) : [];
  element("identity-rows").replaceChildren(...rows.map((cells) => {
    const row = make("tr");
    row.append(...cells.map((cell) => make("td", cell)));
    return row;
  }));
  const found = identity ? t("identity-is", identity.product, identity.from) : t("identity-none");
  const place = store === null ? t("identity-no-store") : "";
  element("identity-state").textContent = `${found} ${place}`.trim();
}

/** Starts the section. */
export function start() {
  press("identity-read", read);
  element("identity-file").addEventListener("change", () => attempt(open));
  element("identity-download").addEventListener("click", () => {
    if (identity) download(`${identity.product}-identity.toml`, "application/toml", identity.sheet);
  });
  press("identity-write", write);
  on("status", enable);
  onLanguage(show);
  attempt(async () => { ({ store } = await get("api/ports")); show(); });
}
