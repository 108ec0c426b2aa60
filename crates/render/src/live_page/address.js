// @ts-check
// The state in the fragment of the address: copying the address restores the view. What it does not say stays as it is;
// what cannot be read is left out, and said so. Whether numbers can be decides the engine.

/**
 * A UAV as x,y,height,name.
 * @param {Uav} uav
 */
const uavWord = (uav) => [uav.x, uav.y, heightTyped(uav.height), encodeURIComponent(uav.id)].join(",");

/** Several UAVs, separated by semicolons. @param {Uav[]} uavs */
const uavsWord = (uavs) => uavs.map(uavWord).join(";");

/** An antenna as six numbers or nulls: from which distance, azimuths, elevations, beam. @param {Antenna} antenna */
const antennaNumbers = ({ min_radius_m, sector_deg, elevation_deg, beam_deg }) =>
  [min_radius_m, ...(sector_deg ?? [null, null]), ...(elevation_deg ?? [null, null]), beam_deg];

/**
 * A sight as height,where,range and, if it has any, its antenna, K of the earth and the error of heights; all but the first two may be empty.
 * @param {Sight} sight
 */
function sightWord({ rx_height_m, receivers, radius_m, antenna, earth_k, height_error_m }) {
  const more = antenna || earth_k || height_error_m ? antennaNumbers(antenna ?? NO_ANTENNA) : [];
  const last = height_error_m ? [earth_k ?? "", height_error_m] : earth_k ? [earth_k] : [];
  return [rx_height_m, receivers, radius_m ?? "", ...more, ...last].join(",");
}

/** The fragment of the state, without its #. */
function addressOf() {
  const words = [`uavs=${uavsWord(state.uavs)}`, `sight=${sightWord(state.sight)}`, `layer=${state.layer}`];
  if (state.selected > 0) words.push(`selected=${state.selected + 1}`);
  if (state.view) {
    const { x, y, scale } = state.view;
    words.push(`view=${roundedPosition(x)},${roundedPosition(y)},${Number(scale.toPrecision(5))}`);
  }
  for (const kept of state.kept) words.push(`kept=${encodeURIComponent(kept.name)}:${sightWord(kept.sight)}:${uavsWord(kept.uavs)}`);
  if (state.base > 0) words.push(`base=${state.base + 1}`);
  return words.join("&");
}

/** Text of a percent-encoded word; null if it is not one. @param {string} word */
function decoded(word) {
  try {
    return decodeURIComponent(word);
  } catch {
    return null;
  }
}

/** A finite number, or null. @param {string | undefined} word */
function finite(word) {
  const value = word ? Number(word) : NaN;
  return Number.isFinite(value) ? value : null;
}

/** @param {string} word @returns {Uav | null} */
function uavOf(word) {
  const [xWord, yWord, heightWord = "", idWord = ""] = word.split(",");
  const [x, y, id] = [finite(xWord), finite(yWord), decoded(idWord)];
  const height = /^(-?[\d.e+-]+)(agl|roof|amsl)$/.exec(heightWord);
  const m = finite(height?.[1]);
  if (x === null || y === null || m === null || !height || !id) return null;
  if (x < grid.x_min || x > X_MAX || y < Y_MIN || y > grid.y_max) return null;
  return { id: id.slice(0, 200), x, y, height: { kind: /** @type {HeightKind} */ (height[2]), m } };
}

/** Some UAVs of different names, or null. @param {string} word @returns {Uav[] | null} */
function uavsOf(word) {
  const uavs = word.split(";").map(uavOf);
  const known = uavs.filter((uav) => uav !== null);
  const names = new Set(known.map((uav) => uav.id));
  return known.length === uavs.length && names.size === known.length && known.length <= MOST_UAVS ? known : null;
}

/** @type {Receivers[]} */
const RECEIVERS = ["ground", "street", "crossroad", "courtyard", "roof", "all", "air"];

/** @param {string} word @returns {Sight | null} */
function sightOf(word) {
  const [heightWord, where, ...words] = word.split(",");
  const receivers = RECEIVERS.find((name) => name === where);
  const numbers = words.map(finite);
  const [rx_height_m, radius_m = null, min = null, from = null, to = null, low = null, high = null, beam_deg = null, earth_k = null, error = null] = [finite(heightWord), ...numbers];
  // A word that is no number, and one end of two without the other.
  const isWrong = words.some((text, k) => text && numbers[k] === null) || (from === null) !== (to === null) || (low === null) !== (high === null);
  if (rx_height_m === null || !receivers || isWrong || words.length > 9) return null;
  const sector_deg = from === null || to === null ? null : /** @type {[number, number]} */ ([from, to]);
  const elevation_deg = low === null || high === null ? null : /** @type {[number, number]} */ ([low, high]);
  const antenna = antennaWith(null, { min_radius_m: min, sector_deg, elevation_deg, beam_deg });
  return { rx_height_m, receivers, radius_m, antenna, earth_k, height_error_m: error };
}

/** @param {string} word @returns {Kept | null} */
function keptOf(word) {
  const [nameWord, sight, ...uavs] = word.split(":");
  const found = { name: decoded(nameWord), uavs: uavsOf(uavs.join(":")), sight: sightOf(sight ?? "") };
  return found.name && found.uavs && found.sight ? { name: found.name, uavs: found.uavs, sight: found.sight } : null;
}

/** Takes over what a fragment says. @param {string} fragment without its # @returns {string[]} the parts that cannot be read */
function readAddress(fragment) {
  /** @type {string[]} */
  const wrong = [];
  // Kept placements are not in every address; one that names any names all.
  /** @type {Kept[]} */
  const kept = [];
  let base = 0;
  for (const part of fragment.split("&")) {
    const [key, ...rest] = part.split("=");
    const word = rest.join("=");
    // A word alone is a place on the page.
    let isRead = rest.length === 0;
    const uavs = key === "uavs" ? uavsOf(word) : null;
    if (uavs) Object.assign(state, { uavs, selected: 0, alone: null });
    const sight = key === "sight" ? sightOf(word) : null;
    if (sight) state.sight = sight;
    const layer = key === "layer" ? /** @type {Layer[]} */ (["one", "union", "count", "who"]).find((name) => name === word) : undefined;
    if (layer) state.layer = layer;
    const place = finite(word);
    if (key === "selected" && place !== null && state.uavs[place - 1]) {
      state.selected = place - 1;
      isRead = true;
    }
    if (key === "base" && place !== null) {
      base = place - 1;
      isRead = true;
    }
    const one = key === "kept" ? keptOf(word) : null;
    if (one) kept.push(one);
    const [x, y, scale] = key === "view" ? word.split(",").map(finite) : [];
    const hasView = typeof x === "number" && typeof y === "number" && scale && scale > 0;
    if (hasView) state.view = { x, y, scale };
    if (!isRead && !uavs && !sight && !layer && !one && !hasView) wrong.push(part);
  }
  if (state.uavs.length > MOST_WHO && state.layer === "who") state.layer = "count";
  if (kept.length > 0) state.kept = kept;
  if (state.kept[base]) state.base = base;
  return wrong;
}

/** Says which parts of the address were left out, if any were. @param {string[]} wrong */
function tellWrong(wrong) {
  const short = (/** @type {string} */ part) => (part.length > 60 ? `${part.slice(0, 59)}…` : part);
  // Behind what the engine may have refused of it.
  const told = toast.classList.contains("shown") ? `${toast.textContent} · ` : "";
  if (wrong.length > 0) notify(told + say().addressWrong(wrong.map(short).join(" · ")));
}

/** Writes the state into the address. A page without an address of its own (srcdoc) may be refused, which does no harm. */
function writeAddress() {
  const fragment = addressOf();
  if (location.hash.slice(1) === fragment) return;
  try {
    history.replaceState(null, "", `#${fragment}`);
  } catch {
    // Nothing to restore from then.
  }
}

/** The address that restores the view. */
const addressToCopy = () => `${location.href.replace(/#.*$/, "")}#${addressOf()}`;
