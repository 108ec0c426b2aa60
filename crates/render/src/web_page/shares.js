// @ts-check
"use strict";
// Numbers as the program writes them, for all web pages: one count has one share, in pictures, tables and pages alike.

/**
 * A number with so many decimals. A tie goes to the even digit, as in the program, and zero has no sign.
 * @param {number} value
 * @param {number} decimals
 */
function rounded(value, decimals) {
  let text = value.toFixed(decimals);
  // Halfway between two such numbers lie odd multiples of a power of two alone; `toFixed` rounds these away from zero.
  const isTie = Math.abs((value * 2 ** (decimals + 1)) % 2) === 1;
  if (isTie && /[13579]$/.test(text)) text = ((Math.sign(value) * (Math.abs(value) * 10 ** decimals - 0.5)) / 10 ** decimals).toFixed(decimals);
  return /^-[0.]*$/.test(text) ? text.slice(1) : text;
}

/** A share in tenths of a percent, by whole numbers; halves are rounded up. @param {number} part @param {number} whole */
function tenthsOf(part, whole) {
  const twice = 2000 * part + whole;
  return (twice - (twice % (2 * whole))) / (2 * whole);
}

/** A share in percent with one decimal, never rounding a remainder away. @param {number} part @param {number} whole */
function shareWords(part, whole) {
  if (whole === 0) return "–";
  const tenths = tenthsOf(part, whole);
  const words = part === 0 ? "0 %" : part === whole ? "100 %" : tenths < 1 ? "< 0.1 %" : tenths > 999 ? "> 99.9 %" : `${(tenths / 10).toFixed(1)} %`;
  return words.replaceAll(" ", "\u202f");
}
