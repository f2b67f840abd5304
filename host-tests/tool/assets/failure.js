// Failures in words.

import { Failure } from "./api.js";
import { said, t } from "./texts.js";

/** A failure in the language of the page; a message of the program is in English. @param {unknown} error */
export function sentence(error) {
  const key = error instanceof Failure ? `error-${error.code}` : "";
  const text = t(key);
  return text === key ? advised(/** @type {Error} */ (error).message) : text;
}

/** A message of the program. Where it names the command for a scan, the page names its own controls. @param {string} message */
function advised(message) {
  const [head] = message.split(": ");
  if (head === message || !/`plumbline [^`]*scan/.test(message)) return said(message);
  return `${said(head)}: ${t(head.startsWith("nobody answers") ? "next-no-answer" : "next-nothing-found")}`;
}
