// @ts-check
// The part of the map on screen: from places to pixels and back, and the drawing of one frame.

const mapBox = htmlById("map");
/** @type {HTMLCanvasElement} */
let mapCanvas = byId("canvas", HTMLCanvasElement);

/** Size of the map on screen [CSS px], and device pixels per CSS pixel. */
const screenSize = { width: 0, height: 0, pxPerPoint: 1 };

/** No cell is larger than this on screen [CSS px]. */
const LARGEST_CELL = 160;
/** Around the whole map [CSS px]. */
const MARGIN = 16;

/** Pixels per unit at which the whole map fits. */
function fittingScale() {
  const { width, height } = screenSize;
  const room = (/** @type {number} */ size) => Math.max(size - 2 * MARGIN, size / 2, 1);
  return Math.min(room(width) / (X_MAX - grid.x_min), room(height) / (grid.y_max - Y_MIN));
}

/** @returns {View} the view of the whole map */
const wholeView = () => ({ x: (grid.x_min + X_MAX) / 2, y: (Y_MIN + grid.y_max) / 2, scale: fittingScale() });

/** The view; that of the whole map until another is chosen, kept once the map has a size. */
function currentView() {
  const view = state.view ?? wholeView();
  if (screenSize.width > 0) state.view = view;
  return view;
}

/** Pixel of an x, from the left. @param {number} x */
const pxOfX = (x) => screenSize.width / 2 + (x - currentView().x) * currentView().scale;
/** Pixel of a y, from the top. @param {number} y */
const pxOfY = (y) => screenSize.height / 2 - (y - currentView().y) * currentView().scale;
const placeX = (/** @type {number} */ px) => currentView().x + (px - screenSize.width / 2) / currentView().scale;
const placeY = (/** @type {number} */ py) => currentView().y - (py - screenSize.height / 2) / currentView().scale;

/** How far the middle of the screen may be from the map, in parts of the screen: what lies over the map leaves it less room. */
const BEYOND = 0.4;

/** Shows another part; the map stays on screen, its scale within reason. @param {View} view */
function setView(view) {
  const largest = LARGEST_CELL / Math.min(grid.cell_width, grid.cell_height);
  const smallest = fittingScale() / 2;
  const scale = within(view.scale, smallest, Math.max(largest, smallest));
  const [beyondX, beyondY] = [screenSize.width, screenSize.height].map((size) => (BEYOND * size) / scale);
  state.view = {
    x: within(view.x, grid.x_min - beyondX, X_MAX + beyondX),
    y: within(view.y, Y_MIN - beyondY, grid.y_max + beyondY),
    scale,
  };
  changed("view");
}

/** Moves the map. @param {number} dx [px] @param {number} dy [px] */
function panBy(dx, dy) {
  const { x, y, scale } = currentView();
  setView({ x: x - dx / scale, y: y + dy / scale, scale });
}

/**
 * Zooms so that the place at a pixel stays there.
 * @param {number} px
 * @param {number} py
 * @param {number} factor
 */
function zoomAbout(px, py, factor) {
  const [x, y] = [placeX(px), placeY(py)];
  const { scale } = currentView();
  setView({ ...currentView(), scale: scale * factor });
  const now = currentView().scale;
  setView({ x: x - (px - screenSize.width / 2) / now, y: y + (py - screenSize.height / 2) / now, scale: now });
}

/** Moves the map so that a place is on screen. @param {number} x @param {number} y */
function bringIntoView(x, y) {
  const [px, py] = [pxOfX(x), pxOfY(y)];
  const [edgeX, edgeY] = [Math.min(48, screenSize.width / 4), Math.min(48, screenSize.height / 4)];
  const dx = within(px, edgeX, screenSize.width - edgeX) - px;
  const dy = within(py, edgeY, screenSize.height - edgeY) - py;
  if (dx !== 0 || dy !== 0) panBy(dx, dy);
}

/**
 * Moves the map, and zooms out if there is no other way, so that two places are within a part of the screen.
 * @param {{x: number, y: number}[]} places
 * @param {{left: number, right: number, top: number, bottom: number}} room [px]
 */
function glideToPlaces(places, { left, right, top, bottom }) {
  const view = currentView();
  const [xs, ys] = [places.map(({ x }) => x), places.map(({ y }) => y)];
  const span = (/** @type {number[]} */ values) => (Math.max(...values) - Math.min(...values)) * view.scale;
  const scale = view.scale * Math.min(1, Math.max(1, right - left) / span(xs), Math.max(1, bottom - top) / span(ys));
  // How far pixels have to move to be between two others.
  const shift = (/** @type {number[]} */ at, /** @type {number} */ low, /** @type {number} */ high) =>
    Math.max(0, low - Math.min(...at)) + Math.min(0, high - Math.max(...at));
  const dx = shift(xs.map((x) => screenSize.width / 2 + (x - view.x) * scale), left, right);
  const dy = shift(ys.map((y) => screenSize.height / 2 - (y - view.y) * scale), top, bottom);
  if (scale < view.scale || dx !== 0 || dy !== 0) glideTo({ x: view.x - dx / scale, y: view.y + dy / scale, scale });
}

/** @type {number | undefined} */
let glide;

/** Glides to another view, or jumps where the person prefers no motion. @param {(t: number) => void} step from 0 to 1 */
function glideOver(step) {
  if (glide !== undefined) cancelAnimationFrame(glide);
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) {
    step(1);
    return;
  }
  const start = performance.now();
  const next = () => {
    const t = Math.min(1, (performance.now() - start) / 220);
    glide = t < 1 ? requestAnimationFrame(next) : undefined;
    step(t * (2 - t));
  };
  next();
}

/** Zooms smoothly about a pixel; the middle without one. @param {number} factor */
function glideZoom(factor, px = screenSize.width / 2, py = screenSize.height / 2) {
  let reached = 1;
  glideOver((t) => {
    const wanted = factor ** t;
    zoomAbout(px, py, wanted / reached);
    reached = wanted;
  });
}

const glideToWhole = () => glideTo(wholeView());

/** @param {View} to */
function glideTo(to) {
  const from = currentView();
  const between = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ t) => a + (b - a) * t;
  glideOver((t) => setView({ x: between(from.x, to.x, t), y: between(from.y, to.y, t), scale: from.scale * (to.scale / from.scale) ** t }));
}

/**
 * The window of a view for a picture of a size.
 * @param {View} view
 * @param {number} width [px of the picture]
 * @param {number} height
 * @param {number} pxPerPoint
 * @param {number} [stripePx]
 * @returns {MapWindow}
 */
function windowOf(view, width, height, pxPerPoint, stripePx = 10 * pxPerPoint) {
  const scale = view.scale * pxPerPoint;
  return {
    col: (view.x - width / 2 / scale - grid.x_min) / grid.cell_width,
    row: (grid.y_max - view.y - height / 2 / scale) / grid.cell_height,
    colsPerPx: 1 / scale / grid.cell_width,
    rowsPerPx: 1 / scale / grid.cell_height,
    width,
    height,
    pxPerPoint,
    stripePx,
  };
}

/** The painter of the map, with what it paints. */
const painter = {
  /** @type {Painter} */ hand: startPainter(),
  /** @type {Layer} */ layer: "one",
  nUavs: 1,
  /** What the table of looks was made for. */ looksKey: "",

  /** @param {Uint8Array | null} mask @param {Layer} layer @param {number} nUavs */
  setMask(mask, layer, nUavs) {
    Object.assign(this, { layer, nUavs });
    this.hand.setMask(mask);
    this.useTheme(state.theme);
  },
  /** @param {Theme} theme */
  useTheme(theme) {
    const key = `${theme} ${this.layer} ${this.nUavs}`;
    if (key === this.looksKey) return;
    this.looksKey = key;
    this.hand.setLooks(lookTable(theme, this.layer, this.nUavs), BACKDROPS[theme]);
  },
};

/** WebGL where a graphics card computes it; `?paint=canvas` and `?paint=webgl` choose. @returns {Painter} */
function startPainter() {
  const wanted = new URLSearchParams(location.search).get("paint");
  const gl = wanted === "canvas" ? null : glPainter(mapCanvas, wanted === "webgl");
  if (gl) return gl;
  // A canvas that once had another kind of context gives no plain one.
  const fresh = /** @type {HTMLCanvasElement} */ (mapCanvas.cloneNode());
  mapCanvas.replaceWith(fresh);
  mapCanvas = fresh;
  return canvasPainter(mapCanvas);
}

/** Masks that come faster than this follow each other [ms]. */
const DRAFT_MS = 120;

/** Draws at most once in each frame of the screen: at once if this one has no drawing yet, with the next otherwise. */
const frame = {
  isWaiting: false,
  hasDrawn: false,
  /** Whether what is shown was painted with fewer samples. */ isDraft: false,
  /** When the last mask came. */ lastMask: -Infinity,
  /** @type {ReturnType<typeof setTimeout> | undefined} */ finishTimer: undefined,
  /** @type {(() => void)[]} */ after: [],

  /** @param {() => void} [after] called when it is drawn */
  drawSoon(after) {
    if (after) this.after.push(after);
    this.isWaiting = true;
    if (!this.hasDrawn) this.draw();
  },
  /** A mask has come: of masks that follow each other each is a draft, and the last one is painted in full. */
  drawMask(/** @type {() => void} */ after) {
    const now = performance.now();
    this.isDraft = now - this.lastMask < DRAFT_MS;
    this.lastMask = now;
    clearTimeout(this.finishTimer);
    if (this.isDraft) {
      this.finishTimer = setTimeout(() => {
        this.isDraft = false;
        this.drawSoon();
      }, DRAFT_MS);
    }
    this.drawSoon(after);
  },
  draw() {
    this.isWaiting = false;
    this.hasDrawn = true;
    requestAnimationFrame(() => {
      this.hasDrawn = false;
      if (this.isWaiting) this.draw();
    });
    const { width, height, pxPerPoint } = screenSize;
    if (width > 0 && height > 0) painter.hand.paint(windowOf(currentView(), mapCanvas.width, mapCanvas.height, pxPerPoint), this.isDraft);
    if (this.after.length > 0) for (const after of this.after.splice(0)) after();
    settle();
  },
};

/** Takes over the size of the map's box. */
function measure() {
  const { clientWidth: width, clientHeight: height } = mapBox;
  const pxPerPoint = Math.min(2, devicePixelRatio || 1);
  const isFitted = state.view !== null && screenSize.width > 0 && Math.abs(state.view.scale / fittingScale() - 1) < 1e-9;
  Object.assign(screenSize, { width, height, pxPerPoint });
  const [deviceWidth, deviceHeight] = [Math.max(1, Math.round(width * pxPerPoint)), Math.max(1, Math.round(height * pxPerPoint))];
  if (mapCanvas.width !== deviceWidth || mapCanvas.height !== deviceHeight) {
    mapCanvas.width = deviceWidth;
    mapCanvas.height = deviceHeight;
  }
  if (isFitted) state.view = wholeView();
  if (width > 0 && height > 0) setView(currentView());
}
