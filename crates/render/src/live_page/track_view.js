// @ts-check
// A track, which is a walk or a flight: on the map as a line in the colors of its stretches, and from the side with what is below.

/** Samples of heights and the stretches of the newest answer. */
const track = {
  /** @type {TrackPlace[]} */ places: [],
  /** @type {StretchesAnswer | null} */ seen: null,
  /** Whether the side view is open. */ isOpen: false,
  /** Index of the place under the pointer. @type {number | null} */ at: null,
  /** The chart on screen. @type {Chart | null} */ chart: null,
  /** Whether the map is to move so that the whole track is seen. */ wantsRoom: false,
  /** Height of receivers of the newest samples: walks follow it. @type {number | null} */ rx_height: null,
};

const askStretches = newestOnly(
  () => {
    const { layer, which } = shown();
    return { do: "stretches", which: layer === "one" ? which : null, every_m: facts.track_every_m };
  },
  (/** @type {StretchesAnswer} */ answer) => {
    track.seen = answer;
    placeTrack();
    showTrack();
  },
);

const askHeights = newestOnly(
  () => {
    track.rx_height = state.sight.rx_height;
    return { do: "track_heights" };
  },
  (/** @type {{places: TrackPlace[]}} */ { places }) => {
    track.places = places;
    showTrack();
  },
);

/** Hands the tracks to the engine, and opens their side view. @param {boolean} wantsRoom whether the map is to show them all */
async function openTrack(wantsRoom) {
  buttonById("track-open").hidden = !hasTrack();
  if (!hasTrack()) return;
  await ask({ do: "tracks", tracks: facts.tracks });
  toggleTrack(true, wantsRoom);
}

/** Asks for the stretches of the newest map. */
function refreshTrack() {
  if (!hasTrack()) return;
  askStretches();
  if (track.rx_height !== state.sight.rx_height) askHeights();
}

/** Opens or closes the side view. @param {boolean} isOpen @param {boolean} [wantsRoom] */
function toggleTrack(isOpen, wantsRoom = false) {
  Object.assign(track, { isOpen, wantsRoom });
  if (isOpen) closeLink();
  else pointAlong(null);
  showTrack();
}

/** The whole track on the map above its side view. */
function makeRoomForTrack() {
  const places = facts.tracks.flatMap(({ vertices }) => vertices.map(([x, y]) => ({ x, y })));
  glideToPlaces([...places, ...state.uavs], roomAbove(htmlById("track-drawer")));
}

/** Lengths of stretches of a state by the order of answers. */
const TRACK_STATES = /** @type {TrackState[]} */ (["los", "nlos", "inside", "nodata"]);

/** Who sees the stretches that are shown. */
function trackObserver() {
  const { layer, which } = shown();
  return layer === "one" ? uavName(state.uavs[which]) : say().layers.union;
}

/** What is seen of the track, in a sentence. @param {StretchesAnswer} seen */
function trackShare({ lengths_m: [los, nlos] }) {
  return los + nlos > 0 ? say().trackSeen(trackObserver(), percent(los, los + nlos)) : say().trackNone;
}

/** What is told of each state that the track has. @param {StretchesAnswer} seen @returns {{state: TrackState, words: string}[]} */
function trackRows(seen) {
  const words = say();
  return TRACK_STATES.flatMap((name, k) => {
    const [m, s] = [seen.lengths_m[k], seen.times_s?.[k]];
    if (!(m > 0) && !(Number(s) > 0)) return [];
    const size = (/** @type {number} */ length, /** @type {number | null | undefined} */ time) => lengthWords(length) + (time === null || time === undefined ? "" : ` (${timeWords(time)})`);
    const parts = [`${words.trackStates[name]} ${size(m, s)}`];
    const n = seen.stretches.filter((stretch) => stretch.state === "nlos").length;
    if (name === "nlos" && n > 1) parts.push(words.trackLongest(n, size(seen.longest_without_m, seen.longest_without_s)));
    return [{ state: name, words: parts.join(", ") }];
  });
}

/** Shows the side view, unless that of a link is open. */
function showTrack() {
  const box = htmlById("track-drawer");
  const { places, seen } = track;
  box.hidden = !track.isOpen || linkPlace !== null || !seen || places.length === 0;
  buttonById("track-open").setAttribute("aria-pressed", String(track.isOpen));
  if (box.hidden || !seen) return;
  const hovers = seen.stretches.length > 0;
  setText(htmlById("track-verdict"), hovers ? trackShare(seen) : say().noMap);
  const steps = seen.every_m === null ? [] : [make("li", {}, say().trackSteps(meters(seen.every_m)))];
  const rows = trackRows(seen).map(({ state: name, words }) => make("li", {}, trackSwatch(name), words));
  htmlById("track-legend").replaceChildren(...(hovers ? [...rows, ...steps] : []));
  track.chart = trackChart(places, seen);
  htmlById("track-chart").replaceChildren(track.chart.svg);
  pointAlong(track.at);
  if (track.wantsRoom) makeRoomForTrack();
  track.wantsRoom = false;
}

/** A piece of the line of a state. @param {TrackState} name */
const trackSwatch = (name) => draw("svg", { class: "swatch", viewBox: "0 0 26 10", "aria-hidden": "true" }, draw("path", { class: `track-${name}`, d: "M0 5H26" }));

/**
 * The height of the user at a distance along the track.
 * @param {TrackPlace[]} places
 * @param {number} along
 */
function heightAlong(places, along) {
  const k = placeAfter(places, along);
  const [a, b] = [places[Math.max(0, k - 1)], places[k]];
  return b.along_m > a.along_m ? a.user_m + ((b.user_m - a.user_m) * (along - a.along_m)) / (b.along_m - a.along_m) : b.user_m;
}

/** Index of the first sample at a distance along the track, or of the last one. @param {TrackPlace[]} places @param {number} along */
function placeAfter(places, along) {
  let [low, high] = [0, places.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (places[middle].along_m < along) low = middle + 1;
    else high = middle;
  }
  return low;
}

/**
 * Draws the track from the side: what is below, and its stretches.
 * @param {TrackPlace[]} places
 * @param {StretchesAnswer} seen
 * @returns {Chart}
 */
function trackChart(places, seen) {
  const words = say();
  const width = Math.max(300, htmlById("track-chart").clientWidth);
  const long = Math.max(places[places.length - 1].along_m, 0.01);
  const known = places.flatMap(({ user_m, ground_m, roof_m }) => [user_m, ground_m ?? user_m, roof_m ?? user_m]);
  const [low, high] = known.reduce(([least, most], v) => [Math.min(least, v), Math.max(most, v)], [Infinity, -Infinity]);
  const span = Math.max(high - low, 1);
  const chart = makeChart({
    width, height: width < 480 ? 190 : 200,
    xRange: [0, long], yRange: [low - 0.06 * span, high + 0.12 * span],
    xName: words.trackAxis, yName: words.heightAboveDatum, label: seen.stretches.length > 0 ? trackShare(seen) : words.trackNone,
  });
  const { plot, x, y, svg } = chart;
  drawBelow(chart, places, "terrain", ({ ground_m }) => ground_m);
  drawBelow(chart, places, "building", ({ roof_m }) => roof_m);
  const line = (/** @type {number[][]} */ points) => `M${points.map(([m, z]) => `${x(m).toFixed(1)} ${y(z).toFixed(1)}`).join("L")}`;
  plot.append(draw("path", { class: "track-casing", d: line(places.map(({ along_m, user_m }) => [along_m, user_m])) }));
  for (const { along_m: [from, to], state: name } of seen.stretches) {
    const between = places.filter(({ along_m }) => along_m > from && along_m < to).map(({ along_m, user_m }) => [along_m, user_m]);
    const ends = [from, to].map((m) => [m, heightAlong(places, m)]);
    plot.append(draw("path", { class: `track-${name}`, d: line([ends[0], ...between, ends[1]]) }));
  }
  svg.setAttribute("tabindex", "0");
  return chart;
}

/**
 * Fills what is below a height that not all places have; between two samples it changes in the middle.
 * @param {Chart} chart
 * @param {TrackPlace[]} places
 * @param {'terrain' | 'building'} kind
 * @param {(place: TrackPlace) => number | null} heightOf
 */
function drawBelow({ plot, x, y, bottom }, places, kind, heightOf) {
  const middle = (/** @type {number} */ k) => (k < 0 ? places[0].along_m : k + 1 >= places.length ? places[places.length - 1].along_m : (places[k].along_m + places[k + 1].along_m) / 2);
  let top = "";
  let start = 0;
  places.forEach((place, k) => {
    const height = heightOf(place);
    if (height !== null) {
      if (top === "") start = k;
      // Ground is straight between samples, a roof has walls.
      top += kind === "terrain" ? `L${x(place.along_m).toFixed(1)} ${y(height).toFixed(1)}` : `L${x(middle(k - 1)).toFixed(1)} ${y(height).toFixed(1)}H${x(middle(k)).toFixed(1)}`;
    }
    if (top !== "" && (height === null || k + 1 === places.length)) {
      const last = height === null ? k - 1 : k;
      const [left, right] = kind === "terrain" ? [places[start].along_m, places[last].along_m] : [middle(start - 1), middle(last)];
      plot.append(draw("path", { class: kind, d: `M${x(left).toFixed(1)} ${bottom}${top}L${x(right).toFixed(1)} ${bottom}Z` }));
      if (kind === "terrain") plot.append(draw("path", { class: "terrain-top", d: `M${top.slice(1)}` }));
      top = "";
    }
  });
}

/** Points at a sample of the track, in the side view and on the map. @param {number | null} k */
function pointAlong(k) {
  const { chart, places, seen } = track;
  track.at = k !== null && places[k] ? k : null;
  const place = track.at === null ? null : places[track.at];
  const stretch = place && seen?.stretches.find(({ along_m: [from, to] }) => place.along_m >= from && place.along_m <= to);
  overlay.trackPlace = place;
  overlay.trackObstacle = stretch?.state === "nlos" ? stretch.obstacle : null;
  placeTrackPlace();
  if (!chart) return;
  for (const old of chart.plot.querySelectorAll(".pointed")) old.remove();
  if (!place) return;
  const [px, py] = [chart.x(place.along_m), chart.y(place.user_m)];
  const pointed = draw("g", { class: "pointed" }, draw("path", { class: "guide", d: `M${px} ${chart.top}V${chart.bottom}` }), draw("circle", { class: "on-ray", cx: px, cy: py, r: 4 }));
  chart.plot.append(pointed);
  const parts = placeOfTrack(place, stretch ?? null);
  const top = py - 52 < chart.top ? py + 14 : py - 50;
  parts.forEach((text, k) => chartLabel({ ...chart, plot: pointed }, px, top + 19 * k, text));
  setText(htmlById("spoken"), parts.join(" · "));
}

/** Where a place of the track is, and what is there. @param {TrackPlace} place @param {Stretch | null} stretch */
function placeOfTrack({ along_m, time_s, user_m, ground_m }, stretch) {
  const words = say();
  const height = ground_m === null ? `${meters(user_m)} ${words.kinds.amsl}` : `${meters(user_m - ground_m)} ${words.kinds.agl}`;
  const at = time_s === null ? lengthWords(along_m) : `${lengthWords(along_m)}, ${timeWords(time_s)}`;
  const hides = stretch?.state === "nlos" && stretch.obstacle ? blockedWords(stretch.obstacle) : "";
  return [`${at}: ${height}`, ...(stretch ? [hides || words.trackStates[stretch.state]] : [])];
}

function listenToTrack() {
  const box = htmlById("track-chart");
  buttonById("track-open").addEventListener("click", () => {
    toggleTrack(!track.isOpen, !track.isOpen);
  });
  buttonById("track-close").addEventListener("click", () => toggleTrack(false));
  box.addEventListener("pointermove", (event) => {
    const { chart } = track;
    if (!chart) return;
    const frame = chart.svg.getBoundingClientRect();
    const px = ((event.clientX - frame.left) / frame.width) * chart.svg.viewBox.baseVal.width;
    const long = track.places[track.places.length - 1].along_m;
    pointAlong(placeAfter(track.places, within((px - chart.left) / (chart.right - chart.left), 0, 1) * long));
  });
  box.addEventListener("pointerleave", () => pointAlong(null));
  box.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const far = event.shiftKey ? 100 : 10;
    pointAlong(within((track.at ?? 0) + step * far, 0, track.places.length - 1));
  });
}
