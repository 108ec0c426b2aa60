// @ts-check
// The line below the map: the cell under the pointer, or under the cross when keys are used.

const readout = htmlById("cursor");

/** The pixel that is pointed at; its place follows from the view. @type {{px: number, py: number} | null} */
let pointed = null;
/** The place of the newest question. */
let askedPlace = { x: 0, y: 0 };

const askCell = newestOnly(
  () => {
    if (!pointed || presses.size > 0) return null;
    askedPlace = { x: placeX(pointed.px), y: placeY(pointed.py) };
    return { do: "cell", ...askedPlace, which: shown().which };
  },
  (/** @type {CellAnswer} */ answer) => showCell(answer),
);

/** Points at a pixel of the map. @param {number} px @param {number} py */
function pointAt(px, py) {
  pointed = { px, py };
  askCell();
}

/** While a UAV is dragged, its place is read. @param {Uav} uav */
function readUav(uav) {
  setText(readout, `${uavName(uav)}: ${placeWords(uav)}`);
}

/** Says how a cell is read. */
function showCursorHint() {
  setText(readout, matchMedia("(pointer: coarse)").matches ? say().cursorTouch : say().cursorHint);
}

function pointAway() {
  pointed = null;
  if (!mapBox.matches(":focus-visible")) showCursorHint();
}

/** @param {CellAnswer} cell */
function showCell(cell) {
  // Whatever is pressed now is not what was asked about.
  if (!pointed || presses.size > 0) return;
  const words = say();
  if (!cell.inside) {
    setText(readout, words.outside);
    return;
  }
  const parts = [placeWords(askedPlace)];
  if (cell.kind === "void") parts.push(words.cellVoid);
  if (cell.ground_m !== null) parts.push(`${words.groundWord} ${meters(cell.ground_m)}`);
  if (cell.roof_m !== null) parts.push(`${words.roof} ${meters(cell.roof_m)}`);
  /** @type {Record<string, string>} */
  const zoneNames = words.zoneName;
  if (cell.zone) parts.push(zoneNames[cell.zone] ?? cell.zone);
  if (cell.kind !== "void") parts.push(sightOfCell(cell));
  setText(readout, parts.join(" · "));
}

/** Who sees a cell. @param {CellAnswer} cell */
function sightOfCell({ sees, margin_m }) {
  const words = say();
  const { which } = shown();
  const one = sees[which];
  const margin = margin_m !== null && one !== null ? marginWords(margin_m, state.sight.rx_height) : "";
  if (one === null || one === undefined) return words.cellNone;
  const short = `${one ? words.cellSees : words.cellBlocked}${margin && `, ${margin}`}`;
  if (state.uavs.length === 1) return short;
  const others = sees.flatMap((seen, k) => (seen && k !== which ? [uavName(state.uavs[k])] : []));
  return `${uavName(state.uavs[which])}: ${short}${others.length > 0 ? ` · ${words.los}: ${others.join(", ")}` : ""}`;
}
