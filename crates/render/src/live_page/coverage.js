// @ts-check
// The coverage follows the state: one map is under way at most, the newest state wins, and the last one ends exact.

/** How long the state has rested before what costs more is asked for [ms]. */
const REST = 300;
/** Times that are kept for benches. */
const MOST_TIMES = 1000;

/** Milliseconds from event to drawn mask. @type {number[]} */
const times = [];

const coverage = {
  /** The newest answer. @type {MapAnswer | null} */ answer: null,
  /** Whether a map is under way. */ isAsking: false,
  /** Whether the state has changed since the last request. */ isStale: false,
  /** When the newest change happened. */ since: 0,
  /** @type {string | null} */ digest: null,
  /** @type {ReturnType<typeof setTimeout> | undefined} */ restTimer: undefined,
  /** Counts changes, so that a late answer is told from the newest. */ version: 0,
  /** The sight of the newest answer. @type {Sight} */ sight: structuredClone(facts.start.sight),
  /** @type {(() => void)[]} */ idle: [],
};

/** Called with each answer, after the mask was handed to the painter. @type {((answer: MapAnswer) => void)[]} */
const onCoverage = [];
/** Called when the map has rested. @type {(() => void)[]} */
const onRest = [];

/** Asks for the map of the newest state. @param {number} since when the person acted */
function wantMap(since) {
  coverage.since = since;
  coverage.version += 1;
  coverage.digest = null;
  clearTimeout(coverage.restTimer);
  stopLong();
  if (!engine.opened) return;
  if (coverage.isAsking) coverage.isStale = true;
  else void sendMap();
}

async function sendMap() {
  coverage.isAsking = true;
  coverage.isStale = false;
  const { since } = coverage;
  const { layer, which } = shown();
  const { uavs, sight } = structuredClone({ uavs: state.uavs, sight: state.sight });
  /** @type {MapAnswer} */
  let answer;
  try {
    answer = await ask({ do: "map", uavs, sight, shown: { layer, which }, picture: true });
  } catch (error) {
    coverage.isAsking = false;
    if (coverage.isStale) void sendMap();
    else refuseSight(error);
    return;
  }
  coverage.isAsking = false;
  coverage.sight = sight;
  answer.uavs.forEach((seen, k) => {
    if (seen.ok) seen.asked = uavs[k];
  });
  // The worker goes on while this answer is drawn.
  if (coverage.isStale) void sendMap();
  coverage.answer = answer;
  if (layer === "who" && answer.picture && !answer.all.who) answer.all.who = countWho(answer.picture);
  painter.setMask(answer.picture && new Uint8Array(answer.picture), layer, answer.uavs.length);
  if (answer.picture) engine.worker?.postMessage({ do: "give_back", picture: answer.picture }, [answer.picture]);
  answer.picture = null;
  frame.drawMask(() => {
    if (times.length >= MOST_TIMES) times.shift();
    times.push(performance.now() - since);
  });
  for (const listener of onCoverage) listener(answer);
  if (!coverage.isAsking) coverage.restTimer = setTimeout(rest, REST);
}

/** Goes back to the sight of the map on screen where the engine refuses that of now, and says why. @param {unknown} error */
function refuseSight(error) {
  if (JSON.stringify(state.sight) === JSON.stringify(coverage.sight)) {
    showFailed(error);
    return;
  }
  state.sight = structuredClone(coverage.sight);
  notify(wordsOf(error));
  changed("restored");
}

/** Cells of classes 16 to 21 in a picture of who sees them. @param {ArrayBuffer} picture */
function countWho(picture) {
  const counts = new Uint32Array(256);
  for (const value of new Uint8Array(picture)) counts[value] += 1;
  return [...counts.subarray(16, 22)];
}

/** Asks for what only a resting map needs. */
async function rest() {
  const { version } = coverage;
  const isNewest = () => version === coverage.version;
  try {
    const { layer, which } = shown();
    const { digest } = await ask({ do: "digest", which: layer === "one" ? which : null });
    if (isNewest()) coverage.digest = digest;
  } catch (error) {
    notify(wordsOf(error));
  }
  if (isNewest()) for (const listener of onRest) listener();
}

/** Whether the last map and its track are exact and drawn, and all fields are read. */
const isSettled = () => coverage.answer !== null && !coverage.isAsking && !frame.isWaiting && fieldsInReading.size === 0 && !waitsForTrack();

/** Tells who waits, once all is settled. */
function settle() {
  if (coverage.idle.length > 0 && isSettled()) for (const resolve of coverage.idle.splice(0)) resolve();
}

/** Resolves when the last map and its track are exact and drawn, and all fields are read. @returns {Promise<void>} */
const idle = () => (isSettled() ? Promise.resolve() : new Promise((resolve) => coverage.idle.push(resolve)));
