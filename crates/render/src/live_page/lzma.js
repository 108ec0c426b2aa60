// Unpacks LZMA, by which two engines that are mostly one take little more room than one: browsers unpack deflate alone.
//
// The format is that of .lzma files: properties, size of the dictionary, length, then one stream of a range coder.
// @ts-check
'use strict';

/**
 * The first bytes of a packed file.
 * @param {Uint8Array} packed
 * @param {number} length How many are wanted; at most as many as there are.
 * @returns {Uint8Array}
 */
function unpackLzma(packed, length) {
  const HALF = 1024;
  // Context bits of literals, bits of a literal's position, bits of a match's position.
  const lc = packed[0] % 9;
  const lp = Math.floor(packed[0] / 9) % 5;
  const pb = Math.floor(packed[0] / 45);
  const out = new Uint8Array(length);

  let at = 13;
  let range = 0xffffffff;
  let code = 0;
  for (let i = 0; i < 5; i += 1) code = ((code << 8) | packed[at++]) >>> 0;

  /** @param {Uint16Array} odds @param {number} k @returns {number} */
  function bit(odds, k) {
    const odd = odds[k];
    const bound = (range >>> 11) * odd;
    let found = 0;
    if (code < bound) {
      range = bound;
      odds[k] = odd + ((2048 - odd) >> 5);
    } else {
      range -= bound;
      code -= bound;
      odds[k] = odd - (odd >> 5);
      found = 1;
    }
    if (range < 0x1000000) {
      range = (range << 8) >>> 0;
      code = ((code << 8) | packed[at++]) >>> 0;
    }
    return found;
  }

  /** Bits of equal odds. @param {number} n */
  function evenBits(n) {
    let found = 0;
    for (let i = 0; i < n; i += 1) {
      range >>>= 1;
      const is = code >= range;
      if (is) code -= range;
      found = found * 2 + (is ? 1 : 0);
      if (range < 0x1000000) {
        range = (range << 8) >>> 0;
        code = ((code << 8) | packed[at++]) >>> 0;
      }
    }
    return found;
  }

  /** A number of n bits, highest first. @param {Uint16Array} odds @param {number} from @param {number} n */
  function bits(odds, from, n) {
    let m = 1;
    for (let i = 0; i < n; i += 1) m = m * 2 + bit(odds, from + m);
    return m - (1 << n);
  }

  /** A number of n bits, lowest first. @param {Uint16Array} odds @param {number} from @param {number} n */
  function bitsReversed(odds, from, n) {
    let m = 1;
    let found = 0;
    for (let i = 0; i < n; i += 1) {
      const is = bit(odds, from + m);
      m = m * 2 + is;
      found |= is << i;
    }
    return found;
  }

  /** @param {number} n */
  const fresh = (n) => new Uint16Array(n).fill(HALF);
  const literals = fresh(0x300 << (lc + lp));
  const isMatch = fresh(12 << 4);
  const isRepeat = fresh(12);
  const isRepeat1 = fresh(12);
  const isRepeat2 = fresh(12);
  const isRepeat3 = fresh(12);
  const isLongRepeat0 = fresh(12 << 4);
  const slots = fresh(4 << 6);
  const specials = fresh(128);
  const aligned = fresh(16);
  const newLengths = lengths();
  const repeatLengths = lengths();

  function lengths() {
    return { choice: fresh(2), low: fresh(16 << 3), middle: fresh(16 << 3), high: fresh(256) };
  }

  /** @param {ReturnType<typeof lengths>} of @param {number} place */
  function lengthOf(of, place) {
    if (bit(of.choice, 0) === 0) return 2 + bits(of.low, place << 3, 3);
    if (bit(of.choice, 1) === 0) return 10 + bits(of.middle, place << 3, 3);
    return 18 + bits(of.high, 0, 8);
  }

  /** @param {number} matchLength */
  function distanceOf(matchLength) {
    const slot = bits(slots, Math.min(matchLength - 2, 3) << 6, 6);
    if (slot < 4) return slot;
    const n = (slot >> 1) - 1;
    const high = (2 | (slot & 1)) * 2 ** n;
    if (slot < 14) return high + bitsReversed(specials, high - slot, n);
    return high + evenBits(n - 4) * 16 + bitsReversed(aligned, 0, 4);
  }

  let state = 0;
  /** Distances of the last four matches. */
  let last = [0, 0, 0, 0];
  let n = 0;
  while (n < length) {
    const place = n & ((1 << pb) - 1);
    if (bit(isMatch, (state << 4) + place) === 0) {
      const before = n > 0 ? out[n - 1] : 0;
      const from = 0x300 * (((n & ((1 << lp) - 1)) << lc) + (before >> (8 - lc)));
      let symbol = 1;
      if (state >= 7) {
        // After a match the byte that follows it over there is a guess, as long as it is right.
        let guess = out[n - last[0] - 1];
        while (symbol < 0x100) {
          const guessed = guess >> 7;
          guess = (guess << 1) & 0xff;
          const is = bit(literals, from + ((1 + guessed) << 8) + symbol);
          symbol = symbol * 2 + is;
          if (is !== guessed) break;
        }
      }
      while (symbol < 0x100) symbol = symbol * 2 + bit(literals, from + symbol);
      out[n++] = symbol & 0xff;
      if (state < 4) state = 0;
      else state -= state < 10 ? 3 : 6;
      continue;
    }
    let matchLength;
    if (bit(isRepeat, state) === 0) {
      matchLength = lengthOf(newLengths, place);
      last = [distanceOf(matchLength), last[0], last[1], last[2]];
      state = state < 7 ? 7 : 10;
      // The end of a stream that does not tell its length.
      if (last[0] === 0xffffffff) break;
    } else {
      if (bit(isRepeat1, state) === 0) {
        if (bit(isLongRepeat0, (state << 4) + place) === 0) {
          state = state < 7 ? 9 : 11;
          out[n] = out[n - last[0] - 1];
          n += 1;
          continue;
        }
      } else if (bit(isRepeat2, state) === 0) last = [last[1], last[0], last[2], last[3]];
      else if (bit(isRepeat3, state) === 0) last = [last[2], last[0], last[1], last[3]];
      else last = [last[3], last[0], last[1], last[2]];
      matchLength = lengthOf(repeatLengths, place);
      state = state < 7 ? 8 : 11;
    }
    const end = Math.min(length, n + matchLength);
    for (let from = n - last[0] - 1; n < end; from += 1) out[n++] = out[from];
  }
  return out;
}
