// @ts-check
// What lies over the map: UAVs, range circles, the link and its obstruction, scale bar, the hint for newcomers.

const marksBox = htmlById("marks");
const lines = byId("lines", SVGSVGElement);
const hint = htmlById("hint");

/** Marks in the order of the UAVs. @type {HTMLButtonElement[]} */
const marks = [];

/** What else is drawn over the map, and by whom: places in units of the scene. */
const overlay = {
  /** @type {LinkSeen | null} */ link: null,
  /** The circle that is searched. @type {{x: number, y: number, radius_m: number} | null} */ search: null,
  /** The best place so far. @type {Candidate | null} */ best: null,
  /** The place of the track that is pointed at, and what hides it. @type {TrackPlace | null} */ trackPlace: null,
  /** @type {Stretch['obstacle']} */ trackObstacle: null,
  /** Whether somebody has done anything on the map. */ isUsed: false,
};

/** Makes the marks anew when UAVs, their names or the language changed. */
function makeMarks() {
  const focused = marks.findIndex((mark) => mark === document.activeElement);
  for (const mark of marks.splice(0)) mark.remove();
  state.uavs.forEach((uav, k) => {
    const color = uavColor(k);
    const badge = make("b", { class: "badge", style: `background:${hex(color)};color:${inkOn(color)}` }, String(k + 1));
    const words = /^\d+$/.test(uav.id) ? [] : [make("span", { class: "name" }, uav.id)];
    const tag = make("span", { class: "tag" }, badge, ...words, make("span", { class: "height" }));
    const mark = make("button", { class: `mark${isObserver(uav) ? " observer" : ""}`, type: "button", id: `mark-${k + 1}`, "data-k": k }, symbolOf(uav, k), tag);
    marks.push(mark);
  });
  marksBox.append(...marks);
  if (focused >= 0) marks[Math.min(focused, marks.length - 1)].focus({ preventScroll: true });
  describeMarks();
}

/** Brings heights, selection and failures of the marks up to date. */
function describeMarks() {
  const seen = coverage.answer?.uavs ?? [];
  marks.forEach((mark, k) => {
    const uav = state.uavs[k];
    const answer = seen[k];
    const height = mark.querySelector(".height");
    if (height) setText(height, heightShort(uav.height));
    mark.classList.toggle("selected", k === state.selected && state.uavs.length > 1);
    mark.classList.toggle("failed", answer?.ok === false);
    mark.setAttribute("aria-pressed", String(k === state.selected));
    const share = answer?.ok && !answer.reason ? percent(answer.los, answer.receivers) : "";
    mark.setAttribute("aria-label", say().markLabel(uavName(uav), heightWords(uav.height), share));
    mark.title = answer?.ok === false ? `${sayOf(uav).cannotHover}: ${answer.words}` : "";
  });
}

/** Puts everything where the view has it. */
function placeOverlay() {
  marks.forEach((mark, k) => {
    const { x, y } = state.uavs[k];
    mark.style.transform = `translate(${pxOfX(x).toFixed(1)}px, ${pxOfY(y).toFixed(1)}px)`;
    mark.style.zIndex = String(k === state.selected ? 100 : k);
  });
  placeTags();
  placeHint();
  placeTrack();
  placeLines();
  placeScale();
}

/** Where a tag can stand, best first: its corner from the middle of the mark [px] by the tag's width. */
const TAG_SIDES = /** @type {[string, (width: number) => [number, number]][]} */ ([
  ["", () => [22, -13]], ["tag-left", (width) => [-22 - width, -13]], ["tag-above", (width) => [-width / 2, -50]], ["tag-below", (width) => [-width / 2, 24]],
]);
const TAG_HEIGHT = 26;
/** Half of a mark as it is kept free of tags [px]. */
const MARK_ROOM = 21;

/** Puts each tag where it lies on no other mark or tag; without such a place it is left out. The selected UAV chooses first. */
function placeTags() {
  const centers = state.uavs.map(({ x, y }) => [pxOfX(x), pxOfY(y)]);
  /** Rectangles that are taken: left, top, right, bottom. @type {number[][]} */
  const taken = centers.map(([x, y]) => [x - MARK_ROOM, y - MARK_ROOM, x + MARK_ROOM, y + MARK_ROOM]);
  const order = [state.selected, ...state.uavs.keys()].filter((k, j) => marks[k] && (j === 0 || k !== state.selected));
  for (const k of order) {
    const { id, height } = state.uavs[k];
    const [x, y] = centers[k];
    // Measured before it is shown: system fonts are about this wide.
    const width = 44 + 7.2 * heightShort(height).length + (/^\d+$/.test(id) ? 0 : Math.min(170, 8 * id.length));
    const boxes = TAG_SIDES.map(([, corner]) => {
      const [dx, dy] = corner(width);
      return [x + dx, y + dy, x + dx + width, y + dy + TAG_HEIGHT];
    });
    const isFree = (/** @type {number[]} */ [left, top, right, bottom], /** @type {boolean} */ mustFit) =>
      (!mustFit || (left > 0 && top > 0 && right < screenSize.width && bottom < screenSize.height)) &&
      taken.every(([l, t, r, b], j) => j === k || right <= l || left >= r || bottom <= t || top >= b);
    let side = boxes.findIndex((box) => isFree(box, true));
    if (side < 0) side = boxes.findIndex((box) => isFree(box, false));
    marks[k].classList.toggle("tag-none", side < 0);
    TAG_SIDES.forEach(([name], j) => name && marks[k].classList.toggle(name, j === side));
    if (side >= 0) taken.push(boxes[side]);
  }
}

/** The hint stands above the selected UAV until something is done on the map. */
function placeHint() {
  hint.hidden = overlay.isUsed || !engine.opened;
  if (hint.hidden) return;
  const { x, y } = selectedUav();
  const below = pxOfY(y) < 110;
  hint.classList.toggle("below", below);
  hint.style.transform = `translate(${within(pxOfX(x), 80, Math.max(80, screenSize.width - 80)).toFixed(1)}px, ${pxOfY(y).toFixed(1)}px)`;
}

const mapClip = draw("rect");
lines.append(draw("clipPath", { id: "map-clip" }, mapClip));
const lineParts = {
  frame: draw("rect", { class: "map-frame" }),
  circles: draw("g", { class: "range", "clip-path": "url(#map-clip)" }),
  track: draw("g", { class: "track" }),
  search: draw("circle", { class: "search" }),
  best: draw("path", { class: "best", d: "M0 -15L4.2 -5.2L14.6 -4.3L6.7 2.6L9.1 12.7L0 7.3L-9.1 12.7L-6.7 2.6L-14.6 -4.3L-4.2 -5.2Z" }),
  casing: draw("line", { class: "casing" }),
  clear: draw("line", { class: "clear" }),
  blocked: draw("line", { class: "blocked" }),
  receiver: draw("circle", { class: "receiver", r: 6 }),
  trackPlace: draw("circle", { class: "receiver", r: 6 }),
  trackObstacle: draw("path", { class: "obstruction", d: "M0 -10L10 0L0 10L-10 0Z" }),
  obstruction: draw("path", { class: "obstruction", id: "obstruction", d: "M0 -10L10 0L0 10L-10 0Z" }),
};
lines.append(...Object.values(lineParts));

/** Sets attributes of a part, or hides it. @param {SVGElement} part @param {Record<string, number | string> | null} attributes */
function place(part, attributes) {
  const display = attributes ? "" : "none";
  if (part.style.display !== display) part.style.display = display;
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (part.getAttribute(name) !== String(value)) part.setAttribute(name, String(value));
  }
}

function placeLines() {
  const { link, search, best } = overlay;
  const px = currentView().scale / grid.meters_per_unit;
  const at = (/** @type {{x: number, y: number}} */ p) => ({ x: pxOfX(p.x), y: pxOfY(p.y) });
  const corner = at({ x: grid.x_min, y: grid.y_max });
  const mapFrame = { ...corner, width: pxOfX(X_MAX) - corner.x, height: pxOfY(Y_MIN) - corner.y };
  place(lineParts.frame, mapFrame);
  place(mapClip, mapFrame);

  const radius = state.sight.radius;
  const { circles } = lineParts;
  const wanted = radius === null ? 0 : state.uavs.length;
  while (circles.childElementCount > wanted) circles.lastElementChild?.remove();
  while (circles.childElementCount < wanted) circles.append(draw("circle"));
  state.uavs.slice(0, wanted).forEach((uav, k) => {
    const { x: cx, y: cy } = at(uav);
    place(/** @type {SVGElement} */ (circles.children[k]), { cx, cy, r: Math.max(0, radius ?? 0) * px });
  });

  const center = search && at(search);
  place(lineParts.search, search && center && { cx: center.x, cy: center.y, r: search.radius_m * px });
  const star = best && at(best);
  place(lineParts.best, star && { transform: `translate(${star.x} ${star.y})` });

  const from = link && at(link.uav);
  const to = link && at(link.receiver);
  const clear = link ? clearPart(link) : 1;
  const met = from && to && { x: from.x + clear * (to.x - from.x), y: from.y + clear * (to.y - from.y) };
  const stop = link?.obstruction ? at(link.obstruction) : null;
  const between = (/** @type {{x: number, y: number} | null} */ a, /** @type {{x: number, y: number} | null} */ b) => a && b && { x1: a.x, y1: a.y, x2: b.x, y2: b.y };
  place(lineParts.casing, between(from, to));
  place(lineParts.clear, between(from, met));
  place(lineParts.blocked, link?.los ? null : between(met, to));
  place(lineParts.receiver, to && { cx: to.x, cy: to.y });
  place(lineParts.obstruction, stop ? { transform: `translate(${stop.x} ${stop.y})` } : null);
}

/** The lines of the track and of its stretches as paths in pixels. @param {(x: number) => number} ofX @param {(y: number) => number} ofY */
function trackPaths(ofX, ofY) {
  const path = (/** @type {number[][]} */ places) => `M${places.map(([x, y]) => `${ofX(x).toFixed(1)} ${ofY(y).toFixed(1)}`).join("L")}`;
  const whole = facts.tracks.filter(({ vertices }) => vertices.length > 1).map(({ vertices }) => path(vertices.map(([x, y]) => [x, y]))).join("");
  return { whole, stretches: (track.seen?.stretches ?? []).map(({ state: name, places }) => ({ name, d: path(places) })) };
}

/** Puts the lines of the track where the view has them. */
function placeTrack() {
  if (!hasTrack()) return;
  const { whole, stretches } = trackPaths(pxOfX, pxOfY);
  const wanted = [["track-casing", whole], ...(stretches.length > 0 ? [] : [["track-unknown", whole]]), ...stretches.map(({ name, d }) => [`track-${name}`, d])];
  const { track: group } = lineParts;
  while (group.childElementCount > wanted.length) group.lastElementChild?.remove();
  while (group.childElementCount < wanted.length) group.append(draw("path"));
  wanted.forEach(([kind, d], k) => place(/** @type {SVGElement} */ (group.children[k]), { class: kind, d }));
  placeTrackPlace();
}

/** Puts the marks of what is pointed at in the side view of the track. */
function placeTrackPlace() {
  const { trackPlace, trackObstacle } = overlay;
  place(lineParts.trackPlace, trackPlace && { cx: pxOfX(trackPlace.x), cy: pxOfY(trackPlace.y) });
  place(lineParts.trackObstacle, trackObstacle && { transform: `translate(${pxOfX(trackObstacle.x)} ${pxOfY(trackObstacle.y)})` });
}

/** A scale bar of a round length of at most 120 pixels. */
function placeScale() {
  const perMeter = currentView().scale / grid.meters_per_unit;
  const long = roundLength(120 / perMeter);
  htmlById("scale-bar").style.width = `${(long * perMeter).toFixed(1)}px`;
  setText(htmlById("scale-length"), long >= 1000 ? `${number(long / 1000, 3)} km` : `${number(long, 3)} m`);
}
