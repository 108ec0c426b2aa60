// @ts-check
// The best place near the selected UAV: searched within a circle on request, with progress, and cancelled by any change.

const bestBox = byId("best", HTMLDetailsElement);
const bestStatus = htmlById("best-status");
const bestRadius = makeField("search_radius", ["best-radius"], (radius_m) => {
  searchRadius = radius_m;
  forgetSearch();
}, () => [fieldText(searchRadius)]);
const bestStart = buttonById("best-start");
const bestGo = buttonById("best-go");

/** How far around it: a tenth of the map to begin with, in round meters. */
let searchRadius = roundLength((Math.min(X_MAX - grid.x_min, grid.y_max - Y_MIN) * grid.meters_per_unit) / 8);
/** Which UAV is searched for, and what it sees now; null while nothing is searched. @type {{which: number, los: number} | null} */
let search = null;

/** Shows the circle while the panel is open. */
function showSearchCircle() {
  const { x, y } = selectedUav();
  overlay.search = bestBox.open ? { x, y, radius_m: searchRadius } : null;
  if (!bestBox.open) overlay.best = null;
  placeLines();
}

async function startSearch() {
  if (search) {
    stopLong();
    return;
  }
  // What was typed last is read first.
  if (fieldsInReading.has(bestRadius)) await idle();
  const which = state.selected;
  const seen = coverage.answer?.uavs[which];
  if (!engine.opened || bestRadius.reason) return;
  search = { which, los: seen?.ok && !seen.reason ? seen.los : -1 };
  overlay.best = null;
  showSearchCircle();
  showSearch(null);
  try {
    /** @type {BestAnswer} */
    const answer = await ask({ do: "best", which, radius_m: searchRadius }, showSearch);
    showSearch({ ...answer, done: true });
  } catch (error) {
    setText(bestStatus, wordsOf(error));
    byId("best-bar", HTMLProgressElement).hidden = true;
  }
  search = null;
  showSearchButtons();
}

/** @param {BestAnswer | null} answer */
function showSearch(answer) {
  if (!search) return;
  const { los } = search;
  const words = say();
  const best = answer?.best ?? null;
  overlay.best = best;
  placeLines();
  const bar = byId("best-bar", HTMLProgressElement);
  bar.hidden = answer?.done === true;
  bar.value = answer?.share ?? 0;
  if (!answer?.done) setText(bestStatus, words.bestRunning(percent(Math.round(100 * (answer?.share ?? 0)), 100), grouped(answer?.tried ?? 0)));
  else if (!best) setText(bestStatus, answer.stopped ? words.stopped : words.bestNone);
  else if (best.los <= los) setText(bestStatus, words.bestSame);
  else {
    setText(bestStatus, words.bestFound(percent(best.los, best.receivers), words.more(points(best.los - Math.max(0, los), best.receivers))));
  }
  bestGo.hidden = !(best && best.los > los);
  showSearchButtons();
}

function showSearchButtons() {
  setText(bestStart, search ? say().cancel : say().bestStart);
}

/** Any change of the question ends the search and takes its answer away. */
function forgetSearch() {
  if (search) stopLong();
  overlay.best = null;
  bestGo.hidden = true;
  setText(bestStatus, "");
  showSearchCircle();
}

function listenToBest() {
  showField(bestRadius);
  bestBox.addEventListener("toggle", () => {
    if (!bestBox.open && search) stopLong();
    showSearchCircle();
  });
  bestStart.addEventListener("click", () => void startSearch());
  bestGo.addEventListener("click", () => {
    const { best } = overlay;
    if (!best) return;
    moveUav(state.selected, best.x, best.y);
    bringIntoView(best.x, best.y);
  });
}
