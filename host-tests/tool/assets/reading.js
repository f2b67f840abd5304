// The text of a file that the user opens, as the command line reads it.

import { Failure } from "./api.js";

/** The longest file in bytes, and the longest log. */
const LONGEST = 1 << 20;
export const LONGEST_LOG = 16 << 20;

/** The encoding: UTF-16 has a byte order mark, or a letter of ASCII at its beginning. @param {Uint8Array} bytes */
function encoding([first, second]) {
  const isLetter = (/** @type {number} */ byte) => byte > 0 && byte < 0x80;
  if ((first === 0xFF && second === 0xFE) || (isLetter(first) && second === 0)) return "utf-16le";
  if ((first === 0xFE && second === 0xFF) || (first === 0 && isLetter(second))) return "utf-16be";
  return "utf-8";
}

/**
 * The text of a file in UTF-8 or UTF-16, without byte order marks. A data sheet can be in Latin-1 too.
 * @param {Blob} chosen @param {{isDataSheet: boolean, longest?: number}} kind
 */
export async function textOf(chosen, { isDataSheet, longest = LONGEST }) {
  if (chosen.size > longest) throw new Failure(longest === LONGEST ? "file-too-long" : "log-too-long");
  const bytes = new Uint8Array(await chosen.arrayBuffer());
  try {
    return new TextDecoder(encoding(bytes), { fatal: true }).decode(bytes).replaceAll("\uFEFF", "");
  } catch {
    if (!isDataSheet) throw new Failure("file-no-text");
    return new TextDecoder("latin1").decode(bytes);
  }
}
