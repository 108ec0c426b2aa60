// @ts-check
// The line below the map: the cell under the pointer, or under the cross when keys are used.

const readout = htmlById("cursor");

/** The place that is pointed at. @type {{x: number, y: number} | null} */
let pointed = null;

const askCell = newestOnly(
  // A question would end a search or a curve, which make way for anything else.
  () => pointed && presses.size === 0 && engine.long.size === 0 ? { do: "cell", x: pointed.x, y: pointed.y, which: shown().which } : null,
  (/** @type {CellAnswer} */ answer) => showCell(answer),
);

/** Points at a pixel of the map. @param {number} px @param {number} py */
function pointAt(px, py) {
  pointed = { x: placeX(px), y: placeY(py) };
  askCell();
}

/** Says how a cell is read. */
function showCursorHint() {
  setText(readout, matchMedia("(pointer: coarse)").matches ? say().cursorTouch : say().cursorHint);
}

function pointAway() {
  pointed = null;
  if (document.activeElement !== mapBox) showCursorHint();
}

/** @param {CellAnswer} cell */
function showCell(cell) {
  if (!pointed) return;
  const words = say();
  if (!cell.inside) {
    setText(readout, words.outside);
    return;
  }
  const parts = [`x ${coordinate(pointed.x)}, y ${coordinate(pointed.y)}`];
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
  const margin = margin_m !== null && one !== null ? `, ${words.margin} ${meters(margin_m)}` : "";
  if (one === null || one === undefined) return words.cellNone;
  const short = `${one ? words.cellSees : words.cellBlocked}${margin}`;
  if (state.uavs.length === 1) return short;
  const others = sees.flatMap((seen, k) => (seen ? [uavName(state.uavs[k])] : []));
  return `${uavName(state.uavs[which])}: ${short}${others.length > 0 ? ` · ${words.los}: ${others.join(", ")}` : ""}`;
}
