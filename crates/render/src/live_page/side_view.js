// @ts-check
// The link from the selected UAV to a receiver: on the map as a line, and from the side with what blocks it.

const drawer = htmlById("drawer");

/** The receiver of the open link. @type {{x: number, y: number} | null} */
let linkPlace = null;

const askLink = newestOnly(
  () => linkPlace && { do: "link", which: shown().which, x: linkPlace.x, y: linkPlace.y },
  (/** @type {LinkAnswer} */ answer) => {
    if (linkPlace) showLink(answer);
  },
);

/** The cell of the open link, which says whether it holds a receiver. @type {CellAnswer | null} */
let linkCell = null;

const askLinkCell = newestOnly(
  () => linkPlace && { do: "cell", which: shown().which, x: linkPlace.x, y: linkPlace.y },
  (/** @type {CellAnswer} */ cell) => {
    linkCell = cell;
    if (linkPlace && lastLink) describeLink(lastLink);
  },
);

/** Asks for the open link anew. */
function refreshLink() {
  if (!linkPlace) return;
  askLinkCell();
  askLink();
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let roomTimer;

/** Opens the link to the receiver at a place. @param {number} x @param {number} y */
function openLink(x, y) {
  closeLink();
  if (!engine.opened || x < grid.x_min || x > X_MAX || y < Y_MIN || y > grid.y_max) return;
  linkPlace = { x, y };
  showTrack();
  refreshLink();
  // The map moves after a second click would have come, which zooms about its place.
  roomTimer = setTimeout(makeRoomForLink, DOUBLE_CLICK.ms + 30);
}

/** Moves the map so that the side view covers neither end of the link. */
function makeRoomForLink() {
  const { link } = overlay;
  if (!link || drawer.hidden || presses.size > 0) return;
  glideToPlaces([link.uav, link.receiver], roomAbove(drawer));
}

/** The part of the map between its buttons and a side view [px]. @param {HTMLElement} side */
function roomAbove(side) {
  const edge = (/** @type {HTMLElement} */ box) => box.getBoundingClientRect();
  const { top } = edge(mapBox);
  const bottom = side.hidden ? screenSize.height : edge(side).top - top;
  return { left: 40, right: screenSize.width - 40, top: edge(htmlById("actions")).bottom - top + 32, bottom: bottom - 32 };
}

function closeLink() {
  clearTimeout(roomTimer);
  linkPlace = linkCell = lastLink = overlay.link = null;
  drawer.hidden = true;
  placeLines();
  showTrack();
}

/** The newest answer, drawn anew when the language or the size changes. @type {LinkAnswer | null} */
let lastLink = null;

/** @param {LinkAnswer} link */
function showLink(link) {
  lastLink = link;
  overlay.link = link.ok ? link : null;
  drawer.hidden = false;
  placeLines();
  describeLink(link);
  htmlById("link-chart").replaceChildren(...(link.ok ? [sideView(link)] : []));
}

/** Says what the link is, and what is wanted of its receiver. @param {LinkAnswer} link */
function describeLink(link) {
  const words = say();
  const verdict = htmlById("link-verdict");
  verdict.classList.toggle("los", link.ok && link.los);
  verdict.classList.toggle("nlos", link.ok && !link.los);
  const { which } = shown();
  setText(verdict, `${uavName(state.uavs[which])}: ${!link.ok ? link.words : link.los ? words.linkSees : blockedWords(link.obstruction)}`);
  const isEmpty = linkCell?.inside && linkCell.kind !== "void" && linkCell.sees[which] === null;
  const parts = !link.ok ? [] : [
    ...(isEmpty ? [linkCell?.kind === "building" ? words.shownOnRoof : words.shownOnGround] : []),
    link.margin_m === null ? "" : marginWords(link.margin_m, state.sight.rx_height),
    `${words.distance} ${lengthWords(link.distance_m)}`,
    `${words.elevation} ${number(link.elevation_deg, 1)}°`,
  ];
  setText(htmlById("link-details"), parts.filter(Boolean).join(" · "));
}

/** How far along a link its obstruction lies, 0 to 1 from the UAV. @param {LinkSeen} link @param {Obstruction} at */
const partOf = ({ uav, distance_m }, at) => (Math.hypot(at.x - uav.x, at.y - uav.y) * grid.meters_per_unit) / Math.max(distance_m, 0.01);

/** How far along a link its ray first meets a roof or the ground, 0 to 1 from the UAV; 1 in sight. @param {LinkSeen} link */
function clearPart(link) {
  if (link.los) return 1;
  const { uav, receiver, obstruction, distance_m, steps } = link;
  const heightAt = (/** @type {number} */ d) => uav.amsl_m + ((receiver.amsl_m - uav.amsl_m) * d) / Math.max(distance_m, 0.01);
  const met = steps.flatMap(({ from_m, to_m, heights_m }) => {
    // How far the ray is above the step where it starts and where it ends.
    const [start, end] = [heightAt(from_m) - heights_m[0], heightAt(to_m) - heights_m[1]];
    // What only touches the ray does not end it.
    if (Math.min(start, end) > -0.01) return [];
    return start <= 0 ? [from_m] : [from_m + ((to_m - from_m) * start) / (start - end)];
  });
  return Math.min(obstruction ? partOf(link, obstruction) : 1, ...met.map((d) => d / Math.max(distance_m, 0.01)));
}

/**
 * Whether a building has this height at its start (0) or its end (1) somewhere along a link.
 * @param {LinkSeen} link @param {number} at_m @param {number} height_m @param {0 | 1} end
 */
const goesOn = (link, at_m, height_m, end) => link.steps.some((step) => step.kind === "building"
  && Math.abs([step.from_m, step.to_m][end] - at_m) < 1e-6 && Math.abs(step.heights_m[end] - height_m) < 1e-3);

/** @param {Pick<Obstruction, "kind" | "name"> | null} obstruction */
function blockedWords(obstruction) {
  const words = say();
  if (!obstruction) return words.linkBlocked;
  if (obstruction.kind === "building" && obstruction.name) return words.blockedByNamed(obstruction.name);
  return words.blockedBy[obstruction.kind];
}

/**
 * Draws a link from the side.
 * @param {LinkSeen} link
 * @returns {SVGSVGElement}
 */
function sideView(link) {
  const words = say();
  const width = Math.max(300, htmlById("link-chart").clientWidth);
  const height = width < 480 ? 190 : 220;
  const long = Math.max(link.distance_m, 0.01);
  const heights = [link.uav.amsl_m, link.receiver.amsl_m, ...link.steps.flatMap((step) => step.heights_m)];
  const [low, high] = [Math.min(...heights), Math.max(...heights)];
  const span = Math.max(high - low, 1);
  const chart = makeChart({
    width, height,
    xRange: [-0.06 * long, 1.06 * long],
    yRange: [low - 0.1 * span, high + 0.16 * span],
    xTicks: ticks(0, long, width / 90),
    xName: sayOf(state.uavs[shown().which]).distanceAxis,
    yName: words.heightAboveDatum,
    label: `${words.link}: ${link.los ? words.linkSees : blockedWords(link.obstruction)}`,
  });
  const { plot, x, y, bottom } = chart;
  for (const kind of ["terrain", "building"]) {
    for (const step of link.steps.filter((each) => each.kind === kind)) {
      const [x0, x1] = [x(step.from_m), x(step.to_m)];
      const [y0, y1] = step.heights_m.map(y);
      if (!(x1 > x0)) continue;
      plot.append(draw("path", { class: kind, d: `M${x0} ${bottom}V${y0}L${x1} ${y1}V${bottom}Z` }));
      // A roof that goes on in another slope has no wall there, and ground has none.
      const start = kind === "terrain" || goesOn(link, step.from_m, step.heights_m[0], 1) ? "" : `M${x0} ${bottom}L`;
      const end = kind === "terrain" || goesOn(link, step.to_m, step.heights_m[1], 0) ? "" : `V${bottom}`;
      plot.append(draw("path", { class: `${kind}-top`, d: `${start || "M"}${x0} ${y0}L${x1} ${y1}${end}` }));
    }
  }
  const [uav, receiver] = [[x(0), y(link.uav.amsl_m)], [x(long), y(link.receiver.amsl_m)]];
  const ray = (/** @type {number[]} */ from, /** @type {number[]} */ to, /** @type {string} */ kind) =>
    plot.append(draw("line", { class: kind, x1: from[0], y1: from[1], x2: to[0], y2: to[1] }));
  const clear = clearPart(link);
  const met = [x(clear * long), uav[1] + clear * (receiver[1] - uav[1])];
  ray(uav, receiver, "casing");
  ray(uav, met, "clear");
  if (!link.los) ray(met, receiver, "blocked");
  if (!isInAir()) plot.append(draw("circle", { class: "receiver", cx: receiver[0], cy: receiver[1], r: 5 }));
  const stop = link.obstruction;
  if (stop) {
    const roof = stop.roof_height_m;
    const onRay = [x(partOf(link, stop) * long), y(stop.ray_height_m)];
    if (roof !== null) ray(onRay, [onRay[0], y(roof)], "obstruction-line");
    plot.append(draw("path", { class: "obstruction", transform: `translate(${onRay[0]} ${roof === null ? onRay[1] : y(roof)})`, d: "M0 -7L7 0L0 7L-7 0Z" }));
    plot.append(draw("circle", { class: "on-ray", cx: onRay[0], cy: onRay[1], r: 4 }));
    if (roof !== null) chartLabel(chart, onRay[0], y(roof) - 28, `${words.roof} ${meters(roof)}, ${words.ray} ${meters(stop.ray_height_m)}`);
  }
  /** @param {SVGSVGElement} symbol @param {number[]} at */
  const put = (symbol, [px, py]) => {
    for (const [name, value] of Object.entries({ x: px - 13, y: py - 13, width: 26, height: 26 })) symbol.setAttribute(name, String(value));
    plot.append(symbol);
  };
  const { which } = shown();
  put(symbolOf(state.uavs[which], which), uav);
  // What is looked at from there is a drone.
  if (isInAir()) put(quadcopter("#ffffff"), receiver);
  return chart.svg;
}
