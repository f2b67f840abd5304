// Starts the page: texts, parts, events.

import * as actions from "./actions.js";
import * as align from "./align.js";
import * as angles from "./angles.js";
import { events, Failure } from "./api.js";
import * as attitude from "./attitude.js";
import * as calibrate from "./calibrate.js";
import * as chart from "./chart.js";
import * as connection from "./connection.js";
import * as file from "./document.js";
import * as focus from "./focus.js";
import * as frames from "./frames.js";
import * as identity from "./identity.js";
import * as log from "./log.js";
import * as owner from "./owner.js";
import * as parameters from "./parameters.js";
import { sentence } from "./failure.js";
import { attempt, element, emit, fail, isAnswering, on } from "./state.js";
import { currentLanguage, onLanguage, setLanguage, translate } from "./texts.js";
import { missed } from "./trace.js";
import * as standIn from "./stand-in.js";
import * as transmit from "./transmit.js";
import * as update from "./update.js";

const THEME = "plumbline-theme";

/** @param {string} theme */
function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  localStorage.setItem(THEME, theme);
  emit("theme", theme);
}

/** @type {unknown} */
let failure = null;
/** The sensor did not answer after the failure. */
let wasLost = false;
function showFailure() {
  const place = element("message");
  const text = failure === null ? "" : sentence(failure);
  if (place.textContent !== text) place.textContent = text;
}

/** @param {unknown} error */
function setFailure(error) {
  [failure, wasLost] = [error, !isAnswering()];
  showFailure();
}

on("failure", setFailure);
/** The reason for which a connection ended. */
let reason = "";
on("status", (status) => {
  const error = status?.error;
  if (error && error.en !== reason) fail(new Failure("ended", error, true));
  reason = error?.en ?? "";
  // A message goes with its cause.
  wasLost ||= !isAnswering();
  const isBack = wasLost && isAnswering();
  const isOver = failure instanceof Failure && (failure.code === "ended" ? !error : failure.isOfBus && isBack);
  if (isOver) setFailure(null);
});
on("device", (device) => {
  if (device && failure instanceof Failure && failure.code === "not-connected") setFailure(null);
});

onLanguage(() => { translate(); showFailure(); });
element("language").value = currentLanguage();
element("language").addEventListener("change", () => setLanguage(element("language").value));
const theme = element("theme");
theme.value = localStorage.getItem(THEME) ?? "auto";
document.documentElement.dataset.theme = theme.value;
theme.addEventListener("change", () => setTheme(theme.value));

for (const part of [angles, attitude, chart, actions, align, file, parameters, frames, transmit, standIn, update, calibrate, identity, log, focus, owner]) part.start();
attempt(connection.start);
/** @type {Failure | null} */
let lost = null;
events(emit, (error) => {
  emit(error === null ? "restarted" : "gone", error?.code ?? null);
  if (error !== null || lost !== null) emit("failure", error);
  lost = error;
});
// The tests of the page read it.
Object.assign(window, { plumbline: missed });
