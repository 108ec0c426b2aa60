// @ts-check
// A frame with axes, as the program's charts have it, for the side view and the curve.

/**
 * @typedef {{svg: SVGSVGElement, plot: SVGGElement, x: (v: number) => number, y: (v: number) => number, left: number,
 *   right: number, top: number, bottom: number}} Chart
 */

/**
 * Makes an empty chart.
 * @param {{width: number, height: number, xRange: [number, number], yRange: [number, number], xName: string, yName: string,
 *   label: string, xTicks?: [number, string][], yTicks?: [number, string][]}} look label: for screen readers
 * @returns {Chart}
 */
function makeChart({ width, height, xRange, yRange, xName, yName, label, xTicks, yTicks }) {
  const [left, right, top, bottom] = [50, width - 10, 10, height - 38];
  const x = (/** @type {number} */ v) => left + ((v - xRange[0]) / (xRange[1] - xRange[0])) * (right - left);
  const y = (/** @type {number} */ v) => bottom - ((v - yRange[0]) / (yRange[1] - yRange[0])) * (bottom - top);
  const grid = draw("g", { class: "grid" });
  const numbers = draw("g", { class: "numbers" });
  const frame = draw("rect", { class: "frame", x: left, y: top, width: right - left, height: bottom - top });
  for (const [value, text] of xTicks ?? ticks(xRange[0], xRange[1], width / 90)) {
    if (value < xRange[0] || value > xRange[1]) continue;
    grid.append(draw("path", { d: `M${x(value)} ${bottom}v4` }));
    numbers.append(draw("text", { x: x(value), y: bottom + 16, "text-anchor": "middle" }, text));
  }
  for (const [value, text] of yTicks ?? ticks(yRange[0], yRange[1], (bottom - top) / 34)) {
    if (value < yRange[0] || value > yRange[1]) continue;
    grid.append(draw("path", { class: "across", d: `M${left} ${y(value)}H${right}` }));
    numbers.append(draw("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, text));
  }
  const plot = draw("g");
  const names = draw("g", { class: "names" },
    draw("text", { x: (left + right) / 2, y: height - 4, "text-anchor": "middle" }, xName),
    draw("text", { transform: `translate(11 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, yName));
  const svg = draw("svg", { class: "chart", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label }, grid, plot, frame, numbers, names);
  return { svg, plot, x, y, left, right, top, bottom };
}

/**
 * Puts words beside a point of a chart, inside its frame.
 * @param {Chart} chart
 * @param {number} px
 * @param {number} py
 * @param {string} text
 */
function chartLabel({ plot, left, right, top, bottom }, px, py, text) {
  // Measured before it is shown: system fonts are about this wide.
  const width = 6.4 * text.length + 12;
  const x = within(px - width / 2, left + 3, Math.max(left + 3, right - width - 3));
  const y = within(py, top + 3, bottom - 21);
  plot.append(draw("g", { class: "label" },
    draw("rect", { x, y, width, height: 18, rx: 3 }),
    draw("text", { x: x + width / 2, y: y + 13, "text-anchor": "middle" }, text)));
}
