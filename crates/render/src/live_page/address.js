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

/** Options of a sight in the order of the address; two words for two angles. */
const IN_ORDER = ["rx_height", "receivers", "radius", "min_radius", "sector", "elevation", "beam", "earth_k", "height_error"];
const ARE_PAIRS = ["sector", "elevation"];

/**
 * A sight as the words of options in order, separated by commas; all but the first two may be empty. Other options follow as name=JSON.
 * @param {Sight} sight
 */
function sightWord(sight) {
  const words = IN_ORDER.flatMap((name) => sight[name] ?? (ARE_PAIRS.includes(name) ? ["", ""] : ""));
  while (words.length > 3 && words.at(-1) === "") words.pop();
  const others = Object.entries(sight).filter(([name, value]) => !IN_ORDER.includes(name) && value !== null && value !== false);
  return [...words, ...others.map(([name, value]) => `${name}=${encodeURIComponent(JSON.stringify(value))}`)].join(",");
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

/** A value as JSON; null for a word that is none. @param {string} word */
function valueOf(word) {
  try {
    return JSON.parse(decodeURIComponent(word));
  } catch {
    return null;
  }
}

/** @param {string} word @returns {Sight | null} */
function sightOf(word) {
  const sight = { ...structuredClone(facts.start.sight), ...Object.fromEntries(IN_ORDER.map((name) => [name, null])) };
  const words = word.split(",");
  const others = words.filter((text) => text.includes("=")).map((text) => text.split("="));
  const inOrder = words.filter((text) => !text.includes("="));
  for (const name of IN_ORDER) {
    const texts = inOrder.splice(0, ARE_PAIRS.includes(name) ? 2 : 1);
    if (texts.every((text) => !text)) continue;
    /** @type {(string | number | null)[]} */
    const values = name === "receivers" ? RECEIVERS.filter((receivers) => receivers === texts[0]) : texts.map(finite);
    if (values.length === 0 || values.includes(null) || (ARE_PAIRS.includes(name) && values.length === 1)) return null;
    sight[name] = ARE_PAIRS.includes(name) ? values : values[0];
  }
  for (const [name, text] of others) {
    const value = valueOf(text);
    if (value === null || !(name in sight)) return null;
    sight[name] = value;
  }
  return sight.rx_height === null || !sight.receivers || inOrder.length > 0 ? null : sight;
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
