// @ts-check
// Numbers and names as people read them, in the language of the page; files and command lines write numbers with points.

/** A narrow space that does not break: it stands between thousands and before units. */
const THIN = "\u202f";

/** The decimal mark of the language. @param {string} text */
const withMark = (text) => (state.language === "de" ? text.replace(".", ",") : text).replace("-", "−");

/**
 * A number with at most so many decimals and no needless zeros.
 * @param {number} value
 * @param {number} [decimals]
 */
function number(value, decimals = 1) {
  const text = rounded(value, decimals);
  return withMark(text.includes(".") ? text.replace(/\.?0+$/, "") : text);
}

/** A number with exactly so many decimals. @param {number} value @param {number} decimals */
const fixed = (value, decimals) => withMark(rounded(value, decimals));

/** A whole number with spaces between its thousands. @param {number} n */
function grouped(n) {
  const text = String(Math.round(n));
  return text.length > 4 ? text.replace(/\B(?=(\d{3})+$)/g, THIN) : text;
}

/** A share in percent. @param {number} part @param {number} whole */
const percent = (part, whole) => withMark(shareWords(part, whole));

/** A share in percentage points. @param {number} part @param {number} whole */
const points = (part, whole) => fixed(tenthsOf(part, Math.max(1, whole)) / 10, 1);

/** A length in meters, or in kilometers from 1 km on. @param {number} m */
const lengthWords = (m) => (m >= 1000 ? `${number(m / 1000, 2)}${THIN}km` : `${number(m, m < 10 ? 1 : 0)}${THIN}m`);

/** A time: seconds, or minutes and seconds from two minutes on. @param {number} s */
function timeWords(s) {
  const whole = Math.round(s);
  return s < 120 ? `${number(s, 1)}${THIN}s` : `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}${THIN}min`;
}

const meters = (/** @type {number} */ m, decimals = 1) => `${number(m, decimals)}${THIN}m`;

/** A height with what it is measured from. @param {Height} height */
const heightWords = (height) => `${meters(height.m)} ${say().kinds[height.kind]}`;

/** The shorter form on the map: a height above the ground is a bare number. @param {Height} height */
const heightShort = (height) => `${meters(height.m)} ${say().kindsShort[height.kind]}`.trimEnd();

/** A name for reading: a mere number is that of a UAV. @param {Uav} uav */
const uavName = (uav) => (/^\d+$/.test(uav.id) ? `${isObserver(uav) ? say().observer : say().uav} ${uav.id}` : uav.id);

/** A place for reading. @param {{x: number, y: number}} at */
const placeWords = ({ x, y }) => `x ${coordinate(x)}, y ${coordinate(y)}`;

/**
 * What the margin of a link means for its receiver; empty where only the ground or roof that it stands on limits it.
 * @param {number} margin_m
 * @param {number} standing_m height of the receiver above what it stands on
 */
function marginWords(margin_m, standing_m) {
  if (margin_m < 0) return say().higher(margin_m > -1000 ? meters(Math.ceil(-10 * margin_m) / 10) : lengthWords(-margin_m));
  return margin_m < standing_m - 0.05 ? say().lower(meters(Math.floor(10 * margin_m) / 10)) : "";
}

/** The name of the UAV that something is about, where there are several. */
const ofSelected = () => (state.uavs.length > 1 ? `: ${uavName(selectedUav())}` : "");

/** The range as a part of a sentence: empty where it is unlimited. */
const withinRange = () =>
  (state.sight.radius === null ? "" : ` ${say().within(lengthWords(state.sight.radius))}`) + (antennaSays(state.sight).length > 0 ? ` ${say().inAntenna}` : "");

const degrees = (/** @type {number} */ deg) => `${number(deg, 2)}°`;

/** What the antenna of a sight serves, thing by thing. @param {Sight} sight */
function antennaSays({ min_radius, sector, elevation, beam, slant_range }) {
  const words = say();
  const pair = (/** @type {[number, number]} */ [a, b]) => words.fromTo(degrees(a), degrees(b));
  return [
    min_radius === null ? "" : words.fromOn(lengthWords(min_radius)),
    sector === null ? "" : `${words.sector} ${pair(sector)}`,
    elevation === null ? "" : `${words.elevations} ${pair(elevation)}`,
    beam === null ? "" : `${words.beamShort} ${degrees(beam)}`,
    slant_range === null ? "" : `${words.slantRange} ${lengthWords(slant_range)}`,
  ].filter((part) => part);
}

/** What is said of a sight beside receivers and range: its antenna, the curve of the earth, errors of heights. @param {Sight} sight */
const limitsSay = (sight) => [
  ...antennaSays(sight),
  ...(sight.earth_k ? [say().curvedEarth(number(sight.earth_k, 4))] : []),
  ...(sight.height_error ? [say().heightsOff(lengthWords(sight.height_error))] : []),
];

/** What the height of receivers is measured from. */
const receiversAbove = () => say().above[state.sight.receivers === "all" ? "all" : state.sight.receivers === "roof" ? "roof" : "ground"];

/** A coordinate for reading, to a tenth of a cell at most. @param {number} v */
const coordinate = (v) => fixed(v, Math.max(0, Math.min(POSITION_DIGITS - 1, 8)));

/**
 * The longest of 1, 2 and 5 times powers of ten that is not longer.
 * @param {number} longest
 */
function roundLength(longest) {
  const power = 10 ** Math.floor(Math.log10(longest));
  return ([5, 2, 1].find((digit) => digit * power <= longest) ?? 1) * power;
}

/**
 * About so many round values between two, with their texts.
 * @param {number} low
 * @param {number} high
 * @param {number} wanted
 * @returns {[number, string][]}
 */
function ticks(low, high, wanted) {
  const rough = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * (rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const first = Math.ceil(low / step - 1e-9);
  /** @type {[number, string][]} */
  const found = [];
  for (let k = first; k * step <= high + 1e-9 * (high - low); k += 1) found.push([k * step, number(k * step, decimals)]);
  return found;
}

// For machines.

/** A height as the command line takes it. @param {Height} height */
const heightTyped = (height) => `${height.m}${height.kind}`;

/** A word as a shell takes it. @param {string} word */
const shellWord = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

/** The options of a placement and a sight, with values that are not the default. @param {Uav[]} uavs @param {Sight} sight */
function optionWords(uavs, sight) {
  const words = uavs.flatMap((uav) => ["--uav", `${uav.x},${uav.y},${heightTyped(uav.height)}`]);
  // The error of heights is an option of a layer.
  const { height_error: _, ...options } = sight;
  const isSet = (/** @type {[string, any]} */ [name, value]) => value !== null && value !== false && value !== facts.defaults[name];
  const typed = (/** @type {[string, any]} */ [name, value]) => [`--${name.replaceAll("_", "-")}`, ...(value === true ? [] : [String(value)])];
  return [...words, ...Object.entries(options).filter(isSet).flatMap(typed)];
}

/** The UAVs whose map is on screen: the one that is shown, or all that hover. */
function uavsOnMap() {
  const { layer, which } = shown();
  const hovers = (/** @type {number} */ k) => coverage.answer?.uavs[k]?.ok !== false;
  return state.uavs.filter((_, k) => hovers(k) && (layer !== "one" || k === which));
}

/** The command line that gives the map on screen, word by word; none without a map. */
function commandWords() {
  const uavs = uavsOnMap();
  if (uavs.length === 0) return [];
  return ["skyshed", "map", ...facts.command, ...optionWords(uavs, state.sight), ...layerWords(uavs.length), "-o", `${fileStem()}.png`].map(shellWord);
}

/** The options of the layer on screen, of so many UAVs. @param {number} nUavs */
function layerWords(nUavs) {
  const { layer } = shown();
  const { height_error } = state.sight;
  if (layer === "one" && height_error) return ["--height-error", String(height_error), "--sigma", "1", "--layers", "sure"];
  // What one UAV sees is the same in all layers.
  return layer === "one" || nUavs === 1 ? [] : ["--layers", { union: "union", count: "count", who: "which" }[layer]];
}

/** The beginning of the names of files that are saved: letters and digits of the scene's name. */
function fileStem() {
  const stem = facts.name.normalize("NFKD").toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-+|-+$/g, "");
  return stem.slice(0, 40) || "skyshed";
}
