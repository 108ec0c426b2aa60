"use strict";
// The state of the page is a, b, at, layers and zoom. It lives in the URL's fragment, the controls show it, and draw()
// paints it. Masks are pictures of one pixel per cell; their colors are the classes.

(() => {
  const byId = (id) => document.getElementById(id);
  const view = JSON.parse(byId("view").textContent);
  const themes = ["los", "difference", "count"];
  const NLOS = 0, LOS = 1, OTHER = 2;
  const masks = [...document.querySelectorAll("img.mask")];
  const cache = new Map();
  const state = { a: 0, b: 1, at: 0.5, buildings: true, theme: "los", zoom: 1 };

  // Classes of a mask, by color: blue is line of sight, orange none; all else is no receiver. Browsers may alter colors by
  // a step or two, which changes no answer.
  function classes(k) {
    if (!cache.has(k)) {
      const canvas = document.createElement("canvas");
      canvas.width = view.cols;
      canvas.height = view.rows;
      const context = canvas.getContext("2d", { willReadFrequently: true });
      context.drawImage(masks[k], 0, 0);
      const pixels = context.getImageData(0, 0, view.cols, view.rows).data;
      const found = new Uint8Array(view.cols * view.rows).fill(OTHER);
      for (let i = 0, p = 0; i < found.length; i += 1, p += 4) {
        if (pixels[p + 3] < 128) continue;
        const excess = pixels[p + 2] - pixels[p];
        if (excess > 100) found[i] = LOS;
        else if (excess < -100) found[i] = NLOS;
      }
      cache.set(k, found);
    }
    return cache.get(k);
  }

  // What A and B see of a cell: bit 0 for A, bit 1 for B; 4 if it is not a receiver of both.
  const pairOf = (a, b) => (a === OTHER || b === OTHER ? 4 : a + 2 * b);

  function paint(canvas, indexOf, palette) {
    canvas.width = view.cols;
    canvas.height = view.rows;
    const context = canvas.getContext("2d");
    const image = context.createImageData(view.cols, view.rows);
    const colors = palette.map((hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)));
    for (let i = 0, p = 0; p < image.data.length; i += 1, p += 4) {
      const color = colors[indexOf(i)];
      if (!color) continue;
      image.data[p] = color[0];
      image.data[p + 1] = color[1];
      image.data[p + 2] = color[2];
      image.data[p + 3] = 255;
    }
    context.putImageData(image, 0, 0);
  }

  // Paints what the theme shows; moving the line needs none of this.
  function draw() {
    const [a, b] = [classes(state.a), classes(state.b)];
    if (state.theme === "los") {
      paint(byId("left"), (i) => a[i], view.colors.los);
      paint(byId("right"), (i) => b[i], view.colors.los);
    } else if (state.theme === "difference") {
      paint(byId("left"), (i) => pairOf(a[i], b[i]), view.colors.pair);
    } else {
      const all = masks.map((_, k) => classes(k));
      const seen = (i) => {
        let count = 0;
        let receiver = false;
        for (const mask of all) {
          count += mask[i] === LOS;
          receiver ||= mask[i] !== OTHER;
        }
        return receiver ? count : -1;
      };
      paint(byId("left"), seen, view.colors.count);
    }
    tell(a, b);
  }

  // Says P_LoS of A and B and the shares of their difference, counted from the pixels.
  function tell(a, b) {
    const share = (id, k, mask) => {
      let receivers = 0;
      let los = 0;
      for (const value of mask) {
        receivers += value !== OTHER;
        los += value === LOS;
      }
      const output = byId(id);
      output.dataset.receivers = receivers;
      output.dataset.los = los;
      output.dataset.pLos = receivers ? los / receivers : "";
      const index = document.createElement("sub");
      index.textContent = "LoS";
      const value = receivers ? rounded(los / receivers, 4) : "undefined: no receiver";
      output.replaceChildren(`${id === "share-a" ? "A" : "B"}: ${view.labels[k]}, P`, index, ` ${value}`);
    };
    share("share-a", state.a, a);
    share("share-b", state.b, b);
    const counts = [0, 0, 0, 0, 0];
    for (let i = 0; i < a.length; i += 1) counts[pairOf(a[i], b[i])] += 1;
    const compared = counts[0] + counts[1] + counts[2] + counts[3];
    for (const output of document.querySelectorAll("output[data-pair]")) {
      const count = counts[Number(output.dataset.pair)];
      output.dataset.cells = count;
      output.textContent = compared ? shareWords(count, compared) : "";
    }
  }

  // Brings the controls, the line and the fragment into agreement with the state.
  function show() {
    for (const id of ["a", "b"]) {
      // Attributes follow the controls, so that a saved page looks the same.
      [...byId(id).options].forEach((option, k) => option.toggleAttribute("selected", k === state[id]));
      byId(id).selectedIndex = state[id];
    }
    for (const input of document.querySelectorAll('input[name="layer"]')) {
      input.checked = input.value === "buildings" ? state.buildings : input.value === state.theme;
    }
    for (const input of document.querySelectorAll('input[name="zoom"]')) input.checked = Number(input.value) === state.zoom;
    for (const name of document.querySelectorAll("[data-name]")) name.textContent = view.ids[state[name.dataset.name]];
    document.documentElement.dataset.theme = state.theme;
    byId("backdrop").style.visibility = state.buildings ? "visible" : "hidden";
    document.querySelectorAll(".mark").forEach((mark) => {
      const k = Number(mark.dataset.placement);
      mark.classList.toggle("shown", state.theme === "count" || k === state.a || k === state.b);
    });
    const [a, b] = [view.labels[state.a], view.labels[state.b]];
    byId("left").setAttribute("aria-label", { los: `what ${a} sees`, difference: `difference from ${a} to ${b}`, count: "how many see each cell" }[state.theme]);
    byId("right").setAttribute("aria-label", `what ${b} sees`);
    const range = byId("at");
    const percent = Math.round(100 * state.at);
    range.setAttribute("value", state.at);
    range.value = state.at;
    range.disabled = state.theme !== "los";
    range.setAttribute("aria-valuetext", `${a} on the left ${percent} %, ${b} on the right ${100 - percent} %`);
    byId("stage").style.setProperty("--at", `${100 * state.at}%`);
    byId("stage").style.setProperty("--zoom", state.zoom);
    scale();
    const layers = [...(state.buildings ? ["buildings"] : []), state.theme].join(",");
    const words = [["a", view.ids[state.a]], ["b", view.ids[state.b]], ["at", state.at], ["layers", layers], ["zoom", state.zoom]];
    const fragment = words.map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&");
    if (location.hash.slice(1) !== fragment) history.replaceState(null, "", `#${fragment}`);
  }

  // Reads the fragment; what it does not say, or says wrongly, stays as it is.
  function read() {
    const words = new URLSearchParams(location.hash.slice(1));
    const placement = (name) => {
      const k = view.ids.indexOf(words.get(name));
      if (k >= 0) state[name] = k;
    };
    placement("a");
    placement("b");
    const at = parseFloat(words.get("at"));
    if (at >= 0 && at <= 1) state.at = at;
    if (words.has("layers")) {
      const layers = words.get("layers").split(",");
      state.buildings = layers.includes("buildings");
      state.theme = themes.find((theme) => layers.includes(theme)) ?? state.theme;
    }
    const zoom = Number(words.get("zoom"));
    if ([1, 2, 4, 8].includes(zoom)) state.zoom = zoom;
  }

  // A bar of 1, 2 or 5 times a power of ten, about 120 pixels long.
  function scale() {
    const perMeter = byId("stage").clientWidth / view.width_m;
    if (!perMeter) return;
    const wanted = 120 / perMeter;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((digit) => digit * power).find((length) => length <= wanted);
    byId("bar").style.width = `${length * perMeter}px`;
    byId("length").textContent = length >= 1000 ? `${length / 1000} km` : `${length} m`;
  }

  // Changes the zoom and keeps the middle of the frame where it is.
  function zoomTo(zoom) {
    const frame = byId("viewport");
    const middle = [
      (frame.scrollLeft + frame.clientWidth / 2) / frame.scrollWidth,
      (frame.scrollTop + frame.clientHeight / 2) / frame.scrollHeight,
    ];
    state.zoom = zoom;
    show();
    frame.scrollLeft = middle[0] * frame.scrollWidth - frame.clientWidth / 2;
    frame.scrollTop = middle[1] * frame.scrollHeight - frame.clientHeight / 2;
  }

  // The cell under a pointer, as a fraction of the map.
  function fraction(event) {
    const box = byId("stage").getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  function say(event) {
    const [x, y] = fraction(event);
    if (x < 0 || y < 0 || x >= 1 || y >= 1) return;
    const [col, row] = [Math.floor(x * view.cols), Math.floor(y * view.rows)];
    const words = ["no line of sight", "line of sight", "no receiver"];
    const seen = [state.a, state.b].map((k) => `${view.ids[k]}: ${words[classes(k)[row * view.cols + col]]}`);
    const cell = (k, n) => Math.min(k * view.step + Math.floor(view.step / 2), n - 1);
    const east = view.x_min + (cell(col, view.grid_cols) + 0.5) * view.cell_width;
    const north = view.y_max - (cell(row, view.grid_rows) + 0.5) * view.cell_height;
    byId("cursor").textContent = `x ${+east.toFixed(2)}, y ${+north.toFixed(2)}; ${seen.join("; ")}`;
  }

  // Dragging the line swipes; dragging the map with a mouse pans it. Fingers pan by scrolling.
  function listen() {
    byId("a").addEventListener("change", (event) => { state.a = event.target.selectedIndex; show(); draw(); });
    byId("b").addEventListener("change", (event) => { state.b = event.target.selectedIndex; show(); draw(); });
    byId("at").addEventListener("input", (event) => { state.at = Number(event.target.value); show(); });
    byId("controls").addEventListener("submit", (event) => event.preventDefault());
    for (const input of document.querySelectorAll('input[name="layer"]')) {
      input.addEventListener("change", () => {
        if (input.value === "buildings") state.buildings = input.checked;
        else state.theme = input.value;
        show();
        draw();
      });
    }
    for (const input of document.querySelectorAll('input[name="zoom"]')) {
      input.addEventListener("change", () => zoomTo(Number(input.value)));
    }
    const [divider, stage, frame] = [byId("divider"), byId("stage"), byId("viewport")];
    divider.addEventListener("pointerdown", (event) => {
      divider.setPointerCapture(event.pointerId);
      event.preventDefault();
      event.stopPropagation();
    });
    divider.addEventListener("pointermove", (event) => {
      if (!divider.hasPointerCapture(event.pointerId)) return;
      state.at = Math.round(1000 * Math.min(1, Math.max(0, fraction(event)[0]))) / 1000;
      show();
    });
    stage.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "mouse" && state.zoom > 1) stage.setPointerCapture(event.pointerId);
    });
    stage.addEventListener("pointermove", (event) => {
      say(event);
      if (stage.hasPointerCapture(event.pointerId)) frame.scrollBy(-event.movementX, -event.movementY);
    });
    window.addEventListener("resize", scale);
    window.addEventListener("hashchange", () => { read(); show(); draw(); });
  }

  // Pictures in the file are loaded by then.
  window.addEventListener("load", () => {
    read();
    const { zoom } = state;
    state.zoom = 1;
    show();
    zoomTo(zoom);
    draw();
    listen();
    document.documentElement.dataset.ready = "true";
  });

  // The live page is packed in this one; its address tells where the UAVs of A and B are, and for whom.
  async function openLive() {
    const bytes = Uint8Array.from(atob(byId("live-page").textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const page = await new Response(stream).blob();
    const { sight, uavs } = view.live;
    const word = (k) => uavs[k] && `${uavs[k]},${encodeURIComponent(view.ids[k])}`;
    const shown = [state.a, state.b].filter((k) => uavs[k]);
    const kept = shown.map((k) => `kept=${encodeURIComponent(view.ids[k])}:${sight}:${word(k)}`);
    const address = [`uavs=${word(shown[shown.length - 1])}`, `sight=${sight}`, ...kept].join("&");
    window.open(`${URL.createObjectURL(new Blob([page], { type: "text/html" }))}#${address}`);
  }
  const live = byId("live");
  if (live) {
    const allow = () => { live.disabled = !view.live.uavs[state.a] && !view.live.uavs[state.b]; };
    live.addEventListener("click", openLive);
    byId("controls").addEventListener("change", allow);
    allow();
  }
})();
