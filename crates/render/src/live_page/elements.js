// @ts-check
// Elements of the page: found by id, made with text. Text is always a text node, so that words of the data are never markup.

/**
 * The element of an id, which the template has.
 * @template {Element} T
 * @param {string} id
 * @param {new () => T} kind
 * @returns {T}
 */
function byId(id, kind) {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

const htmlById = (/** @type {string} */ id) => byId(id, HTMLElement);
const inputById = (/** @type {string} */ id) => byId(id, HTMLInputElement);
const selectById = (/** @type {string} */ id) => byId(id, HTMLSelectElement);
const buttonById = (/** @type {string} */ id) => byId(id, HTMLButtonElement);

/**
 * Makes an element with attributes and content.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | number | boolean>} [attributes] true is an attribute without a value, false none
 * @param {...(Node | string)} content
 * @returns {HTMLElementTagNameMap[K]}
 */
function make(tag, attributes = {}, ...content) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== false) element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...content);
  return element;
}

/**
 * Makes an element of a drawing.
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | number>} [attributes]
 * @param {...(Node | string)} content
 * @returns {SVGElementTagNameMap[K]}
 */
function draw(tag, attributes = {}, ...content) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...content);
  return element;
}

/**
 * Sets the text of an element if it is another, so that nothing is laid out again without need.
 * @param {Element} element
 * @param {string} text
 */
function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * Sets the value of a control, unless it is being typed into.
 * @param {HTMLInputElement | HTMLSelectElement} control
 * @param {string} value
 */
function setValue(control, value) {
  if (control !== document.activeElement || control.type === "range" || control instanceof HTMLSelectElement) {
    if (control.value !== value) control.value = value;
  }
}

/**
 * Someone who looks up, in a square of 48; the head has the UAV's color.
 * @param {string} color
 * @returns {SVGSVGElement}
 */
function observer(color) {
  const body = (/** @type {string} */ ink, /** @type {number} */ grow) => draw("g", { fill: ink, stroke: ink, "stroke-width": 2 * grow, "stroke-linejoin": "round" },
    draw("circle", { cx: 24, cy: 14, r: 7.5 }), draw("path", { d: "M17 23H31L37 43H11Z" }));
  return draw("svg", { viewBox: "-1 -1 50 50", "aria-hidden": "true" },
    body("#ffffff", 3), body("#101418", 0), draw("circle", { cx: 24, cy: 14, r: 4.2, fill: color }));
}

/** The symbol of who looks. @param {Uav} uav @param {number} k */
const symbolOf = (uav, k) => (isObserver(uav) ? observer : quadcopter)(hex(uavColor(k)));

/**
 * A quadcopter from above in a square of 48; the rotors have the UAV's color.
 * @param {string} color
 * @returns {SVGSVGElement}
 */
function quadcopter(color) {
  const corners = [[10, 10], [38, 10], [38, 38], [10, 38]];
  const body = (/** @type {string} */ ink, /** @type {number} */ grow) => draw("g", { fill: ink, stroke: ink },
    draw("path", { d: "M10 10L38 38M38 10L10 38", "stroke-width": 4 + 2 * grow, "stroke-linecap": "round" }),
    ...corners.map(([x, y]) => draw("circle", { cx: x, cy: y, r: 8 + grow, stroke: "none" })),
    draw("circle", { cx: 24, cy: 24, r: 6.5 + grow, stroke: "none" }));
  return draw("svg", { viewBox: "-1 -1 50 50", "aria-hidden": "true", class: "quadcopter" },
    body("#ffffff", 3), body("#101418", 0),
    ...corners.map(([x, y]) => draw("circle", { cx: x, cy: y, r: 4.8, fill: color })),
    draw("circle", { cx: 24, cy: 24, r: 2.2, fill: color }));
}
