// @ts-check
// The share of receivers in sight against the height of the selected UAV over its place.

const curveBox = byId("curve", HTMLDetailsElement);
const curveStatus = htmlById("curve-status");

/** Shares whose least heights are told. */
const LEAST_SHARES = [0.5, 0.9];

/** The newest curve and the UAV it is of. @type {{answer: CurveAnswer, which: number} | null} */
let lastCurve = null;
/** What the newest curve was asked for, so that none is asked for twice. */
let curveKey = "";
/** What the curve on screen was drawn for. */
let drawnKey = "";

/** Grays the curve that is shown once it is that of another place. */
function markStaleCurve() {
  htmlById("curve-chart").classList.toggle("stale", curveBox.open && drawnKey !== keyOfCurve());
}

/** What a curve depends on: the place, not the height. */
const keyOfCurve = () => JSON.stringify([state.selected, selectedUav().x, selectedUav().y, state.sight]);

/** Asks for the curve of the resting UAV, while its panel is open. */
async function refreshCurve() {
  const key = keyOfCurve();
  if (!curveBox.open || !engine.opened || key === curveKey) {
    if (key === curveKey) drawCurve();
    return;
  }
  curveKey = key;
  const which = state.selected;
  const progress = (/** @type {{share: number}} */ part) => setText(curveStatus, say().working(percent(Math.round(100 * part.share), 100)));
  markStaleCurve();
  progress({ share: 0 });
  /** @type {CurveAnswer} */
  let answer;
  try {
    answer = await ask({ do: "curve", which }, progress);
  } catch (error) {
    setText(curveStatus, wordsOf(error));
    return;
  }
  if (answer.stopped) {
    // Another question came between, or something moved: then the next rest asks first.
    if (curveKey === key) curveKey = "";
    setTimeout(() => {
      if (!coverage.isAsking) void refreshCurve();
    }, 2 * REST);
    return;
  }
  if (curveKey !== key) return;
  lastCurve = { answer, which };
  drawCurve();
}

/** Where the axis of heights ends: what the slider reaches, and room above the height of now. @param {number | null} now [m above the curve's base] */
function curveEnd(now) {
  const { kind, m } = selectedUav().height;
  // The slider may measure from something else.
  const reach = kind === "agl" || now === null ? slider.high : now + slider.high - m;
  const longest = Math.max(1, reach, 1.5 * (now ?? 0));
  const step = 10 ** Math.floor(Math.log10(longest)) / 2;
  return Math.ceil(longest / step - 1e-6) * step;
}

/** Draws the newest curve with the height of now. */
function drawCurve() {
  if (!lastCurve || !curveBox.open || curveKey !== keyOfCurve()) return;
  const { answer } = lastCurve;
  const words = say();
  const seen = coverage.answer?.uavs[lastCurve.which];
  if (seen?.ok && seen.reason) {
    htmlById("curve-chart").replaceChildren();
    setText(curveStatus, sayOf(selectedUav()).overNoData);
    drawnKey = keyOfCurve();
    return;
  }
  const base = answer.ground_m ?? 0;
  const above = answer.heights_m.map((h) => h - base);
  const shares = answer.los.map((los) => (answer.receivers > 0 ? los / answer.receivers : 0));
  const now = seen?.ok ? seen.amsl_m - base : null;
  const xMax = curveEnd(now);
  const xMin = Math.min(answer.ground_m === null ? answer.lowest_m : 0, above[0] ?? 0);
  const chart = makeChart({
    width: 320, height: 210, xRange: [xMin, xMax], yRange: [0, 1],
    yTicks: [0, 0.25, 0.5, 0.75, 1].map((v) => [v, `${100 * v}${THIN}%`]),
    xName: sayOf(selectedUav()).heightAxis(answer.ground_m !== null), yName: words.share, label: words.curve,
  });
  const points = above.map((h, k) => [h, shares[k]]).filter(([h]) => h <= xMax);
  const next = above.findIndex((h) => h > xMax);
  // The line reaches the frame; above its last height the share stays.
  if (next > 0) {
    const t = (xMax - above[next - 1]) / (above[next] - above[next - 1]);
    points.push([xMax, shares[next - 1] + t * (shares[next] - shares[next - 1])]);
  } else if (next < 0 && points.length > 0) points.push([xMax, points[points.length - 1][1]]);
  chart.plot.append(draw("polyline", { class: "curve", points: points.map(([h, s]) => `${chart.x(h).toFixed(1)},${chart.y(s).toFixed(1)}`).join(" ") }));
  if (seen?.ok && now !== null && now <= xMax && seen.p_los !== null) {
    const [px, py] = [chart.x(now), chart.y(seen.p_los)];
    chart.plot.append(draw("path", { class: "guide", d: `M${chart.left} ${py}H${px}V${chart.bottom}` }), draw("circle", { class: "now", cx: px, cy: py, r: 5 }));
    chartLabel(chart, px, py < chart.top + 50 ? py + 10 : py - 28, `${meters(now)}: ${percent(seen.los, seen.receivers)}`);
  }
  htmlById("curve-chart").replaceChildren(chart.svg);
  drawnKey = keyOfCurve();
  markStaleCurve();
  const least = LEAST_SHARES.map((share) => {
    const k = answer.los.findIndex((los) => los >= share * answer.receivers);
    const part = `${100 * share}${THIN}%`;
    return k < 0 ? words.curveNever(part) : words.curveSays(part, meters(above[k], 0));
  });
  setText(curveStatus, answer.receivers > 0 ? `${words.leastHeights} ${least.join(" · ")}` : words.noReceivers);
}
