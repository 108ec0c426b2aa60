// @ts-check
// What the page is about, in one object, and the only functions that change it. Whoever shows it listens.

/** @type {Facts} */
const facts = JSON.parse(htmlById("facts").textContent ?? "");
const { grid } = facts;

/** More UAVs than this have no class of their own in a picture of counts. */
const MOST_UAVS = facts.most_uavs;
/** More UAVs than this cannot be told apart in layer "who". */
const MOST_WHO = 4;

const state = {
  /** @type {Uav[]} */ uavs: structuredClone(facts.start.uavs),
  /** Index of the selected UAV. */ selected: 0,
  /** The UAV under the pointer that is shown alone, if any. @type {number | null} */ alone: null,
  /** @type {Sight} */ sight: structuredClone(facts.start.sight),
  /** @type {Layer} */ layer: facts.start.layer,
  /** The part of the map on screen; null until the map has a size. @type {View | null} */ view: null,
  /** @type {Kept[]} */ kept: [],
  /** Index of the kept placement that others are compared with. */ base: 0,
  /** @type {Language} */ language: /^de\b/i.test(navigator.language) ? "de" : "en",
  /** @type {Theme} */ theme: matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light",
  /** Whether a person chose the theme; otherwise the system does. */ themeChosen: false,
};

// A surface model alone tells no ground and no building: what others call ground is its surface.
if (facts.surface_only) {
  for (const words of [...Object.values(TEXTS), ...Object.values(OBSERVER_TEXTS)]) {
    const { name, of, above, axis } = words.surface;
    words.receiversChoice.ground = name;
    words.receiversNames.ground = of;
    words.zoneName.ground = name;
    words.kinds.agl = above;
    words.above.ground = above;
    const { heightAxis } = words;
    words.heightAxis = (aboveGround) => (aboveGround ? axis : heightAxis(aboveGround));
  }
}

/** The texts in the language of the page, about those who look. */
const say = () => (areObservers() ? OBSERVER_TEXTS : TEXTS)[state.language];

/** Whether receivers are places of a drone, which someone looks at. */
const isInAir = () => state.sight.receivers === "air";

/** Whether the page has a track: someone below it may look at it. */
const hasTrack = () => facts.tracks.length > 0;

/** Who looks at a drone from less than this above the ground or roof below is an observer there, all others are UAVs [m]. */
const OBSERVER_BELOW = 20;

/** Whether someone looks at a drone from the ground or a roof. @param {Uav} uav */
function isObserver(uav) {
  if (!isInAir() && !hasTrack()) return false;
  const seen = coverage.answer?.uavs[state.uavs.indexOf(uav)];
  const known = seen?.ok ? seen.above_m ?? Infinity : 0;
  // An answer may be about the place before.
  const of = seen?.ok ? seen.asked : undefined;
  const isOfNow = of?.x === uav.x && of.y === uav.y && of.height.m === uav.height.m && of.height.kind === uav.height.kind;
  return (isOfNow || uav.height.kind === "amsl" ? known : uav.height.m) < OBSERVER_BELOW;
}

/** The texts about one of those who look. @param {Uav} uav */
const sayOf = (uav) => (isObserver(uav) ? OBSERVER_TEXTS : TEXTS)[state.language];

/** Whether all who look are observers. */
const areObservers = () => isInAir() && state.uavs.every(isObserver);

/**
 * What changed: place (a UAV's place or height), uavs (which there are, names), selected, alone, sight, layer, view, kept,
 * look (language, theme), restored (UAVs and sight together, by something else than their fields).
 * @typedef {'place' | 'uavs' | 'selected' | 'alone' | 'sight' | 'layer' | 'view' | 'kept' | 'look' | 'restored'} Change
 */

/** @type {((change: Change, since: number) => void)[]} */
const listeners = [];

/**
 * Tells everybody of a change. `since` is when the person acted.
 * @param {Change} change
 * @param {number} [since]
 */
function changed(change, since = performance.now()) {
  for (const listener of listeners) listener(change, since);
}

const selectedUav = () => state.uavs[state.selected];

/** Digits after the point of a position: a hundredth of a cell, so that address, command line and files hold the same number. */
const POSITION_DIGITS = Math.max(0, Math.ceil(2 - Math.log10(Math.min(grid.cell_width, grid.cell_height)) - 1e-9));
const roundedPosition = (/** @type {number} */ v) => Number(v.toFixed(Math.min(POSITION_DIGITS, 12)));

const X_MAX = grid.x_min + grid.n_cols * grid.cell_width;
const Y_MIN = grid.y_max - grid.n_rows * grid.cell_height;
const within = (/** @type {number} */ v, /** @type {number} */ low, /** @type {number} */ high) => Math.min(high, Math.max(low, v));

/** The nearest place over the map; its eastern and southern border belong to no cell. @param {number} x @param {number} y */
function overMap(x, y) {
  const [insideX, insideY] = [grid.cell_width / 100, grid.cell_height / 100];
  return { x: roundedPosition(within(x, grid.x_min, X_MAX - insideX)), y: roundedPosition(within(y, Y_MIN + insideY, grid.y_max)) };
}

/**
 * Moves a UAV; it stays over the map.
 * @param {number} k
 * @param {number} x
 * @param {number} y
 * @param {number} [since]
 */
function moveUav(k, x, y, since) {
  const uav = state.uavs[k];
  const place = overMap(x, y);
  if (place.x === uav.x && place.y === uav.y) return;
  Object.assign(uav, place);
  changed("place", since);
}

/**
 * @param {number} k
 * @param {Height} height
 * @param {number} [since]
 */
function setHeight(k, { kind, m }, since) {
  const { height: old } = state.uavs[k];
  if (old.m === m && old.kind === kind) return;
  state.uavs[k].height = { kind, m };
  changed("place", since);
}

/** @param {number} k */
function select(k) {
  if (k === state.selected || !state.uavs[k]) return;
  state.selected = k;
  changed("selected");
}

/** The lowest number that names no UAV. */
function freeName() {
  for (let n = 1; ; n += 1) if (!state.uavs.some((uav) => uav.id === String(n))) return String(n);
}

/**
 * Adds a UAV like the selected one at a place, and selects it.
 * @param {number} x
 * @param {number} y
 */
function addUav(x, y) {
  if (state.uavs.length >= MOST_UAVS) return;
  const height = { ...selectedUav().height };
  state.uavs.push({ id: freeName(), ...overMap(x, y), height });
  state.selected = state.uavs.length - 1;
  // The second UAV shows what both see; who wants one alone rests on it.
  if (state.uavs.length === 2 && state.layer === "one") state.layer = "union";
  if (state.uavs.length > MOST_WHO && state.layer === "who") state.layer = "count";
  changed("uavs");
}

/** @param {number} k */
function removeUav(k) {
  if (state.uavs.length <= 1) return;
  state.uavs.splice(k, 1);
  state.alone = null;
  if (state.selected > k || state.selected === state.uavs.length) state.selected -= 1;
  if (state.uavs.length === 1) state.layer = "one";
  changed("uavs");
}

/**
 * Names a UAV; an empty name, or one that another has, is refused.
 * @param {number} k
 * @param {string} id
 */
function renameUav(k, id) {
  const name = id.trim();
  if (name && !state.uavs.some((uav, j) => j !== k && uav.id === name)) state.uavs[k].id = name;
  changed("uavs");
}

/** @param {Partial<Sight>} part */
function setSight(part) {
  Object.assign(state.sight, part);
  changed("sight");
}

/** @param {Layer} layer */
function setLayer(layer) {
  state.layer = layer;
  changed("layer");
}

/** @param {number | null} k */
function showAlone(k) {
  const alone = state.uavs.length > 1 ? k : null;
  if (alone === state.alone) return;
  state.alone = alone;
  changed("alone");
}

/** What the map shows: the layer, or the UAV under the pointer alone. @returns {{layer: Layer, which: number}} */
function shown() {
  if (state.alone !== null) return { layer: "one", which: state.alone };
  return { layer: state.uavs.length === 1 ? "one" : state.layer, which: state.selected };
}

/** Keeps the placement under the next letter. @returns {string} its name */
function keepPlacement() {
  let n = state.kept.length;
  const letters = (/** @type {number} */ k) => (k < 26 ? "" : String.fromCharCode(64 + Math.floor(k / 26))) + String.fromCharCode(65 + (k % 26));
  while (state.kept.some((kept) => kept.name === letters(n))) n += 1;
  state.kept.push(structuredClone({ name: letters(n), uavs: state.uavs, sight: state.sight }));
  changed("kept");
  return letters(n);
}

/** @param {number} k */
function removeKept(k) {
  state.kept.splice(k, 1);
  if (state.base > k || state.base === state.kept.length) state.base = Math.max(0, state.base - 1);
  changed("kept");
}

/** Shows a kept placement again. @param {number} k @returns {() => void} shows what was there before */
function showKept(k) {
  const { uavs, sight } = structuredClone(state.kept[k]);
  const before = structuredClone({ uavs: state.uavs, sight: state.sight, selected: state.selected, layer: state.layer });
  Object.assign(state, { uavs, sight, selected: 0, alone: null });
  if (uavs.length === 1) state.layer = "one";
  else if (state.layer === "one" || (state.layer === "who" && uavs.length > MOST_WHO)) state.layer = "union";
  changed("restored");
  return () => {
    Object.assign(state, before, { alone: null });
    changed("restored");
  };
}
