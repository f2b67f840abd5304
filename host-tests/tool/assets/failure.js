// Failures in words.

import { Failure } from "./api.js";
import { inLanguage, t } from "./texts.js";

/** A failure in the language of the page. One of the page itself has only its code. @param {unknown} error */
export function sentence(error) {
  if (!(error instanceof Failure)) return /** @type {Error} */ (error).message;
  return error.texts ? inLanguage(error.texts) : t(`error-${error.code}`);
}
