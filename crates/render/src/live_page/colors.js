// @ts-check
// The palette of the program's pictures (crates/render/src/colors.rs), and the table from backdrop and class to color.
// Blue is line of sight and orange is none, in every theme; only paper, ground and buildings turn dark.

/** @type {Rgb} */ const LOS = [0x00, 0x72, 0xb2];
/** @type {Rgb} */ const NLOS = [0xe6, 0x9f, 0x00];
/** Pale to deep blue: the number of UAVs that see a cell. @type {Rgb[]} */
const SEEN = [[0xb4, 0xdb, 0xf2], [0x5a, 0xa9, 0xdb], LOS, [0x00, 0x3a, 0x5e]];
/** Who sees a cell: none, only UAV 1 to 4, several. @type {Rgb[]} */
const ONLY = [NLOS, LOS, [0xf0, 0xe4, 0x42], [0x88, 0x22, 0x55], [0x88, 0xcc, 0xee], [0x1b, 0x1f, 0x24]];
/** Hangs on heights of buildings. @type {Rgb} */ const UNSURE = [0xfb, 0xfa, 0xf6];
/** Colors of UAVs; the first four are those of layer "who". @type {Rgb[]} */
const UAV_COLORS = [...ONLY.slice(1, 5), [0x00, 0x9e, 0x73], [0xcc, 0x79, 0xa7], [0xd5, 0x5e, 0x00], [0x99, 0x99, 0x33]];

/**
 * What a theme changes: paper, open ground without receivers, buildings from low to tall, out of range, stripes over no data.
 * @typedef {{paper: Rgb, ground: Rgb, buildings: [Rgb, Rgb], away: Rgb, hatch: Rgb, relief: number}} Backdrop
 */

/** @type {Record<Theme, Backdrop>} */
const BACKDROPS = {
  light: {
    paper: [0xff, 0xff, 0xff],
    ground: [0xf3, 0xf1, 0xeb],
    buildings: [[0xde, 0xe0, 0xe2], [0x7d, 0x81, 0x86]],
    away: [0xe9, 0xed, 0xf0],
    hatch: [0xc2, 0xc8, 0xce],
    relief: 0.45,
  },
  dark: {
    paper: [0x14, 0x17, 0x1a],
    ground: [0x26, 0x2b, 0x30],
    buildings: [[0x3c, 0x43, 0x4a], [0x8d, 0x96, 0x9f]],
    away: [0x36, 0x42, 0x4e],
    hatch: [0x33, 0x3a, 0x41],
    relief: 0.35,
  },
};

/**
 * Mixes two colors; t = 0 gives the first.
 * @param {Rgb} a
 * @param {Rgb} b
 * @param {number} t
 * @returns {Rgb}
 */
const mix = (a, b, t) => [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t];

/**
 * Multiplies a color; above 1 the excess moves it towards white.
 * @param {Rgb} color
 * @param {number} factor
 */
const shade = (color, factor) => (factor <= 1 ? mix([0, 0, 0], color, factor) : mix(color, [255, 255, 255], Math.min(1, factor - 1)));

const hex = (/** @type {Rgb} */ color) => `#${color.map((c) => Math.round(c).toString(16).padStart(2, "0")).join("")}`;

/**
 * The color at t of a ramp, 0 to 1.
 * @param {Rgb[]} ramp
 * @param {number} t
 */
function rampAt(ramp, t) {
  const position = Math.min(1, Math.max(0, t)) * (ramp.length - 1);
  const k = Math.min(Math.floor(position), ramp.length - 2);
  return mix(ramp[k], ramp[k + 1], position - k);
}

/**
 * The color of a cell that so many of n UAVs see.
 * @param {number} seen
 * @param {number} n
 */
function countColor(seen, n) {
  if (seen === 0) return NLOS;
  return n <= 1 ? LOS : rampAt(SEEN, (seen - 1) / (n - 1));
}

/** @param {number} k which UAV, from 0 */
const uavColor = (k) => UAV_COLORS[k % UAV_COLORS.length];

/** The text color with more contrast on a color (WCAG 2.2). @param {Rgb} color */
function inkOn(color) {
  const [r, g, b] = color.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.179 ? "#1b1f24" : "#ffffff";
}

// Rows of the table of looks: classes 0 to 62; the last row is no data.
const LOOK_ROWS = 64;
const NO_DATA_ROW = LOOK_ROWS - 1;
/** The class of receivers that hang on heights of buildings. */
const UNSURE_CLASS = 15;
/** The class of a map that has no answer yet: the bare city. */
const NO_MASK_ROW = 2;

/**
 * The color of every pair of backdrop tone (across) and class (down) as RGBA. Opacity 0 stands for stripes.
 * @param {Theme} theme
 * @param {Layer} layer
 * @param {number} nUavs
 * @returns {Uint8Array}
 */
function lookTable(theme, layer, nUavs) {
  const backdrop = BACKDROPS[theme];
  const looks = new Uint8Array(256 * LOOK_ROWS * 4);
  for (let row = 0; row < NO_DATA_ROW; row += 1) {
    for (let tone = 0; tone < 256; tone += 1) {
      // Cells without data have stripes, unless somebody receives there.
      if (tone === 0 && (row === 2 || row === 3)) continue;
      const color = lookOf(row, tone, backdrop, layer, nUavs);
      const at = 4 * (256 * row + tone);
      for (let c = 0; c < 3; c += 1) looks[at + c] = Math.round(color[c]);
      looks[at + 3] = 255;
    }
  }
  return looks;
}

/**
 * The color of a class over a tone.
 * @param {number} value
 * @param {number} tone
 * @param {Backdrop} backdrop
 * @param {Layer} layer
 * @param {number} nUavs
 * @returns {Rgb}
 */
function lookOf(value, tone, backdrop, layer, nUavs) {
  const isBuilding = tone >= 128;
  const tall = (tone - 128) / 127;
  const relief = isBuilding || tone === 0 ? 0 : (tone - 64) / 63;
  const light = 1 + backdrop.relief * relief;
  if (value === 2) return isBuilding ? mix(backdrop.buildings[0], backdrop.buildings[1], tall) : shade(backdrop.ground, light);
  if (value === 3) {
    const away = shade(backdrop.away, 1 + (backdrop.relief / 2) * relief);
    return isBuilding ? mix(away, mix(backdrop.buildings[0], backdrop.buildings[1], tall), 0.45) : away;
  }
  // Receivers on roofs show how tall the roof is.
  return shade(classColor(value, layer, nUavs), isBuilding ? 1.1 - 0.3 * tall : light);
}

/**
 * The color of a class of receivers.
 * @param {number} value
 * @param {Layer} layer
 * @param {number} nUavs
 */
function classColor(value, layer, nUavs) {
  if (value === UNSURE_CLASS) return UNSURE;
  if (value < 16) return value === 1 ? LOS : NLOS;
  return layer === "who" ? ONLY[Math.min(value - 16, 5)] : countColor(value - 16, nUavs);
}
