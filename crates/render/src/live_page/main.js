// @ts-check
// Starts the page: shows what is there at once, opens the scene in the worker, and ties changes to what follows them.

/** The address is written this long after the last change [ms]; browsers refuse writing it at every move. */
const ADDRESS_AFTER = 250;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let addressTimer;

/** Changes that need another map. @type {Set<Change>} */
const ASKS_MAP = new Set(["place", "uavs", "sight", "layer", "alone", "restored"]);
/** Whether the words on the page are about observers. */
let saysObservers = false;

/** @param {Change} change @param {number} since */
function follow(change, since) {
  if (ASKS_MAP.has(change)) wantMap(since);
  if (change === "selected" && state.layer === "one" && state.uavs.length > 1) wantMap(since);
  followFields(change);
  if (change === "uavs" || change === "restored") {
    makeMarks();
    makeUavList();
  }
  if (change !== "look" && change !== "view") showRoles();
  if (change === "look") showLook();
  if (change === "view") {
    placeOverlay();
    askCell();
    frame.drawSoon();
  } else if (change === "place" || change === "selected" || change === "uavs" || change === "sight" || change === "restored") {
    describeMarks();
    describeUavs();
    showHeight();
    showSight();
    placeOverlay();
    forgetSearch();
    markStaleCurve();
  } else if (change === "layer" || change === "alone") showSight();
  else if (change === "kept") {
    showKeptRows();
    askCompare();
  }
  if (change === "selected") {
    if (coverage.answer) showResults(coverage.answer);
    refreshLink();
    refreshTrack();
    void refreshCurve();
  }
  if (saveDialog.open) showSave();
  clearTimeout(addressTimer);
  addressTimer = setTimeout(writeAddress, ADDRESS_AFTER);
}

/** What was refused is read anew where its reason may be gone; what was typed for something else is forgotten. @param {Change} change */
function followFields(change) {
  if (change === "restored") fields.forEach(forgetField);
  else if (change === "selected" || change === "uavs" || (change === "place" && heightField.reason)) forgetField(heightField);
  if (change !== "sight" && change !== "look") return;
  for (const field of fields) if (field.reason) void readField(field);
}

/** Marks and words follow those who look: observers on the ground, or UAVs. */
function showRoles() {
  if (areObservers() !== saysObservers) {
    saysObservers = areObservers();
    showLook();
  } else if ((isInAir() || hasTrack()) && state.uavs.some((uav, k) => marks[k]?.classList.contains("observer") !== isObserver(uav))) {
    makeMarks();
    makeUavList();
  }
}

/** Everything that language and theme change. */
function showLook() {
  showTexts();
  showTheme();
  makeMarks();
  makeUavList();
  showHeight();
  showSight();
  showKeptRows();
  showSearchButtons();
  drawCurve();
  if (coverage.answer) showResults(coverage.answer);
  if (lastLink && linkPlace) showLink(lastLink);
  showTrack();
  showCursorHint();
  showAbout();
  placeOverlay();
  frame.drawSoon();
}

/** What limits the picture's truth, whose data it is, what made it. */
function showAbout() {
  const crs = facts.crs ? [`${facts.crs.label} · ${facts.crs.name}`] : [say().localCoordinates];
  const lines = [...facts.limits, ...(facts.attribution ? [facts.attribution] : []), ...crs, facts.program];
  htmlById("about").replaceChildren(...lines.map((line) => make("p", {}, line)));
  setText(htmlById("attribution"), facts.attribution ?? "");
}

/** @param {'engine' | 'unpack' | 'build'} step @param {number | null} share */
function showProgress(step, share) {
  const words = say();
  setText(htmlById("progress-words"), { engine: words.starting, unpack: words.unpacking, build: words.building }[step]);
  const bar = byId("progress-bar", HTMLProgressElement);
  if (share === null) bar.removeAttribute("value");
  else bar.value = share;
}

/** @param {unknown} error */
function showFailed(error) {
  htmlById("progress").classList.add("failed");
  htmlById("progress").hidden = false;
  byId("progress-bar", HTMLProgressElement).hidden = true;
  setText(htmlById("progress-words"), `${say().failed}: ${wordsOf(error)}`);
}

/** What a test or a bench may look at. */
const ready = start();
Object.assign(window, { skyshed: { state, facts, ready, idle }, skyshedTimes: times });

async function start() {
  const wrong = readAddress(location.hash.slice(1));
  const hasView = state.view !== null;
  saysObservers = areObservers();
  listeners.push(follow);
  new ResizeObserver(() => {
    measure();
    if (lastLink && linkPlace) showLink(lastLink);
    showTrack();
  }).observe(mapBox);
  measure();
  showLook();
  listenToMap();
  listenToPanel();
  listenToSheet();
  listenToBest();
  listenToKept();
  listenToSave();
  listenToTrack();
  listenToRest();
  showProgress("engine", null);
  try {
    // The first picture of the page comes before the engine's work.
    await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
    if (!WebAssembly.validate(WITH_VECTORS)) throw new Error(say().oldBrowser);
    const opened = await openScene(showProgress);
    painter.hand.setTone(new Uint8Array(opened.tone));
    showOpened(opened);
    await openTrack(!hasView);
    wantMap(performance.now());
    await idle();
    tellWrong(wrong);
  } catch (error) {
    showFailed(error);
  }
}

/** @param {Opened} opened */
function showOpened(opened) {
  htmlById("progress").hidden = true;
  document.documentElement.dataset.ready = "true";
  // What the scene does not have cannot be chosen.
  for (const option of selectById("height-kind").options) option.disabled = option.value === "roof" && facts.surface_only;
  for (const option of selectById("receivers").options) option.disabled = !opened.has_buildings && !["ground", "all", "air"].includes(option.value);
  showKeptRows();
  askCompare();
  placeOverlay();
  for (const field of fieldsInReading) void readField(field);
  frame.drawSoon();
}

/** The buttons over the map, the panels that open, and what follows the answers. */
function listenToRest() {
  buttonById("zoom-in").addEventListener("click", () => glideZoom(1.6));
  buttonById("zoom-out").addEventListener("click", () => glideZoom(1 / 1.6));
  buttonById("zoom-fit").addEventListener("click", glideToWhole);
  buttonById("link-close").addEventListener("click", closeLink);
  curveBox.addEventListener("toggle", () => void refreshCurve());
  window.addEventListener("hashchange", () => {
    if (location.hash.slice(1) === addressOf()) return;
    tellWrong(readAddress(location.hash.slice(1)));
    changed("restored");
    changed("kept");
    setView(currentView());
  });
  onCoverage.push((answer) => {
    showRoles();
    showResults(answer);
    describeMarks();
    describeUavs();
    settleNewcomer(answer);
    if (answer.uavs[state.selected]?.ok === false) askBelow();
    refreshLink();
    refreshTrack();
    askCell();
  });
  onRest.push(() => {
    showHeight();
    speakResult();
    askBelow();
    // The curve comes last: it makes way for any other question.
    if (state.kept.length > 0) askCompare();
    void refreshCurve();
    if (saveDialog.open) showSave();
  });
}
