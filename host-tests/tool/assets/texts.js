// All texts of the page, in two languages. The program sends its own texts in both. Names of parameters are those of the
// command line.

import { de } from "./texts-de.js";
import { en } from "./texts-en.js";

/** @type {Record<string, Record<string, string>>} */
export const texts = { en, de };

const KEPT = "plumbline-language";
let language = localStorage.getItem(KEPT) ?? (navigator.language.startsWith("de") ? "de" : "en");
/** @type {(() => void)[]} */
const listeners = [];

/** The text of a key; {0}, {1} are replaced. @param {string} key @param {...(string | number)} parts @returns {string} */
export function t(key, ...parts) {
  const text = texts[language]?.[key] ?? texts.en[key] ?? key;
  return text.replace(/\{(\d)\}/g, (_, place) => String(parts[Number(place)] ?? "-"));
}

/** A question of the program: its id and its data, which are sent back with a yes. @typedef {{question: {id: string}, texts: Texts}} Question */

/** A text of the program. @typedef {{en: string, de: string}} Texts */

/** A text of the program in the language of the page. @param {Texts} both @returns {string} */
export function inLanguage(both) {
  return language === "de" ? both.de : both.en;
}

/** @returns {string} */
export function currentLanguage() {
  return language;
}

/** The numbers of a text as the language of the page writes them. The program reads both. @param {string} text */
export function numbers(text) {
  return language === "de" ? text.replace(/(\d)\.(\d)/g, "$1,$2") : text;
}

/** A number with its decimals. @param {number} value @param {number} digits */
export function decimal(value, digits) {
  return numbers(value.toFixed(digits));
}

/** The German names of values of the present sheet, by the English ones. @type {Record<string, string>} */
let names = {};

/** @param {Record<string, string>} german */
export function setNames(german) {
  names = german;
}

/** The name of a value in the language of the page. The program takes both. @param {string} text */
export function named(text) {
  return numbers((language === "de" && names[text]) || text);
}

/** Calls it now and after each change of the language. @param {() => void} listener */
export function onLanguage(listener) {
  listeners.push(listener);
  listener();
}

/** @param {string} wanted */
export function setLanguage(wanted) {
  language = wanted in texts ? wanted : "en";
  localStorage.setItem(KEPT, language);
  for (const listener of listeners) listener();
}

/** Gives all elements of the page their texts. */
export function translate() {
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll("[data-t]")) {
    element.textContent = t(/** @type {HTMLElement} */ (element).dataset.t ?? "");
  }
  for (const element of document.querySelectorAll("[data-t-label]")) {
    element.setAttribute("aria-label", t(/** @type {HTMLElement} */ (element).dataset.tLabel ?? ""));
  }
}
