// A question before an action, with an optional field.

import { Failure } from "./api.js";
import { sentence } from "./failure.js";
import { inLanguage, named, t } from "./texts.js";

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
 * @typedef {{value: string, checked: boolean[]}} Answer
 */

/**
 * Asks; returns null for no, else the text of the field and which boxes are checked. With `act` the question stays until that is done:
 * a failure is told beside the field, which keeps its text.
 * @param {{title: string, text: string, yes: string, field?: Field, isBeside?: boolean,
 *   checks?: (string | {text: string, checked: boolean})[]}} question
 * @param {(answer: Answer) => Promise<unknown>} [act]
 * @returns {Promise<Answer | null>}
 */
export function ask(question, act) {
  const dialog = element("question");
  // One question at a time: a second one counts as cancelled.
  if (dialog.open) {
    element("question-no").focus();
    return Promise.resolve(null);
  }
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
  tell(input, "");
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
  // The user acts on the page before the answer.
  if (question.isBeside) dialog.show(); else dialog.showModal();
  (input ?? element("question-no")).focus();
  const answer = () => ({ value: input?.value.trim() ?? "", checked: boxes.map((box) => box.checked) });
  return new Promise((resolve, reject) => {
    let [isRunning, isClosed] = [false, false];
    const run = async () => {
      if (!act || isRunning) return;
      isRunning = true;
      tell(input, "");
      try {
        await act(answer());
        if (isClosed) resolve(null); else dialog.close("yes");
      } catch (error) {
        if (isClosed) reject(error); else tell(input, sentence(error));
      } finally {
        isRunning = false;
        if (!isClosed) element("question-yes").removeAttribute("aria-busy");
      }
    };
    const submit = (/** @type {SubmitEvent} */ event) => {
      if (!act || /** @type {HTMLButtonElement} */ (event.submitter)?.value === "no") return;
      event.preventDefault();
      element("question-yes").setAttribute("aria-busy", "true");
      run();
    };
    element("question-form").addEventListener("submit", submit);
    dialog.addEventListener("close", () => {
      isClosed = true;
      element("question-form").removeEventListener("submit", submit);
      element("question-yes").removeAttribute("aria-busy");
      // What runs goes on; its failure is told on the page.
      if (!isRunning || dialog.returnValue === "yes") resolve(dialog.returnValue === "yes" ? answer() : null);
    }, { once: true });
  });
}

/**
 * Sends a request until its questions are answered.
 * Returns what the last one returns; undefined after a no.
 * @param {(yes: object[]) => Promise<any>} send @param {string} name of the button @param {boolean} [isBeside] the page can be used meanwhile
 */
export async function answered(send, name, isBeside = false) {
  /** The questions that were answered with yes. @type {object[]} */
  const yes = [];
  /** @type {Set<string>} */
  const no = new Set();
  for (;;) {
    try {
      return await send(yes);
    } catch (error) {
      if (!(error instanceof Failure) || error.code !== "asks") throw error;
      // One yes is enough. A question that was answered with no is not shown again.
      const given = yes.length;
      for (const { question, texts } of error.questions) {
        const same = JSON.stringify(question);
        if (no.has(same)) continue;
        if (await ask({ title: name, text: inLanguage(texts), yes: t("ask-yes"), isBeside })) {
          yes.push(question);
          break;
        }
        no.add(same);
      }
      if (yes.length === given) return undefined;
    }
  }
}

/** Tells why the text of the field was refused. @param {any} input @param {string} why */
function tell(input, why) {
  element("question-wrong").textContent = why;
  if (!input) return;
  if (why === "") input.removeAttribute("aria-invalid");
  else {
    input.setAttribute("aria-invalid", "true");
    input.focus();
  }
}

/** @param {HTMLElement} place @param {Field} wanted */
function field(place, wanted) {
  const label = document.createElement("label");
  const name = document.createElement("span");
  name.textContent = wanted.label;
  const input = document.createElement(wanted.choices?.length ? "select" : "input");
  input.id = "question-input";
  if (input instanceof HTMLSelectElement) {
    input.append(...(wanted.choices ?? []).map((choice) => new Option(named(choice), choice)));
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
  input.setAttribute("aria-describedby", "question-wrong");
  if (wanted.hint) {
    const hint = document.createElement("p");
    hint.className = "note";
    hint.id = "question-hint";
    hint.textContent = wanted.hint;
    input.setAttribute("aria-describedby", `${hint.id} question-wrong`);
    place.append(hint);
  }
  return input;
}
