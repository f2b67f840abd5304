// A question before an action, with an optional field.

import { t } from "./texts.js";

const element = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));

/**
 * @typedef {object} Field
 * @property {string} label
 * @property {string} [value]
 * @property {string} [hint]
 * @property {string[]} [choices]
 * @property {number} [min] with `max`: the field is a number
 * @property {number} [max]
 * @property {boolean} [optional]
 */

/**
 * Asks; returns null for no, else the text of the field and which boxes are checked.
 * @param {{title: string, text: string, yes: string, field?: Field,
 *   checks?: (string | {text: string, checked: boolean})[]}} question
 * @returns {Promise<{value: string, checked: boolean[]} | null>}
 */
export function ask(question) {
  const dialog = element("question");
  // One question at a time: a second one counts as cancelled.
  if (dialog.open) return Promise.resolve(null);
  element("question-title").textContent = question.title;
  const text = element("question-text");
  text.replaceChildren(...question.text.split("\n").map((line) => {
    const paragraph = document.createElement("p");
    paragraph.textContent = line;
    return paragraph;
  }));
  const place = element("question-field");
  place.replaceChildren();
  let input = /** @type {any} */ (null);
  if (question.field) input = field(place, question.field);
  const boxes = (question.checks ?? []).map((check, number) => {
    const label = document.createElement("label");
    label.className = "check";
    const box = document.createElement("input");
    box.type = "checkbox";
    box.id = `question-check-${number}`;
    box.checked = typeof check !== "string" && check.checked;
    label.append(box, typeof check === "string" ? check : check.text);
    place.append(label);
    return box;
  });
  element("question-yes").textContent = question.yes;
  element("question-no").textContent = t("cancel");
  dialog.returnValue = "no";
  dialog.showModal();
  (input ?? element("question-no")).focus();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      const answer = { value: input?.value.trim() ?? "", checked: boxes.map((box) => box.checked) };
      resolve(dialog.returnValue === "yes" ? answer : null);
    }, { once: true });
  });
}

/** @param {HTMLElement} place @param {Field} wanted */
function field(place, wanted) {
  const label = document.createElement("label");
  const name = document.createElement("span");
  name.textContent = wanted.label;
  const input = document.createElement(wanted.choices?.length ? "select" : "input");
  input.id = "question-input";
  if (input instanceof HTMLSelectElement) {
    input.append(...(wanted.choices ?? []).map((choice) => new Option(choice, choice)));
  } else {
    input.required = !wanted.optional;
    input.autocomplete = "off";
    if (wanted.max !== undefined) {
      input.type = "number";
      input.min = String(wanted.min ?? 0);
      input.max = String(wanted.max);
    }
  }
  if (wanted.value !== undefined) input.value = wanted.value;
  label.append(name, input);
  place.append(label);
  if (wanted.hint) {
    const hint = document.createElement("p");
    hint.className = "note";
    hint.id = "question-hint";
    hint.textContent = wanted.hint;
    input.setAttribute("aria-describedby", hint.id);
    place.append(hint);
  }
  return input;
}
