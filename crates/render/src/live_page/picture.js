// @ts-check
// The map as a picture of its own, laid out as the program's: title, map, legend with shares, scale and north, caption.
// It is drawn on white whatever the theme of the page.

const INK = "#1b1f24";
const MUTED = "#545d68";
const HAIRLINE = "#aeb6bf";
/** Around everything [px]. */
const PAGE_MARGIN = 40;
/** Longest side of the whole map [px], and the most cells along it that are drawn one by one. */
const PICTURE = { target: 1400, whole: 2000, least: 760 };

const font = (/** @type {number} */ size, weight = 400) => `${weight} ${size}px system-ui, sans-serif`;

/** Size of the picture of the whole map. @returns {[number, number]} */
function wholeSize() {
  const finest = Math.min(grid.cell_width, grid.cell_height);
  const sides = [grid.n_cols * grid.cell_width, grid.n_rows * grid.cell_height].map((side) => side / finest);
  const longest = Math.max(...sides);
  const perFinest = longest > PICTURE.whole ? 1 / Math.max(2, Math.round(longest / PICTURE.target)) : within(Math.round(PICTURE.target / longest), 1, 320);
  return [Math.max(1, Math.round(sides[0] * perFinest)), Math.max(1, Math.round(sides[1] * perFinest))];
}

/**
 * Draws the picture.
 * @param {'whole' | 'view'} part
 * @param {MapAnswer} answer
 * @param {LegendRow[]} rows
 */
function drawPicture(part, answer, rows) {
  const [width, height] = part === "whole" ? wholeSize() : [Math.round(screenSize.width * 2), Math.round(screenSize.height * 2)];
  /** @type {View} */
  const view = part === "whole"
    ? { x: (grid.x_min + X_MAX) / 2, y: (grid.y_max + Y_MIN) / 2, scale: width / (X_MAX - grid.x_min) }
    : { ...currentView(), scale: 2 * currentView().scale };
  painter.useTheme("light");
  const pixels = painter.hand.pixels(windowOf(view, width, height, 1, 14));
  painter.useTheme(state.theme);

  const pageWidth = Math.max(width, PICTURE.least) + 2 * PAGE_MARGIN;
  const canvas = make("canvas", { width: pageWidth, height: 10 });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const room = pageWidth - 2 * PAGE_MARGIN;
  const title = wrapped(context, say().title(facts.name, facts.title), font(42, 600), room);
  const caption = captionLines(answer).map((line) => wrapped(context, line, font(23), room));
  const mapTop = PAGE_MARGIN + 52 * title.length + 12;
  const legend = placeLegend(context, rows, room - 280);
  const legendTop = mapTop + height + 26;
  const captionTop = legendTop + Math.max(legend.height, 90) + 24;
  // Setting a size clears the canvas.
  canvas.height = captionTop + 36 * caption.flat().length + PAGE_MARGIN;

  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, canvas.width, canvas.height);
  title.forEach((line, k) => richText(context, line, PAGE_MARGIN, PAGE_MARGIN + 40 + 52 * k, font(42, 600), INK));
  context.putImageData(pixels, PAGE_MARGIN, mapTop);
  context.save();
  context.translate(PAGE_MARGIN, mapTop);
  context.beginPath();
  context.rect(0, 0, width, height);
  context.clip();
  pictureMarks(context, view, width, height);
  context.restore();
  context.strokeStyle = INK;
  context.lineWidth = 1.6;
  context.strokeRect(PAGE_MARGIN, mapTop, width, height);
  const shares = legendShares(rows);
  legend.items.forEach(({ row, x, y }, k) => legendItem(context, row, shares[k], PAGE_MARGIN + x, legendTop + y));
  drawOrientation(context, pageWidth - PAGE_MARGIN, legendTop, view.scale / grid.meters_per_unit);
  context.strokeStyle = HAIRLINE;
  context.strokeRect(PAGE_MARGIN, captionTop - 10, room, 0);
  caption.flat().forEach((line, k) => richText(context, line, PAGE_MARGIN, captionTop + 26 + 36 * k, font(23), INK));
  return canvas;
}

/** Lines of words that fit a width. @param {CanvasRenderingContext2D} context @param {string} text @param {string} face @param {number} width */
function wrapped(context, text, face, width) {
  context.font = face;
  /** @type {string[]} */
  const found = [];
  let line = "";
  for (const word of text.split(" ")) {
    const longer = line ? `${line} ${word}` : word;
    if (line && context.measureText(longer).width > width) {
      found.push(line);
      line = word;
    } else line = longer;
  }
  return [...found, line];
}

/** Writes a line in which P_LoS has its index. @param {CanvasRenderingContext2D} context @param {string} text @param {number} x @param {number} y @param {string} face @param {string} ink */
function richText(context, text, x, y, face, ink) {
  context.fillStyle = ink;
  let at = x;
  text.split("P_LoS").forEach((piece, k) => {
    context.font = face;
    if (k > 0) {
      context.fillText("P", at, y);
      at += context.measureText("P").width;
      const size = Number(/(\d+)px/.exec(face)?.[1] ?? 23);
      context.font = font(0.7 * size);
      context.fillText("LoS", at, y + 0.2 * size);
      at += context.measureText("LoS").width;
      context.font = face;
    }
    context.fillText(piece, at, y);
    at += context.measureText(piece).width;
  });
}

/** UAVs with labels, the link and the ranges. @param {CanvasRenderingContext2D} context @param {View} view @param {number} width @param {number} height */
function pictureMarks(context, view, width, height) {
  const x = (/** @type {number} */ v) => width / 2 + (v - view.x) * view.scale;
  const y = (/** @type {number} */ v) => height / 2 - (v - view.y) * view.scale;
  /** @param {number[]} from @param {number[]} to @param {string} color @param {number} thick @param {number[]} dashes */
  const line = (from, to, color, thick, dashes = []) => {
    context.strokeStyle = color;
    context.lineWidth = thick;
    context.setLineDash(dashes);
    context.beginPath();
    context.moveTo(from[0], from[1]);
    context.lineTo(to[0], to[1]);
    context.stroke();
    context.setLineDash([]);
  };
  if (hasTrack()) pictureTrack(context, x, y);
  const { link } = overlay;
  if (link) {
    const [from, to] = [link.uav, link.receiver].map((p) => [x(p.x), y(p.y)]);
    const clear = clearPart(link);
    const met = [from[0] + clear * (to[0] - from[0]), from[1] + clear * (to[1] - from[1])];
    line(from, to, "#ffffff", 11);
    line(from, met, hex(LOS), 5);
    if (!link.los) line(met, to, hex(NLOS), 5, [12, 8]);
    disc(context, to[0], to[1], 10, INK, "#ffffff");
    if (link.obstruction) diamond(context, x(link.obstruction.x), y(link.obstruction.y), 12);
  }
  state.uavs.forEach((uav, k) => pictureUav(context, uav, k, x(uav.x), y(uav.y), width));
}

/** Colors and dashes of the stretches of a track. @type {Record<TrackState, [string, number[]]>} */
const TRACK_LINES = { los: [hex(LOS), []], nlos: ["#d55e00", [12, 8]], inside: ["#882255", [3, 5]], nodata: ["#6b7178", []] };

/** The track in its stretches. @param {CanvasRenderingContext2D} context @param {(x: number) => number} x @param {(y: number) => number} y */
function pictureTrack(context, x, y) {
  const { whole, stretches } = trackPaths(x, y);
  const line = (/** @type {string} */ d, /** @type {string} */ color, /** @type {number} */ thick, /** @type {number[]} */ dashes) => {
    context.strokeStyle = color;
    context.lineWidth = thick;
    context.lineJoin = "round";
    context.setLineDash(dashes);
    context.stroke(new Path2D(d));
    context.setLineDash([]);
  };
  line(whole, "#ffffff", 11, []);
  if (stretches.length === 0) line(whole, TRACK_LINES.nodata[0], 5, []);
  for (const { name, d } of stretches) line(d, TRACK_LINES[name][0], 5, TRACK_LINES[name][1]);
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} r @param {string} fill @param {string} [stroke] */
function disc(context, x, y, r, fill, stroke) {
  context.beginPath();
  context.arc(x, y, r, 0, 2 * Math.PI);
  context.fillStyle = fill;
  context.fill();
  if (!stroke) return;
  context.strokeStyle = stroke;
  context.lineWidth = 3;
  context.stroke();
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} r */
function diamond(context, x, y, r) {
  context.beginPath();
  context.moveTo(x, y - r);
  context.lineTo(x + r, y);
  context.lineTo(x, y + r);
  context.lineTo(x - r, y);
  context.closePath();
  context.fillStyle = INK;
  context.fill();
  context.strokeStyle = "#ffffff";
  context.lineWidth = 3;
  context.stroke();
}

/** A quadcopter of a radius. @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} radius @param {string} color */
function pictureQuadcopter(context, x, y, radius, color) {
  const arm = 0.6 * radius;
  for (const [ink, grow] of /** @type {[string, number][]} */ ([["#ffffff", 0.17 * radius], ["#101418", 0]])) {
    context.strokeStyle = ink;
    context.lineWidth = 0.17 * radius + 2 * grow;
    context.lineCap = "round";
    context.beginPath();
    for (const [dx, dy] of [[arm, arm], [arm, -arm]]) {
      context.moveTo(x - dx, y - dy);
      context.lineTo(x + dx, y + dy);
    }
    context.stroke();
    for (const [dx, dy] of [[-arm, -arm], [arm, -arm], [arm, arm], [-arm, arm]]) disc(context, x + dx, y + dy, 0.36 * radius + grow, ink);
    disc(context, x, y, 0.27 * radius + grow, ink);
  }
  for (const [dx, dy] of [[-arm, -arm], [arm, -arm], [arm, arm], [-arm, arm]]) disc(context, x + dx, y + dy, 0.19 * radius, color);
}

/** Someone who looks up. @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} radius @param {string} color */
function pictureObserver(context, x, y, radius, color) {
  for (const [ink, grow] of /** @type {[string, number][]} */ ([["#ffffff", 0.17 * radius], ["#101418", 0]])) {
    disc(context, x, y - 0.45 * radius, 0.32 * radius + grow, ink);
    context.beginPath();
    for (const [dx, dy] of [[-0.3, -0.05], [0.3, -0.05], [0.55, 0.85], [-0.55, 0.85]]) context.lineTo(x + dx * radius, y + dy * radius);
    context.closePath();
    context.fillStyle = ink;
    context.fill();
    context.strokeStyle = ink;
    context.lineWidth = 2 * grow;
    context.lineJoin = "round";
    if (grow > 0) context.stroke();
  }
  disc(context, x, y - 0.45 * radius, 0.18 * radius, color);
}

/** @param {CanvasRenderingContext2D} context @param {Uav} uav @param {number} k @param {number} x @param {number} y @param {number} width */
function pictureUav(context, uav, k, x, y, width) {
  const isAlone = state.uavs.length === 1;
  (isObserver(uav) ? pictureObserver : pictureQuadcopter)(context, x, y, 23, isAlone ? "#ffffff" : hex(uavColor(k)));
  const [name, height] = [uavName(uav), heightWords(uav.height)];
  context.font = font(22, 600);
  const nameWidth = context.measureText(name).width;
  context.font = font(22);
  const whole = nameWidth + 10 + context.measureText(height).width + 20;
  const left = x + 34 + whole < width ? x + 34 : x - 34 - whole;
  context.beginPath();
  context.roundRect(left, y - 18, whole, 36, 5);
  context.fillStyle = "rgba(255, 255, 255, 0.94)";
  context.fill();
  context.strokeStyle = MUTED;
  context.lineWidth = 1;
  context.stroke();
  richText(context, name, left + 10, y + 8, font(22, 600), INK);
  richText(context, height, left + 20 + nameWidth, y + 8, font(22), INK);
}

/** Places the rows of the legend in columns. @param {CanvasRenderingContext2D} context @param {LegendRow[]} rows @param {number} width */
function placeLegend(context, rows, width) {
  context.font = font(25, 600);
  const widest = Math.max(300, ...rows.map((row) => Math.min(460, context.measureText(row.name).width)));
  const step = widest + 65 + 34;
  const perLine = Math.max(1, Math.min(2, Math.floor((width + 34) / step)));
  const items = rows.map((row, k) => ({ row, x: (k % perLine) * step, y: 72 * Math.floor(k / perLine) }));
  return { items, height: 72 * Math.ceil(rows.length / perLine) };
}

/** @param {CanvasRenderingContext2D} context @param {LegendRow} row @param {string} share @param {number} x @param {number} y */
function legendItem(context, row, share, x, y) {
  const { buildings: [low, high], away, ground, paper } = BACKDROPS.light;
  /** @type {[Rgb, Rgb]} */
  const colors = row.color ? [row.color, row.color] : row.fill === "buildings" ? [low, high] : row.fill === "away" ? [away, away] : row.fill === "ground" ? [ground, ground] : [paper, paper];
  const gradient = context.createLinearGradient(x, 0, x + 50, 0);
  colors.forEach((color, k) => gradient.addColorStop(k, hex(color)));
  context.beginPath();
  context.roundRect(x, y, 50, 50, 3);
  context.fillStyle = gradient;
  context.fill();
  if (row.fill === "hatched") {
    context.save();
    context.clip();
    context.strokeStyle = hex(BACKDROPS.light.hatch);
    context.lineWidth = 2.2;
    context.beginPath();
    for (let k = 14; k < 100; k += 14) {
      context.moveTo(x, y + k);
      context.lineTo(x + k, y);
    }
    context.stroke();
    context.restore();
    context.beginPath();
    context.roundRect(x, y, 50, 50, 3);
  }
  context.strokeStyle = "rgba(27, 31, 36, 0.45)";
  context.lineWidth = 1;
  context.stroke();
  const cells = row.cells === null ? "" : row.isReceiver && !hasNoShare() ? `${share} · ${grouped(row.cells)}` : grouped(row.cells);
  richText(context, row.name, x + 65, y + (cells ? 21 : 34), font(25, 600), INK);
  richText(context, cells, x + 65, y + 48, font(23), MUTED);
}

/** Scale bar and north arrow, right-aligned. @param {CanvasRenderingContext2D} context @param {number} right @param {number} top @param {number} perMeter */
function drawOrientation(context, right, top, perMeter) {
  const long = roundLength(200 / perMeter);
  const width = long * perMeter;
  const left = right - 96 - width;
  const text = long >= 1000 ? `${number(long / 1000, 3)} km` : `${number(long, 3)} m`;
  context.textAlign = "center";
  for (const [at, words] of /** @type {[number, string][]} */ ([[left, "0"], [left + width, text]])) richText(context, words, at, top + 22, font(23), INK);
  richText(context, "N", right - 19, top + 19, font(23, 600), INK);
  context.textAlign = "start";
  context.strokeStyle = INK;
  context.lineWidth = 1.6;
  context.fillStyle = INK;
  context.fillRect(left, top + 32, width / 2, 12);
  context.strokeRect(left, top + 32, width, 12);
  for (const side of [1, -1]) {
    context.beginPath();
    context.moveTo(right - 19, top + 26);
    context.lineTo(right - 19 + 14 * side, top + 74);
    context.lineTo(right - 19, top + 63);
    context.closePath();
    if (side > 0) context.fill();
    context.stroke();
  }
}

/** The lines below the map: what each UAV sees, how it was decided, what limits its truth. @param {MapAnswer} answer */
function captionLines(answer) {
  const words = say();
  const uavs = state.uavs.map((uav, k) => {
    const seen = answer.uavs[k];
    const place = `(${coordinate(uav.x)}, ${coordinate(uav.y)})`;
    if (!seen?.ok) return `${uavName(uav)}: ${seen?.words ?? ""}`;
    const p = seen.receivers > 0 && !seen.reason ? fixed(seen.los / seen.receivers, 4) : "–";
    const lines = seen.reason ? `; ${words.overNoData}` : "";
    return words.captionUav(uavName(uav), heightWords(uav.height), place, p, words.cellsOf(grouped(seen.los), grouped(seen.receivers))) + lines;
  });
  const { all } = answer;
  if (state.uavs.length > 1 && all.receivers > 0 && !all.reason) uavs.push(words.captionAll(fixed(all.los / all.receivers, 4)));
  const ofTrack = hasTrack() && track.seen && track.seen.stretches.length > 0 ? [[`${trackShare(track.seen)} (${words.trackLines})`, ...trackRows(track.seen).map((row) => row.words)].join("; ")] : [];
  const cell = number(grid.cell_width * grid.meters_per_unit, 3);
  const { rx_height, radius } = state.sight;
  const how = [
    (isInAir() ? words.captionAir : words.captionCells)(cell, number(rx_height, 3), receiversAbove()) + [...(radius === null ? [] : [words.captionRadius(number(radius, 3))]), ...limitsSay(state.sight)].map((part) => `, ${part}`).join(""),
    facts.crs ? facts.crs.label : words.localCoordinates,
    facts.program,
  ];
  return [...uavs, ...ofTrack, how.join("; "), ...facts.limits, ...(facts.attribution ? [facts.attribution] : [])];
}
