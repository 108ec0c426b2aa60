// @ts-check
// Paints the map without WebGL, or where WebGL would be computed by the processor, which is slower than this: each pixel of
// the visible part is averaged from two by two samples, or is one of these while maps follow each other.
//
// Colors are numbers of 32 bits: red in the lowest byte, opacity in the highest, as pixels lie in memory on all machines of
// today. They are signed: unsigned ones would be floating-point numbers to the browser, which are slow. 0 is a cell without data.

/**
 * One sample for each pixel of a row.
 * @param {Int32Array} row @param {number} from @param {number} to @param {Uint8Array} mask @param {Uint8Array} tone
 * @param {Int32Array} looks @param {Int32Array} cols @param {number} above @param {number} _below @param {Int32Array} hatch @param {number} y
 */
function drawRow(row, from, to, mask, tone, looks, cols, above, _below, hatch, y) {
  for (let x = from; x < to; x += 1) {
    const cell = above + cols[2 * x];
    const color = looks[(mask[cell] << 8) | tone[cell]];
    row[x] = color === 0 ? hatch[x + y] : color;
  }
}

/** The average of four colors, two channels at a time, which have room for their sum. @param {number} a @param {number} b @param {number} c @param {number} d */
function average(a, b, c, d) {
  const low = (a & 0xff00ff) + (b & 0xff00ff) + (c & 0xff00ff) + (d & 0xff00ff);
  const high = ((a >>> 8) & 0xff00ff) + ((b >>> 8) & 0xff00ff) + ((c >>> 8) & 0xff00ff) + ((d >>> 8) & 0xff00ff);
  return ((low >>> 2) & 0xff00ff) | (((high >>> 2) & 0xff00ff) << 8);
}

/**
 * Of a pixel at the edge of the data, the cells that have some decide, if they are at least half.
 * @param {number[]} colors @param {number} stripe
 */
function atEdge(colors, stripe) {
  const known = colors.filter((color) => color !== 0);
  return known.length < 2 ? stripe : average(known[0], known[1], known[2] ?? known[0], known[known.length - 1]);
}

/**
 * The average of four samples for each pixel of a row.
 * @param {Int32Array} row @param {number} from @param {number} to @param {Uint8Array} mask @param {Uint8Array} tone
 * @param {Int32Array} looks @param {Int32Array} cols @param {number} above @param {number} below @param {Int32Array} hatch @param {number} y
 */
function averageRow(row, from, to, mask, tone, looks, cols, above, below, hatch, y) {
  for (let x = from; x < to; x += 1) {
    const left = cols[2 * x];
    const right = cols[2 * x + 1];
    const a = looks[(mask[above + left] << 8) | tone[above + left]];
    const b = looks[(mask[above + right] << 8) | tone[above + right]];
    const c = looks[(mask[below + left] << 8) | tone[below + left]];
    const d = looks[(mask[below + right] << 8) | tone[below + right]];
    if (a === b && a === c && a === d) row[x] = a === 0 ? hatch[x + y] : a;
    else if (a !== 0 && b !== 0 && c !== 0 && d !== 0) row[x] = average(a, b, c, d);
    else row[x] = atEdge([a, b, c, d], hatch[x + y]);
  }
}

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
    /** Colors by class (high byte) and tone. */ looks: new Int32Array(65536),
    /** Class 2 for all cells, until there is a mask. @type {Uint8Array | null} */ bare: null,
    hasMask: false,
    paper: 0,
    stripes: 0,
    /** @type {ImageData | null} */ image: null,
    /** Columns of the samples of each pixel across. */ cols: new Int32Array(0),
  };
  const packed = (/** @type {Rgb} */ [r, g, b]) => r | (g << 8) | (b << 16) | (255 << 24);

  /** @param {Int32Array} pixels @param {MapWindow} window @param {boolean} isDraft */
  function fill(pixels, window, isDraft) {
    const { width, height, stripePx } = window;
    const { tone, looks, cols, paper, stripes } = held;
    const mask = held.hasMask ? held.mask : held.bare;
    if (!tone || !mask) {
      pixels.fill(paper);
      return;
    }
    for (let k = 0; k < 2 * width; k += 1) cols[k] = Math.floor(window.col + (k / 2 + 0.25) * window.colsPerPx);
    // The pixels across that lie on the map.
    let from = 0;
    let to = width;
    while (from < to && cols[2 * from] < 0) from += 1;
    while (to > from && cols[2 * to - 1] >= n_cols) to -= 1;
    // Stripes run aslant: the color of a pixel without data, by the sum of its place.
    const hatch = new Int32Array(width + height);
    for (let k = 0; k < hatch.length; k += 1) hatch[k] = k % stripePx < 0.21 * stripePx ? stripes : paper;
    const sampleRow = isDraft ? drawRow : averageRow;
    for (let y = 0; y < height; y += 1) {
      const above = Math.floor(window.row + (y + 0.25) * window.rowsPerPx);
      const below = Math.floor(window.row + (y + 0.75) * window.rowsPerPx);
      const row = pixels.subarray(y * width, (y + 1) * width);
      if (above < 0 || below >= n_rows) {
        row.fill(paper);
        continue;
      }
      row.fill(paper, 0, from);
      row.fill(paper, to);
      sampleRow(row, from, to, mask, tone, looks, cols, above * n_cols, below * n_cols, hatch, y);
    }
  }
  /** @param {ImageData} image @param {MapWindow} window @param {boolean} [isDraft] */
  function paintOn(image, window, isDraft = false) {
    if (held.cols.length < 2 * window.width) held.cols = new Int32Array(2 * window.width);
    fill(new Int32Array(image.data.buffer), window, isDraft);
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
      const colors = new Int32Array(looks.buffer);
      for (let value = 0; value < 256; value += 1) {
        const row = Math.min(value, NO_DATA_ROW);
        held.looks.set(colors.subarray(256 * row, 256 * (row + 1)), 256 * value);
      }
      held.paper = packed(backdrop.paper);
      held.stripes = packed(backdrop.hatch);
    },
    paint(window, isDraft) {
      const context = canvas.getContext("2d", { alpha: false });
      if (!context) return;
      let { image } = held;
      if (!image || image.width !== window.width || image.height !== window.height) image = new ImageData(window.width, window.height);
      held.image = image;
      context.putImageData(paintOn(image, window, isDraft), 0, 0);
      hairlines(context, window);
    },
    pixels: (window) => paintOn(new ImageData(window.width, window.height), window),
  };
}
