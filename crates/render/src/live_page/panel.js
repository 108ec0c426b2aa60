// @ts-check
// The controls: UAVs, height, layers, receivers; language and theme.

const heightInput = inputById("height");
const heightSlider = inputById("height-slider");
const heightKind = selectById("height-kind");

/** Makes the list of UAVs anew when they, their names or the language changed. */
function makeUavList() {
  const words = say();
  const rows = state.uavs.map((uav, k) => {
    const color = uavColor(k);
    const badge = make("button", { type: "button", class: "badge", style: `background:${hex(color)};color:${inkOn(color)}`, "aria-label": uavName(uav) }, String(k + 1));
    badge.addEventListener("click", () => {
      select(k);
      bringIntoView(state.uavs[k].x, state.uavs[k].y);
    });
    const name = make("input", {
      type: "text", id: `name-${k + 1}`, "aria-label": words.rename(uavName(uav)), placeholder: `${isObserver(uav) ? words.observer : words.uav} ${uav.id}`, maxlength: 80, autocomplete: "off", spellcheck: "false",
    });
    name.value = /^\d+$/.test(uav.id) ? "" : uav.id;
    name.addEventListener("focus", () => select(k));
    name.addEventListener("change", () => renameUav(k, name.value));
    const remove = make("button", { type: "button", class: "icon small", "aria-label": words.remove(uavName(uav)), title: words.remove(uavName(uav)) }, "×");
    remove.hidden = state.uavs.length === 1;
    remove.addEventListener("click", () => removeUav(k));
    const row = make("li", { id: `uav-${k + 1}` }, badge, name, make("span", { class: "height" }), make("span", { class: "share" }), remove, make("span", { class: "place note" }));
    row.addEventListener("click", (event) => {
      if (event.target instanceof Node && !remove.contains(event.target)) select(k);
    });
    return row;
  });
  htmlById("uav-list").replaceChildren(...rows);
  htmlById("show").hidden = state.uavs.length === 1;
  buttonById("add").disabled = buttonById("add-here").disabled = state.uavs.length >= MOST_UAVS;
  inputById("layer-who").disabled = state.uavs.length > MOST_WHO;
  describeUavs();
}

/** Brings heights and shares in the list up to date. */
function describeUavs() {
  [...htmlById("uav-list").children].forEach((row, k) => {
    const uav = state.uavs[k];
    const seen = coverage.answer?.uavs[k];
    row.classList.toggle("selected", k === state.selected);
    if (row.firstElementChild) row.firstElementChild.setAttribute("aria-pressed", String(k === state.selected));
    const [height, share, place] = [row.querySelector(".height"), row.querySelector(".share"), row.querySelector(".place")];
    if (height) setText(height, heightShort(uav.height));
    if (share) setText(share, !seen ? "" : seen.ok ? shareOf(seen) : "!");
    const isBeyond = k === state.selected && below?.uav === uav && isBelow(uav) && below.cell.kind === "void";
    if (place) setText(place, isBeyond ? `${placeWords(uav)} · ${say().beyond}` : `${say().position}: ${placeWords(uav)}`);
  });
}

/** The end of the slider, so that it stands still while it is used. */
const slider = { low: 0, high: 300, kind: "" };

/** Shows the height of the selected UAV. */
function showHeight() {
  const uav = selectedUav();
  const { kind, m } = uav.height;
  setText(htmlById("height-of"), state.uavs.length > 1 ? say().heightOf(uavName(uav)) : say().height);
  showField(heightField);
  htmlById("height-unit").hidden = kind !== "agl";
  setValue(heightKind, kind);
  const seen = coverage.answer?.uavs[state.selected];
  const ground = kind === "amsl" && seen?.ok && seen.agl_m !== null ? Math.floor(seen.amsl_m - seen.agl_m) : 0;
  if (slider.kind !== kind || m > slider.high || m < slider.low) {
    slider.low = Math.min(ground, Math.floor(m));
    slider.high = Math.max(ground + 300, Math.ceil((1.3 * (m - slider.low)) / 100) * 100 + slider.low);
    slider.kind = kind;
  }
  heightSlider.min = String(slider.low);
  heightSlider.max = String(slider.high);
  heightSlider.step = "1";
  setValue(heightSlider, String(m));
  heightSlider.style.setProperty("--part", `${(100 * (m - slider.low)) / (slider.high - slider.low)}%`);
  heightSlider.setAttribute("aria-valuetext", heightWords(uav.height));
}

/** The shortest number that is this height on the engine's lattice of 1/1024 m. @param {number} m */
function shortHeight(m) {
  const steps = (/** @type {number} */ v) => Math.floor(1024 * v + 0.5);
  const short = [0, 1, 2, 3].map((digits) => Number(m.toFixed(digits))).find((v) => steps(v) === steps(m));
  return short ?? Number(m.toFixed(4));
}

/**
 * How high the selected UAV is above something else; null where that is not known.
 * @param {HeightKind} kind
 * @param {SeenWell} seen
 */
function heightAbove(kind, { amsl_m, agl_m, above_m, over }) {
  if (kind === "amsl") return amsl_m;
  return kind === "agl" ? agl_m : over === "rooftop" ? above_m : null;
}

/** Measures the height from something else; the UAV stays where it is. @param {HeightKind} kind */
function changeKind(kind) {
  const k = state.selected;
  const seen = coverage.answer?.uavs[k];
  forgetField(heightField);
  const m = seen?.ok ? heightAbove(kind, seen) : state.uavs[k].height.m;
  if (m === null) tellReason(heightField, kind === "roof" ? say().noRoof : say().noGround);
  // Where it cannot hover, the number stays as it was.
  else setHeight(k, { kind, m: seen?.ok ? shortHeight(m) : m });
  showHeight();
}

/** The cell below the selected UAV as it was last asked for. @type {{uav: Uav, x: number, y: number, cell: CellAnswer} | null} */
let below = null;
/** Whether that cell is still below a UAV. @param {Uav} uav */
const isBelow = (uav) => below !== null && below.x === uav.x && below.y === uav.y;

/** @type {{uav: Uav, x: number, y: number} | null} */
let askedBelow = null;
const askBelow = newestOnly(
  () => {
    const uav = selectedUav();
    // The answer is kept with the place that was asked for.
    askedBelow = { uav, x: uav.x, y: uav.y };
    return { do: "cell", x: uav.x, y: uav.y, which: state.selected };
  },
  (/** @type {CellAnswer} */ cell) => {
    if (askedBelow) below = { ...askedBelow, cell };
    showFailure();
    describeUavs();
  },
);

/** What a height is measured from below a UAV [m above the datum]; null if it is not known. @param {Uav} uav @param {HeightKind} kind */
function zeroOf(uav, kind) {
  if (kind === "amsl") return 0;
  if (!below || below.uav !== uav) return null;
  return kind === "agl" ? below.cell.ground_m : below.cell.roof_m;
}

/** Whether a height above a roof is asked for where there is no building. @param {Height} height @param {SeenNot} seen */
const isRoofMissing = (height, seen) => seen.code === "E204" && height.kind === "roof" && !facts.surface_only;

/** How far a UAV is lifted above the lowest height at which it can hover [m]. */
const CLEARANCE = 5;

/** A height at which a UAV can hover, in the reference of its own if that is possible. @param {Uav} uav @param {SeenNot} seen @returns {Height | null} */
function heightToHover(uav, seen) {
  if (isRoofMissing(uav.height, seen)) return { kind: "agl", m: uav.height.m };
  if (seen.lowest_amsl_m === null) return null;
  const zero = zeroOf(uav, uav.height.kind);
  const m = Math.ceil(10 * (seen.lowest_amsl_m + CLEARANCE - (zero ?? 0)) - 1e-6) / 10;
  return { kind: zero === null ? "amsl" : uav.height.kind, m };
}

/** Why a UAV cannot hover at a height, in the reference in which that is given. @param {Uav} uav @param {SeenNot} seen */
function failureWords(uav, seen, { kind, m } = uav.height) {
  const words = sayOf(uav);
  if (isRoofMissing({ kind, m }, seen)) return words.noRoof;
  if (seen.code === "E204" && seen.lowest_amsl_m === null) return words.beyondData;
  const lowest = seen.lowest_amsl_m;
  if (lowest === null || (seen.code !== "E201" && seen.code !== "E202")) return `${words.cannotHover}: ${seen.words}`;
  const zero = zeroOf(uav, kind);
  const top = { kind: zero === null ? /** @type {const} */ ("amsl") : kind, m: lowest - (zero ?? 0) };
  return (seen.code === "E201" ? words.insideBuilding : words.belowGround)(heightWords({ kind, m }), heightWords(top));
}

/** Lifts the selected UAV to where it can hover. */
function liftSelected() {
  const seen = coverage.answer?.uavs[state.selected];
  const height = seen && !seen.ok ? heightToHover(selectedUav(), seen) : null;
  if (height) setHeight(state.selected, height);
}

/** A UAV that was just added, until its first answer. @type {Uav | null} */
let newcomer = null;
/** The height of a new UAV that cannot hover at that of the selected one. @type {Height} */
const FIRST_HEIGHT = { kind: "agl", m: 120 };

/** Lifts a new UAV that cannot hover. @param {MapAnswer} answer */
function settleNewcomer(answer) {
  const k = newcomer ? state.uavs.indexOf(newcomer) : -1;
  const seen = answer.uavs[k];
  if (!seen) return;
  newcomer = null;
  if (seen.ok) return;
  setHeight(k, FIRST_HEIGHT);
}

/** The end of the slider of the range: half of the map's diagonal. */
const LONGEST_RANGE = Math.ceil((Math.hypot(X_MAX - grid.x_min, grid.y_max - Y_MIN) * grid.meters_per_unit) / 20) * 10;

/** Heights of a pilot's eyes and of the drone, and those that a page goes back to [m]. */
const IN_AIR = { uav_m: 1.7, rx_height: 100 };
const ON_GROUND = { uav_m: 120, rx_height: 1.5 };

/**
 * Takes other receivers. To places of a drone UAVs become observers on the ground, and back, unless their heights, and that of the
 * receivers, are so already.
 * @param {Receivers} receivers
 */
function setReceivers(receivers) {
  const [was, is] = [isInAir(), receivers === "air"];
  /** @type {Partial<Sight>} */
  const part = { receivers };
  if (was !== is) {
    const to = is ? IN_AIR : ON_GROUND;
    if (state.sight.rx_height < OBSERVER_BELOW === is) part.rx_height = to.rx_height;
    for (const uav of state.uavs) if (uav.height.m < OBSERVER_BELOW !== is) uav.height = { kind: "agl", m: to.uav_m };
    changed("place");
  }
  setSight(part);
  changed("uavs");
}

/** Texts of two angles, or of none. @param {[number, number] | null} pair */
const pairTexts = (pair) => (pair ?? [null, null]).map(fieldText);

/** A height as it is typed: a bare number is above the ground. @param {Height} height */
const heightText = ({ kind, m }) => fieldText(m) + (kind === "agl" ? "" : kind);
const heightField = makeField("height", ["height"], (height, since) => setHeight(state.selected, height, since), () => [heightText(selectedUav().height)]);
const radiusField = makeField("radius", ["radius"], (radius) => setSight({ radius }), () => [fieldText(state.sight.radius)]);
/** The fields that are read with each letter; all others are when they are left. */
const QUICK_FIELDS = [
  heightField,
  makeField("rx_height", ["rx-height"], (rx_height) => setSight({ rx_height }), () => [fieldText(state.sight.rx_height)]),
];
makeField("min_radius", ["min-radius"], (min_radius) => setSight({ min_radius }), () => [fieldText(state.sight.min_radius)]);
makeField("sector", ["sector-from", "sector-to"], (sector) => setSight({ sector }), () => pairTexts(state.sight.sector));
makeField("elevation", ["elevation-from", "elevation-to"], (elevation) => setSight({ elevation }), () => pairTexts(state.sight.elevation));
makeField("beam", ["beam"], (beam) => setSight({ beam }), () => [fieldText(state.sight.beam)]);
makeField("slant_range", ["slant-range"], (slant_range) => setSight({ slant_range }), () => [fieldText(state.sight.slant_range)]);
makeField("earth_k", ["earth-k"], (earth_k) => setSight({ earth_k }), () => [kText(state.sight.earth_k)]);
makeField("height_error", ["height-error"], (height_error) => setSight({ height_error }), () => [fieldText(state.sight.height_error || null)]);

/** K of the earth as a fraction where it is one of few parts. @param {number | null} k */
function kText(k) {
  const parts = k === null ? undefined : [1, 2, 3, 6].find((parts) => Math.round(k * parts) / parts === k && Math.round(k * parts) > 0);
  return k === null || parts === undefined || parts === 1 ? fieldText(k) : `${Math.round(k * parts)}/${parts}`;
}

function showTitle() {
  const title = say().title(facts.name, facts.title);
  setText(htmlById("title"), title);
  document.title = title;
}

function showSight() {
  showTitle();
  const { receivers, rx_height, radius } = state.sight;
  setValue(selectById("receivers"), receivers);
  inputById("radius-limited").checked = radius === null;
  const slider = inputById("radius-slider");
  slider.max = String(Math.max(LONGEST_RANGE, radius ?? 0));
  setValue(slider, String(radius ?? slider.max));
  slider.setAttribute("aria-valuetext", radius === null ? say().unlimited : meters(radius));
  slider.style.setProperty("--part", `${(100 * Number(slider.value)) / Number(slider.max)}%`);
  const range = radius === null ? say().unlimited : lengthWords(radius);
  setText(htmlById("sight-says"), [say().receiversChoice[receivers], meters(rx_height, 2), range, ...limitsSay(state.sight)].join(" · "));
  for (const field of fields) if (field !== heightField) showField(field);
  for (const input of document.querySelectorAll('input[name="layer"]')) {
    if (input instanceof HTMLInputElement) input.checked = input.value === shown().layer;
  }
  setText(htmlById("rx-height-of"), say().receiverHeight(receiversAbove()));
}

/** Puts the texts of the language on everything that carries the name of one. */
function showTexts() {
  /** @type {Record<string, any>} */
  const words = say();
  document.documentElement.lang = state.language;
  for (const element of document.querySelectorAll("[data-t]")) setText(element, words[element.getAttribute("data-t") ?? ""]);
  for (const [from, to] of [["data-label", "aria-label"], ["data-title", "title"]]) {
    for (const element of document.querySelectorAll(`[${from}]`)) element.setAttribute(to, words[element.getAttribute(from) ?? ""]);
  }
  for (const [select, texts] of /** @type {[string, Record<string, string>][]} */ ([
    ["receivers", words.receiversChoice], ["height-kind", words.kinds],
  ])) {
    for (const option of selectById(select).options) option.text = texts[option.value];
  }
  for (const label of document.querySelectorAll("[data-layer]")) setText(label, words.layers[label.getAttribute("data-layer") ?? ""]);
  showTitle();
  setText(buttonById("language"), state.language === "de" ? "EN" : "DE");
  htmlById("keys").replaceChildren(...say().keysList.flatMap(([what, does]) => [make("dt", {}, what), make("dd", {}, does)]));
}

function showTheme() {
  document.documentElement.dataset.theme = state.theme;
  painter.useTheme(state.theme);
}

/** A place for a new UAV: in the middle of the screen, away from the others. @returns {[number, number]} */
function freePlace() {
  const { width, height } = screenSize;
  const far = Math.min(width, height) / 4;
  const places = [[0, 0], [far, 0], [-far, 0], [0, far], [0, -far], [far, far], [-far, -far]].map(([dx, dy]) => [width / 2 + dx, height / 2 + dy]);
  const room = (/** @type {number[]} */ [px, py]) => Math.min(...state.uavs.map(({ x, y }) => Math.hypot(pxOfX(x) - px, pxOfY(y) - py)));
  const free = places.find((place) => room(place) > 80) ?? places[0];
  return [placeX(free[0]), placeY(free[1])];
}

/** Reads a text as if it had been typed. @param {Field} field @param {string} text */
function typeInto(field, text) {
  field.inputs[0].value = text;
  void readField(field);
}

function listenToPanel() {
  const add = () => {
    addUav(...freePlace());
    newcomer = selectedUav();
    forgetHint();
  };
  buttonById("add").addEventListener("click", add);
  buttonById("add-here").addEventListener("click", add);
  for (const field of fields) {
    for (const input of field.inputs) {
      input.addEventListener(QUICK_FIELDS.includes(field) ? "input" : "change", () => void readField(field));
      input.addEventListener("blur", () => showField(field));
    }
  }
  heightInput.addEventListener("keydown", (event) => {
    const steps = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!steps) return;
    event.preventDefault();
    stepHeight(state.selected, steps * (event.shiftKey ? 10 : 1), performance.now());
    forgetField(heightField);
  });
  heightSlider.addEventListener("input", () => setHeight(state.selected, { kind: selectedUav().height.kind, m: Number(heightSlider.value) }, performance.now()));
  heightKind.addEventListener("change", () => changeKind(/** @type {HeightKind} */ (heightKind.value)));
  buttonById("lift").addEventListener("click", liftSelected);
  for (const input of document.querySelectorAll('input[name="layer"]')) {
    if (input instanceof HTMLInputElement) input.addEventListener("change", () => setLayer(/** @type {Layer} */ (input.value)));
  }
  selectById("receivers").addEventListener("change", () => setReceivers(/** @type {Receivers} */ (selectById("receivers").value)));
  inputById("radius-slider").addEventListener("input", () => typeInto(radiusField, inputById("radius-slider").value));
  inputById("radius-limited").addEventListener("change", () => typeInto(radiusField, inputById("radius-limited").checked ? "" : inputById("radius-slider").value));
  buttonById("language").addEventListener("click", () => {
    state.language = state.language === "de" ? "en" : "de";
    changed("look");
  });
  buttonById("theme").addEventListener("click", () => {
    Object.assign(state, { theme: state.theme === "dark" ? "light" : "dark", themeChosen: true });
    changed("look");
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => {
    if (state.themeChosen) return;
    state.theme = event.matches ? "dark" : "light";
    changed("look");
  });
}
