// @ts-check
// The answer in numbers: the share in sight, its legend, and the zones.

/**
 * A row of a legend: what it is, its color (or how its swatch is filled), and how many cells it has, if known.
 * @typedef {{name: string, color?: Rgb, fill?: 'buildings' | 'ground' | 'hatched' | 'away', cells: number | null, isReceiver: boolean}} LegendRow
 */

/** What the map's numbers are about: one UAV, or all. @param {MapAnswer} answer @returns {Share | null} null if it cannot hover */
function shownShare(answer) {
  const { layer, which } = shown();
  if (layer !== "one") return answer.uavs.some((uav) => uav.ok) ? answer.all : null;
  const seen = answer.uavs[which];
  return seen?.ok ? seen : null;
}

/** The classes of receivers that the map shows. @param {MapAnswer} answer @returns {LegendRow[]} */
function receiverRows(answer) {
  const words = say();
  const { layer } = shown();
  const { all } = answer;
  const row = (/** @type {string} */ name, /** @type {Rgb} */ color, /** @type {number} */ cells) => ({ name, color, cells, isReceiver: true });
  if (layer === "count") {
    const n = answer.uavs.length;
    return all.seen_by.map((cells, k) => row(k === 0 ? words.seenByNone : words.seenBy(k, n), countColor(k, n), cells));
  }
  if (layer === "who") {
    const names = [words.seenByNone, ...state.uavs.slice(0, MOST_WHO).map((uav) => words.onlySeenBy(uavName(uav)))];
    const rows = names.map((name, k) => row(name, ONLY[k], all.who?.[k] ?? 0));
    return [...rows, row(words.seenBySeveral, ONLY[5], all.who?.[5] ?? 0)];
  }
  const seen = layer === "one" ? answer.uavs[shown().which] : null;
  if (seen?.ok && seen.sure) {
    const [surely, unsure] = seen.sure;
    return [row(words.surely, LOS, surely), row(words.unsure, UNSURE, unsure), row(words.surelyNot, NLOS, seen.receivers - surely - unsure)];
  }
  // A UAV that cannot hover sees nobody; the rows stay, so that what is below them stays in its place.
  const { receivers, los } = shownShare(answer) ?? { receivers: 0, los: 0 };
  return [row(words.los, LOS, los), row(words.nlos, NLOS, receivers - los)];
}

/** What the map shows beside receivers. @returns {LegendRow[]} */
function otherRows() {
  const words = say();
  /** @type {LegendRow[]} */
  const rows = [];
  if (engine.opened?.has_buildings && !["roof", "all", "air"].includes(state.sight.receivers)) rows.push({ name: words.buildings, fill: "buildings", cells: null, isReceiver: false });
  if (!["ground", "all", "air"].includes(state.sight.receivers)) rows.push({ name: words.others, fill: "ground", cells: null, isReceiver: false });
  if (coverage.answer?.has_out_of_range) rows.push({ name: words.outOfRange, fill: "away", cells: null, isReceiver: false });
  if (engine.opened?.has_no_data) rows.push({ name: words.noData, fill: "hatched", cells: null, isReceiver: false });
  return rows;
}

/** Elements of the legend, reused from answer to answer. @type {{row: HTMLElement, name: HTMLElement, detail: HTMLElement, swatch: HTMLElement}[]} */
const legendItems = [];

/** The shares of the classes of receivers; their cells where there is no share. @param {LegendRow[]} rows */
function legendShares(rows) {
  const receivers = rows.reduce((sum, row) => sum + (row.isReceiver ? row.cells ?? 0 : 0), 0);
  return rows.map(({ cells }) => (hasNoShare() ? grouped(cells ?? 0) : percent(cells ?? 0, receivers)));
}

/** Whether there is no share though there are receivers: a UAV on the map is over no data. */
function hasNoShare() {
  const { layer, which } = shown();
  const seen = layer === "one" ? coverage.answer?.uavs[which] : coverage.answer?.all;
  return Boolean(seen && "reason" in seen && seen.reason);
}

/** What a UAV sees of its receivers. @param {SeenWell} seen */
const shareOf = (seen) => (seen.reason ? "–" : percent(seen.los, seen.receivers));

/** @param {LegendRow[]} rows */
function showLegend(rows) {
  const list = htmlById("legend");
  while (legendItems.length < rows.length) {
    const [swatch, name, detail] = [make("i"), make("span", { class: "name" }), make("span", { class: "detail" })];
    const item = make("li", {}, swatch, name, detail);
    list.append(item);
    legendItems.push({ row: item, name, detail, swatch });
  }
  const shares = legendShares(rows);
  legendItems.forEach((item, k) => {
    const row = rows[k];
    item.row.hidden = !row;
    if (!row) return;
    item.row.classList.toggle("other", !row.isReceiver);
    setText(item.name, row.name);
    setText(item.detail, row.isReceiver ? shares[k] : "");
    item.swatch.className = row.fill ?? "";
    item.swatch.style.backgroundColor = row.color ? hex(row.color) : "";
  });
}

/** A bar of the shares of the legend. @param {LegendRow[]} rows */
function showBar(rows) {
  const bar = htmlById("share-bar");
  while (bar.childElementCount < rows.length) bar.append(make("i"));
  [...bar.children].forEach((part, k) => {
    if (!(part instanceof HTMLElement)) return;
    const row = rows[k];
    part.hidden = !row;
    if (!row) return;
    part.style.flexGrow = String(row.cells ?? 0);
    part.style.backgroundColor = row.color ? hex(row.color) : "";
  });
}

/** Brings the numbers up to date with an answer. @param {MapAnswer} answer */
function showResults(answer) {
  const words = say();
  const { layer, which } = shown();
  const share = shownShare(answer);
  const rows = receiverRows(answer);
  const of = layer === "one" ? uavName(state.uavs[which]) : words.layersLong[layer];
  setText(htmlById("result-of"), state.alone !== null ? words.alone(of) : state.uavs.length > 1 ? of : "");
  const hasShare = share !== null && !hasNoShare();
  setText(htmlById("share"), hasShare ? percent(share.los, share.receivers) : "–");
  const of_ = words.ofReceivers(words.receiversNames[state.sight.receivers] + withinRange());
  setText(htmlById("share-of"), hasNoShare() ? words.overNoData : share?.receivers === 0 ? words.noReceivers : of_);
  setText(htmlById("p-los"), hasShare && share.receivers > 0 ? `= ${fixed(share.los / share.receivers, 4)}` : "= –");
  setText(htmlById("cells"), share ? ` · ${words.cellsOf(grouped(share.los), grouped(share.receivers))}` : "");
  showBar(rows);
  showLegend([...rows, ...otherRows()]);
  showFailure();
  showZones(answer.uavs[state.selected]);
  for (const of of document.querySelectorAll(".of")) setText(of, ofSelected());
}

/** Says why the selected UAV cannot hover, and how high it could; it lies over the map, where it moves nothing. */
function showFailure() {
  const seen = coverage.answer?.uavs[state.selected];
  const box = htmlById("failure");
  box.hidden = !seen || seen.ok;
  if (!seen || seen.ok) return;
  setText(htmlById("failure-words"), failureWords(selectedUav(), seen));
  const height = heightToHover(selectedUav(), seen);
  const lift = buttonById("lift");
  lift.hidden = !height;
  if (height) setText(lift, (isRoofMissing(selectedUav().height, seen) ? say().useHeight : say().lift)(heightWords(height)));
}

/** The newest zones, which keep their room while the UAV cannot hover. @type {ZoneShares | null} */
let lastZones = null;

/** The selected UAV's share of each zone. @param {Seen | undefined} seen */
function showZones(seen) {
  if (seen?.ok) lastZones = seen.zones;
  const box = htmlById("zones");
  box.hidden = !lastZones;
  if (!lastZones) return;
  const zones = lastZones;
  const list = htmlById("zone-rows");
  const names = /** @type {(keyof ZoneShares)[]} */ (["street", "crossroad", "courtyard", "rooftop"]);
  while (list.childElementCount < names.length) {
    list.append(make("li", {}, make("span", { class: "name" }), make("span", { class: "meter" }, make("i")), make("span", { class: "detail" })));
  }
  names.forEach((zone, k) => {
    const { receivers, los } = zones[zone];
    const item = /** @type {HTMLElement} */ (list.children[k]);
    item.hidden = receivers === 0;
    item.classList.toggle("none", !seen?.ok);
    const [name, meter, detail] = item.children;
    setText(name, say().zoneNames[zone]);
    setText(detail, seen?.ok && !seen.reason ? percent(los, receivers) : "–");
    /** @type {HTMLElement} */ (meter.firstElementChild).style.width = `${receivers > 0 && seen?.ok ? (100 * los) / receivers : 0}%`;
  });
}

/** Says the result to screen readers, once the map rests. */
function speakResult() {
  const { answer } = coverage;
  const share = answer && shownShare(answer);
  const { layer, which } = shown();
  const of = layer === "one" ? `${uavName(state.uavs[which])}, ${heightWords(state.uavs[which].height)}` : say().layersLong[layer];
  const failed = answer?.uavs[which];
  if (hasNoShare()) setText(htmlById("spoken"), say().overNoData);
  else if (share) setText(htmlById("spoken"), say().said(percent(share.los, share.receivers), of));
  else if (failed && !failed.ok) setText(htmlById("spoken"), failureWords(state.uavs[which], failed));
}
