// Another program for a sensor: an image file, the settings before as a backup, the download, and the version after it.

import { which } from "./actions.js";
import { Failure, get, post } from "./api.js";
import { download } from "./chart.js";
import { wanted } from "./connection.js";
import { answered, ask } from "./dialog.js";
import { named } from "./document.js";
import { attempt, element, isAnswering, isReady, mayAct, on, press, sensor, state } from "./state.js";
import { inLanguage, onLanguage, t } from "./texts.js";

/** @typedef {{product: string, version: string, board: string, signed: boolean, name: string, image: number[]}} Image */
/** @typedef {{product: string, version: string, before: string | null, loaded: boolean, different: number | null}} Updated */

/** The longest image file in bytes. */
let longest = 0;
/** @type {Image | null} */
let image = null;
/** The settings before the last update. @type {{name: string, text: string} | null} */
let backup = null;
/** @type {Updated | null} */
let done = null;
let isRunning = false;
/** What is done now. @type {{done: number, total: number, texts: import("./texts.js").Texts} | null} */
let progress = null;

async function open() {
  const field = element("update-file");
  const [chosen] = field.files ?? [];
  if (!chosen) return;
  [image, done] = [null, null];
  show();
  try {
    if (chosen.size > longest) throw new Failure("image-too-long");
    const bytes = [...new Uint8Array(await chosen.arrayBuffer())];
    image = { ...await post("api/image", { name: chosen.name, image: bytes }), name: chosen.name, image: bytes };
    show();
  } finally {
    // The same file can be chosen again.
    field.value = "";
  }
}

async function update() {
  if (!image) return;
  const { name, product, version, board } = image;
  const [own, bytes, isHere] = [sensor(), image.image, state.device !== null];
  const place = isHere ? null : wanted();
  const address = place?.address ? t(`address-${place.protocol}`, place.address) : t("as-delivered");
  const lines = [t("update-what", product, version, board), place ? t("update-waiting", place.port || "-", address) : which(), t("update-text")];
  const checks = isAnswering() ? [{ text: t("update-keep"), checked: true }] : [];
  const answer = await ask({ title: t("update"), text: lines.join("\n"), yes: t("update-yes"), checks });
  if (!answer) return;
  [isRunning, done, progress, backup] = [true, null, null, null];
  show();
  try {
    if (answer.checked[0]) {
      const read = await post("api/backup", {}, own);
      backup = { name: named(read.product, read.serial), text: read.text };
    }
    const waiting = place && { port: place.port, rate: place.rate, mode: "active", protocol: place.protocol, address: place.address };
    const body = { name, image: bytes, backup: backup?.text ?? null, waiting };
    done = await answered((yes) => post("api/update", { ...body, yes }, own), t("update")) ?? null;
  } finally {
    isRunning = false;
    show();
  }
}

/** What has become of it. */
function result() {
  if (isRunning) return progress ? `${Math.floor(100 * progress.done / progress.total)} % ${inLanguage(progress.texts)}` : t("update-runs");
  if (!done) return image ? t("update-is", image.name, image.product, image.version, image.board) : t("update-none");
  const { loaded, version, before, different } = done;
  if (!loaded) return t("update-same", version);
  const compared = different === null ? "" : t(different === 0 ? "update-kept" : "update-differs", different);
  return `${t("update-done", version, before ?? t("update-no-version"))} ${compared}`.trim();
}

function show() {
  const isBusy = Boolean(state.status?.busy);
  element("update-file").disabled = isRunning || state.gone !== null;
  element("update-start").disabled = !image || isRunning || !mayAct() || (state.device ? !isReady() : isBusy);
  element("update-backup").hidden = backup === null;
  const bar = element("update-bar");
  bar.hidden = !isRunning || progress === null;
  if (progress) [bar.max, bar.value] = [progress.total, progress.done];
  const place = element("update-state");
  const text = result();
  if (place.textContent !== text) place.textContent = text;
}

/** Starts the section. */
export function start() {
  element("update-file").addEventListener("change", () => attempt(open));
  press("update-start", update);
  element("update-backup").addEventListener("click", () => { if (backup) download(backup.name, "application/toml", backup.text); });
  on("progress", (next) => {
    if (!isRunning) return;
    progress = next;
    show();
  });
  on("status", show);
  onLanguage(show);
  attempt(async () => { ({ longestImage: longest } = await get("api/ports")); });
}
