// @ts-check
// Placements that are kept: compared side by side, shown again, and exported for `skyshed compare`.

const keptTable = htmlById("kept-rows");

/** The newest comparison: rows of the kept placements, then of now. @type {ComparedRow[]} */
let compared = [];

const askCompare = newestOnly(
  () => {
    if (state.kept.length === 0) return null;
    const rows = [...state.kept, { name: "", uavs: state.uavs, sight: state.sight }];
    return { do: "compare", kept: rows.map(({ uavs, sight }) => ({ uavs, sight })), base: state.base };
  },
  (/** @type {{rows: ComparedRow[]}} */ answer) => {
    compared = answer.rows;
    showKeptRows();
  },
);

/** Lists the kept placements, and below them the one of now. */
function showKeptRows() {
  const has = state.kept.length > 0;
  htmlById("kept-empty").hidden = has;
  htmlById("kept-filled").hidden = !has;
  if (!has) {
    compared = [];
    keptTable.replaceChildren();
    return;
  }
  // Rows that are not compared yet have no numbers.
  const rows = compared.length === state.kept.length + 1 ? compared : [];
  keptTable.replaceChildren(
    ...state.kept.map((kept, k) => keptRow(kept, k, rows[k])),
    make("tr", { class: "now" }, make("td", {}), make("th", { scope: "row" }, say().now), ...numbersOf(rows[state.kept.length], false), make("td", {})));
}

/** @param {Kept} kept @param {number} k @param {ComparedRow | undefined} row */
function keptRow(kept, k, row) {
  const words = say();
  const radio = make("input", { type: "radio", name: "base", id: `base-${k + 1}`, "aria-label": words.baseOf(kept.name) });
  radio.checked = k === state.base;
  radio.addEventListener("change", () => {
    state.base = k;
    changed("kept");
  });
  const detail = kept.uavs.length === 1 ? heightShort(kept.uavs[0].height) : `${kept.uavs.length} ${words.uavs}`;
  const show = make("button", { type: "button", class: "plain", id: `kept-show-${k + 1}`, title: words.showKept(kept.name) }, make("b", {}, kept.name), ` ${detail}`);
  show.addEventListener("click", () => {
    const undo = showKept(k);
    notify(words.restored(kept.name), { action: words.undo, does: undo });
  });
  const remove = make("button", { type: "button", class: "icon small", "aria-label": words.keptRemove(kept.name), title: words.keptRemove(kept.name) }, "×");
  remove.addEventListener("click", () => removeKept(k));
  return make("tr", {}, make("td", {}, radio), make("th", { scope: "row" }, show), ...numbersOf(row, k === state.base), make("td", {}, remove));
}

/** Cells of a row: share, gained, lost. @param {ComparedRow | undefined} row @param {boolean} isBase */
function numbersOf(row, isBase) {
  if (row && !row.ok) return [make("td", { colspan: 3, class: "refused" }, row.words)];
  const texts = !row ? ["…", "", ""]
    : [row.reason ? "–" : percent(row.los, row.receivers), ...(isBase ? ["–", "–"] : [`+${grouped(row.gained)}`, `−${grouped(row.lost)}`])];
  const inPoints = (/** @type {number} */ cells) => (row ? say().points(points(cells, row.receivers)) : "");
  const below = row && !isBase ? ["", inPoints(row.gained), inPoints(row.lost)] : [];
  return texts.map((text, k) => make("td", { class: "number" }, text, ...(below[k] ? [make("small", {}, below[k])] : [])));
}

/** The kept placements as single UAVs with names that differ; the one of now where none is kept. @returns {Uav[]} */
function uavsToExport() {
  const placements = state.kept.length > 0 ? state.kept : [{ name: "", uavs: state.uavs }];
  const names = new Set();
  return placements.flatMap(({ name, uavs }) => uavs.map((uav) => {
    const wanted = !name ? uav.id : uavs.length === 1 ? name : `${name} ${uav.id}`;
    let id = wanted;
    for (let n = 2; names.has(id); n += 1) id = `${wanted} (${n})`;
    names.add(id);
    return { ...uav, id };
  }));
}

/** A table as `--uavs` reads it: names, places, heights with what they are above. */
function keptCsv() {
  const quoted = (/** @type {string} */ text) => (/[",;\t\r\n]|^#/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const rows = uavsToExport().map((uav) => [quoted(uav.id), uav.x, uav.y, heightTyped(uav.height)].join(","));
  return `${["id,x,y,h", ...rows].join("\r\n")}\r\n`;
}

/** Points as `--uavs` reads them; their reference system is named where it has a code. */
function keptGeojson() {
  const epsg = facts.crs?.epsg;
  const crs = epsg ? { crs: { type: "name", properties: { name: `urn:ogc:def:crs:EPSG::${epsg}` } } } : {};
  const features = uavsToExport().map((uav) => ({
    type: "Feature",
    properties: { id: uav.id, h: heightTyped(uav.height) },
    geometry: { type: "Point", coordinates: [uav.x, uav.y] },
  }));
  return `${JSON.stringify({ type: "FeatureCollection", ...crs, features }, null, 1)}\n`;
}

/** Keeps the placement, and says where it is found. */
function keep() {
  notify(say().keptAs(keepPlacement()), { action: say().showList, does: openKept });
}

/** Brings the list of kept placements on screen. */
function openKept() {
  const box = byId("kept", HTMLDetailsElement);
  box.open = true;
  openSheet(true);
  box.scrollIntoView({ block: "nearest" });
}

function listenToKept() {
  buttonById("keep").addEventListener("click", keep);
  buttonById("keep-here").addEventListener("click", keep);
  buttonById("export-csv").addEventListener("click", () => saveFile(`${fileStem()}-uavs.csv`, "text/csv", [keptCsv()]));
  buttonById("export-geojson").addEventListener("click", () => saveFile(`${fileStem()}-uavs.geojson`, "application/geo+json", [keptGeojson()]));
}
