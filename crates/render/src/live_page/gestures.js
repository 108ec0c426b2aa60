// @ts-check
// Pointer, wheel and keys on the map: UAVs are dragged, the ground moves the map, a click asks for a link.

/** A press that moves less is a click [px]. */
const CLICK_SLOP = { mouse: 4, pen: 8, touch: 12 };
/** A second click within this time and distance zooms. */
const DOUBLE_CLICK = { ms: 320, px: 24 };

/**
 * @typedef {{id: number, startX: number, startY: number, x: number, y: number, hasMoved: boolean, slop: number,
 *   drags: {k: number, dx: number, dy: number} | null}} Press `drags`: which UAV, and where it was grabbed
 */

/** What is pressed, by pointer. @type {Map<number, Press>} */
const presses = new Map();
const lastClick = { at: -Infinity, x: 0, y: 0 };

/** Position of an event on the map [CSS px]. @param {{clientX: number, clientY: number}} event @returns {[number, number]} */
function onMap(event) {
  const box = mapBox.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

/** The UAV whose mark an event is on, or null. @param {Event} event */
function markOf(event) {
  const mark = event.target instanceof Element ? event.target.closest(".mark") : null;
  return mark instanceof HTMLElement ? Number(mark.dataset.k) : null;
}

/** @param {PointerEvent} event */
function press(event) {
  if (event.button !== 0) return;
  const [x, y] = onMap(event);
  const k = markOf(event);
  const drags = k === null ? null : { k, dx: x - pxOfX(state.uavs[k].x), dy: y - pxOfY(state.uavs[k].y) };
  const slop = event.pointerType === "mouse" ? CLICK_SLOP.mouse : event.pointerType === "pen" ? CLICK_SLOP.pen : CLICK_SLOP.touch;
  presses.set(event.pointerId, { id: event.pointerId, startX: x, startY: y, x, y, hasMoved: false, slop, drags });
  mapBox.setPointerCapture(event.pointerId);
  hold(k);
  forgetHint();
  if (k !== null) {
    select(k);
    marks[k].focus({ preventScroll: true });
    // The browser would move the focus to the map.
    event.preventDefault();
  }
}

/** @param {PointerEvent} event */
function drag(event) {
  const since = performance.now();
  const [x, y] = onMap(event);
  const held = presses.get(event.pointerId);
  if (!held) {
    if (event.pointerType === "touch") return;
    pointAt(x, y);
    hover(markOf(event));
    return;
  }
  if (!held.hasMoved && Math.hypot(x - held.startX, y - held.startY) < held.slop) return;
  const [fromX, fromY] = held.hasMoved ? [held.x, held.y] : [held.startX, held.startY];
  held.hasMoved = true;
  if (held.drags) {
    const { k, dx, dy } = held.drags;
    mapBox.classList.add("dragging");
    if (!state.uavs[k]) return;
    moveUav(k, placeX(x - dx), placeY(y - dy), since);
    readUav(state.uavs[k]);
  } else {
    const other = [...presses.values()].find((press) => press !== held && !press.drags);
    if (other) pinch(other, [fromX, fromY], [x, y]);
    else panBy(x - fromX, y - fromY);
    mapBox.classList.add("panning");
  }
  Object.assign(held, { x, y });
}

/** One finger of two has moved: their middle moves the map, their distance zooms it. */
function pinch(/** @type {Press} */ fixed, /** @type {[number, number]} */ from, /** @type {[number, number]} */ to) {
  const apart = (/** @type {[number, number]} */ [x, y]) => Math.max(1, Math.hypot(x - fixed.x, y - fixed.y));
  panBy((to[0] - from[0]) / 2, (to[1] - from[1]) / 2);
  zoomAbout((to[0] + fixed.x) / 2, (to[1] + fixed.y) / 2, apart(to) / apart(from));
  fixed.hasMoved = true;
}

/** @param {PointerEvent} event */
function release(event) {
  const held = presses.get(event.pointerId);
  if (!held) return;
  presses.delete(event.pointerId);
  if (presses.size === 0) mapBox.classList.remove("dragging", "panning");
  // What is under the pointer now, which a finger that went away has not.
  if (event.pointerType !== "touch") pointAt(...onMap(event));
  else if (held.hasMoved || held.drags) pointAway();
  if (event.type === "pointercancel" || held.hasMoved || held.drags) return;
  const now = performance.now();
  const isDouble = now - lastClick.at < DOUBLE_CLICK.ms && Math.hypot(held.x - lastClick.x, held.y - lastClick.y) < DOUBLE_CLICK.px;
  if (isDouble) {
    // The first click of a double one asked for a link that nobody wants.
    lastClick.at = -Infinity;
    closeLink();
    glideZoom(2, held.x, held.y);
  } else {
    Object.assign(lastClick, { at: now, x: held.x, y: held.y });
    openLink(placeX(held.x), placeY(held.y));
    // A finger does not hover.
    pointAt(held.x, held.y);
  }
}

/** Turns of the wheel that make a step of height [px]. */
const WHEEL_STEP = 40;
let wheelRest = 0;

/** @param {WheelEvent} event */
function turnWheel(event) {
  const since = performance.now();
  event.preventDefault();
  forgetHint();
  const px = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : event.deltaMode === WheelEvent.DOM_DELTA_PAGE ? 400 : 1);
  const k = markOf(event);
  if (k === null || event.ctrlKey) {
    const [x, y] = onMap(event);
    zoomAbout(x, y, Math.exp(-within(px, -300, 300) * (event.ctrlKey ? 0.01 : 0.0016)));
    return;
  }
  hold(k);
  select(k);
  wheelRest -= px;
  const steps = Math.trunc(wheelRest / WHEEL_STEP);
  wheelRest -= steps * WHEEL_STEP;
  if (steps !== 0) stepHeight(k, steps * (event.shiftKey ? 10 : 1), since);
}

/** Raises a UAV by so many steps, which are larger higher up. @param {number} k @param {number} steps @param {number} [since] */
function stepHeight(k, steps, since) {
  const { kind, m } = state.uavs[k].height;
  const step = m < 30 ? 1 : m < 150 ? 2 : 5;
  const least = kind === "amsl" ? -Infinity : 0;
  setHeight(k, { kind, m: Math.max(least, Math.round(m / step) * step + steps * step) }, since);
}

/** @param {KeyboardEvent} event */
function pressKey(event) {
  if (event.altKey || event.ctrlKey || event.metaKey) return;
  const since = performance.now();
  const far = event.shiftKey ? 10 : 1;
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  const k = markOf(event);
  if (way && k !== null) {
    const { x, y } = state.uavs[k];
    select(k);
    moveUav(k, x + way[0] * far * grid.cell_width, y + way[1] * far * grid.cell_height, since);
    bringIntoView(state.uavs[k].x, state.uavs[k].y);
  } else if (way) {
    panBy(-way[0] * 40 * (far > 1 ? 4 : 1), way[1] * 40 * (far > 1 ? 4 : 1));
    pointAt(screenSize.width / 2, screenSize.height / 2);
  } else if (k !== null && (event.key === "PageUp" || event.key === "PageDown")) {
    stepHeight(k, event.key === "PageUp" ? far : -far, since);
  } else if (k !== null && (event.key === "Delete" || event.key === "Backspace")) {
    removeUav(k);
    marks[state.selected].focus({ preventScroll: true });
  } else if (event.key === "+" || event.key === "=") glideZoom(1.5);
  else if (event.key === "-") glideZoom(1 / 1.5);
  else if (event.key === "0") glideToWhole();
  else if (event.key === "Escape") closeLink();
  else if (event.key === "Enter" && event.target === mapBox) openLink(currentView().x, currentView().y);
  else return;
  forgetHint();
  event.preventDefault();
}

/** How long the pointer rests on a UAV before it is shown alone [ms]: whoever grabs it wants to see all. */
const ALONE_AFTER = 600;
/** The UAV under the pointer, and the one that was pressed or turned and whose mark the pointer has not left since. */
const hovering = {
  /** @type {number | null} */ k: null,
  /** @type {number | null} */ held: null,
  /** @type {ReturnType<typeof setTimeout> | undefined} */ timer: undefined,
};

/** The pointer is on the mark of a UAV, or on none: if it rests there, the UAV is shown alone. @param {number | null} k */
function hover(k) {
  if (k !== hovering.held) hovering.held = null;
  if (k === hovering.k) return;
  hovering.k = k;
  clearTimeout(hovering.timer);
  showAlone(null);
  if (k === null || hovering.held !== null) return;
  hovering.timer = setTimeout(() => {
    // It would end a search.
    if (presses.size === 0 && engine.long.size === 0) showAlone(k);
  }, ALONE_AFTER);
}

/** A UAV is acted upon: it is not shown alone before the pointer has left it. @param {number | null} k */
function hold(k) {
  clearTimeout(hovering.timer);
  Object.assign(hovering, { k, held: k });
  showAlone(null);
}

/** Nobody needs the hint any more. */
function forgetHint() {
  overlay.isUsed = true;
  hint.hidden = true;
}

function listenToMap() {
  mapBox.addEventListener("pointerdown", press);
  mapBox.addEventListener("pointermove", drag);
  mapBox.addEventListener("pointerup", release);
  mapBox.addEventListener("pointercancel", release);
  mapBox.addEventListener("pointerleave", (event) => {
    if (event.pointerType === "touch") return;
    pointAway();
    hover(null);
  });
  mapBox.addEventListener("wheel", turnWheel, { passive: false });
  mapBox.addEventListener("keydown", pressKey);
  mapBox.addEventListener("focus", () => {
    if (mapBox.matches(":focus-visible")) pointAt(screenSize.width / 2, screenSize.height / 2);
  });
  mapBox.addEventListener("click", (event) => {
    // A key on a mark; pointers have selected already.
    const k = markOf(event);
    if (k !== null) select(k);
  });
  // Safari pinches on a trackpad by events of its own.
  let lastScale = 1;
  mapBox.addEventListener("gesturestart", (event) => {
    event.preventDefault();
    lastScale = 1;
  });
  mapBox.addEventListener("gesturechange", (event) => {
    event.preventDefault();
    if (presses.size > 0) return;
    const { scale = 1, clientX, clientY } = /** @type {MouseEvent & {scale?: number}} */ (event);
    const [x, y] = onMap({ clientX, clientY });
    zoomAbout(x, y, scale / lastScale);
    lastScale = scale;
  });
}
