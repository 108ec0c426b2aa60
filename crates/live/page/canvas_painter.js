// @ts-check
// Paints the map without WebGL, or where WebGL would be computed by the processor, which is slower than this: each pixel of
// the visible part is looked up, or averaged from two by two cells.
//
// Colors are numbers of 32 bits: red in the lowest byte, opacity in the highest, as pixels lie in memory on all machines of
// today. 0 is a cell without data.

/**
 * A painter on a canvas.
 * @param {HTMLCanvasElement} canvas
 * @returns {Painter}
 */
function canvasPainter(canvas) {
  const { n_cols, n_rows } = grid;
  const held = {
    /** @type {Uint8Array | null} */ tone: null,
    /** @type {Uint8Array} */ mask: new Uint8Array(0),
    /** Colors by class (high byte) and tone. */ looks: new Uint32Array(65536),
    /** Class 2 for all cells, until there is a mask. @type {Uint8Array | null} */ bare: null,
    hasMask: false,
    paper: 0,
    stripes: 0,
    /** @type {ImageData | null} */ image: null,
    /** Columns of the samples of each pixel across; −1 outside the map. */ cols: new Int32Array(0),
  };
  const packed = (/** @type {Rgb} */ [r, g, b]) => (r | (g << 8) | (b << 16) | (255 << 24)) >>> 0;

  /** The average of four colors. @param {number} a @param {number} b @param {number} c @param {number} d */
  const average = (a, b, c, d) => {
    // Two channels at a time have room for their sum.
    const low = (a & 0xff00ff) + (b & 0xff00ff) + (c & 0xff00ff) + (d & 0xff00ff);
    const high = ((a >>> 8) & 0xff00ff) + ((b >>> 8) & 0xff00ff) + ((c >>> 8) & 0xff00ff) + ((d >>> 8) & 0xff00ff);
    return (((low >>> 2) & 0xff00ff) | (((high >>> 2) & 0xff00ff) << 8)) >>> 0;
  };

  /** @param {Uint32Array} pixels @param {MapWindow} window */
  function fill(pixels, window) {
    const { width, height, stripePx } = window;
    const { tone, looks, cols, paper, stripes } = held;
    const mask = held.hasMask ? held.mask : held.bare;
    if (!tone || !mask) {
      pixels.fill(paper);
      return;
    }
    for (let k = 0; k < 2 * width; k += 1) {
      const col = Math.floor(window.col + (k / 2 + 0.25) * window.colsPerPx);
      cols[k] = col < 0 || col >= n_cols ? -1 : col;
    }
    const thick = 0.21 * stripePx;
    let [lastAbove, lastBelow] = [-2, -2];
    for (let y = 0, at = 0; y < height; y += 1) {
      const above = Math.floor(window.row + (y + 0.25) * window.rowsPerPx);
      const below = Math.floor(window.row + (y + 0.75) * window.rowsPerPx);
      // Stripes differ from row to row, but not where the last row had none.
      if (above === lastAbove && below === lastBelow) {
        pixels.copyWithin(at, at - width, at);
        at += width;
        continue;
      }
      const isOutside = above < 0 || below >= n_rows;
      const [first, second] = [above * n_cols, below * n_cols];
      let hasStripes = false;
      for (let x = 0; x < width; x += 1, at += 1) {
        const [left, right] = [cols[2 * x], cols[2 * x + 1]];
        if (isOutside || left < 0 || right < 0) {
          pixels[at] = paper;
          continue;
        }
        const a = looks[(mask[first + left] << 8) | tone[first + left]];
        const b = looks[(mask[first + right] << 8) | tone[first + right]];
        const c = looks[(mask[second + left] << 8) | tone[second + left]];
        const d = looks[(mask[second + right] << 8) | tone[second + right]];
        if (a === b && a === c && a === d && a !== 0) pixels[at] = a;
        else if (a !== 0 && b !== 0 && c !== 0 && d !== 0) pixels[at] = average(a, b, c, d);
        else {
          // Of a pixel at the edge of the data, the cells that have some decide, if they are at least half.
          const known = [a, b, c, d].filter((color) => color !== 0);
          hasStripes ||= known.length < 2;
          if (known.length >= 2) pixels[at] = average(known[0], known[1], known[2] ?? known[0], known[known.length - 1]);
          else pixels[at] = (x + y) % stripePx < thick ? stripes : paper;
        }
      }
      [lastAbove, lastBelow] = hasStripes ? [-2, -2] : [above, below];
    }
  }

  /** @param {ImageData} image @param {MapWindow} window */
  function paintOn(image, window) {
    if (held.cols.length < 2 * window.width) held.cols = new Int32Array(2 * window.width);
    fill(new Uint32Array(image.data.buffer), window);
    return image;
  }

  /** Draws lines between large cells. @param {CanvasRenderingContext2D} context @param {MapWindow} window */
  function hairlines(context, { col, row, colsPerPx, rowsPerPx, width, height, pxPerPoint }) {
    if (1 / Math.max(colsPerPx, rowsPerPx) < 24 * pxPerPoint) return;
    context.fillStyle = "rgb(16 20 24 / 16%)";
    const at = (/** @type {number} */ line, /** @type {number} */ first, /** @type {number} */ perPx) => Math.round((line - first) / perPx);
    const [left, right] = [Math.max(0, at(0, col, colsPerPx)), Math.min(width, at(n_cols, col, colsPerPx))];
    const [top, bottom] = [Math.max(0, at(0, row, rowsPerPx)), Math.min(height, at(n_rows, row, rowsPerPx))];
    for (let line = Math.max(0, Math.ceil(col)); line <= Math.min(n_cols, col + width * colsPerPx); line += 1) {
      context.fillRect(at(line, col, colsPerPx), top, pxPerPoint, bottom - top);
    }
    for (let line = Math.max(0, Math.ceil(row)); line <= Math.min(n_rows, row + height * rowsPerPx); line += 1) {
      context.fillRect(left, at(line, row, rowsPerPx), right - left, pxPerPoint);
    }
  }

  return {
    setTone(tone) {
      held.tone = tone;
      held.bare = new Uint8Array(tone.length).fill(NO_MASK_ROW);
    },
    setMask(mask) {
      held.hasMask = mask !== null;
      if (!mask) return;
      if (held.mask.length !== mask.length) held.mask = new Uint8Array(mask.length);
      held.mask.set(mask);
    },
    setLooks(looks, backdrop) {
      const colors = new Uint32Array(looks.buffer);
      for (let value = 0; value < 256; value += 1) {
        const row = Math.min(value, NO_DATA_ROW);
        held.looks.set(colors.subarray(256 * row, 256 * (row + 1)), 256 * value);
      }
      held.paper = packed(backdrop.paper);
      held.stripes = packed(backdrop.hatch);
    },
    paint(window) {
      const context = canvas.getContext("2d", { alpha: false });
      if (!context) return;
      let { image } = held;
      if (!image || image.width !== window.width || image.height !== window.height) image = new ImageData(window.width, window.height);
      held.image = image;
      context.putImageData(paintOn(image, window), 0, 0);
      hairlines(context, window);
    },
    pixels: (window) => paintOn(new ImageData(window.width, window.height), window),
  };
}
