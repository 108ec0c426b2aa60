// @ts-check
// Files that the page writes: GeoTIFF, ZIP, and how the browser is made to save them.

/**
 * Has the browser save a file.
 * @param {string} name
 * @param {string} type
 * @param {BlobPart[]} parts
 */
function saveFile(name, type, parts) {
  const url = URL.createObjectURL(new Blob(parts, { type }));
  const link = make("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
  notify(say().saved(name));
}

/** Deflates bytes as zlib does; null where the browser cannot. @param {Uint8Array<ArrayBuffer>} bytes @returns {Promise<Uint8Array<ArrayBuffer> | null>} */
async function deflated(bytes) {
  if (typeof CompressionStream === "undefined") return null;
  const stream = new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Mask classes with their colors in files; other values are transparent. @type {[number, Rgb][]} */
const FILE_COLORS = [[0, NLOS], [1, LOS], [2, [0xc3, 0xc6, 0xc9]], [3, [0xe9, 0xed, 0xf0]], [255, [0xff, 0xff, 0xff]]];

// Types of a TIFF's fields.
const [ASCII, SHORT, LONG, DOUBLE] = [2, 3, 4, 12];

/**
 * A mask as a GeoTIFF of one strip, with a palette.
 * @param {Uint8Array<ArrayBuffer>} mask
 * @returns {Promise<BlobPart[]>}
 */
async function geotiff(mask) {
  const { x_min, y_max, cell_width, cell_height, n_cols, n_rows } = grid;
  const packed = await deflated(mask);
  const strip = packed ?? mask;
  const palette = new Array(768).fill(0);
  for (const [value, color] of FILE_COLORS) color.forEach((c, channel) => (palette[256 * channel + value] = 257 * c));
  /** @type {[number, number, number[] | string][]} tag, type, values; in ascending order of tags */
  const fields = [
    [256, LONG, [n_cols]],
    [257, LONG, [n_rows]],
    [258, SHORT, [8]],
    [259, SHORT, [packed ? 8 : 1]],
    [262, SHORT, [3]],
    [273, LONG, [0]],
    [277, SHORT, [1]],
    [278, LONG, [n_rows]],
    [279, LONG, [strip.length]],
    [305, ASCII, facts.program.replace(/[^\x20-\x7e]/g, "?")],
    [320, SHORT, palette],
    [33550, DOUBLE, [cell_width, cell_height, 0]],
    [33922, DOUBLE, [0, 0, 0, x_min, y_max, 0]],
    ...geoKeys(),
    [42113, ASCII, "255"],
  ];
  const header = tiffHeader(fields, 273);
  return [header, strip];
}

/** The reference system as GeoKeys; none without one, since with any key GDAL makes up a local system. @returns {[number, number, number[] | string][]} */
function geoKeys() {
  const { crs } = facts;
  if (!crs) return [];
  const plain = (/** @type {string} */ text) => `${text.replace(/[^\x20-\x7e]|\|/g, " ")}|`;
  const isCoded = crs.epsg !== null && crs.epsg < 32767;
  const name = plain(crs.name);
  // A system without a code is written as a definition, in Esri's form.
  const citation = isCoded ? "" : plain(crs.wkt ? `ESRI PE String = ${crs.wkt.split(/\s+/).join(" ")}` : crs.name);
  /** @type {number[][]} key, where its value is, count, value or offset */
  const keys = [
    [1024, 0, 1, isCoded ? (crs.geographic ? 2 : 1) : 32767],
    [1025, 0, 1, 1],
    [1026, 34737, name.length, 0],
  ];
  if (isCoded) keys.push([crs.geographic ? 2048 : 3072, 0, 1, crs.epsg ?? 0]);
  else keys.push([3073, 34737, citation.length, name.length]);
  return [[34735, SHORT, [1, 1, 0, keys.length, ...keys.flat()]], [34737, ASCII, name + citation]];
}

/**
 * The header and the directory of a little-endian TIFF; the strip follows them, and one field holds where.
 * @param {[number, number, number[] | string][]} fields
 * @param {number} offsetTag
 */
function tiffHeader(fields, offsetTag) {
  /** @type {Record<number, number>} */
  const sizes = { [ASCII]: 1, [SHORT]: 2, [LONG]: 4, [DOUBLE]: 8 };
  const counts = fields.map(([, , values]) => (typeof values === "string" ? values.length + 1 : values.length));
  const lengths = fields.map(([, type], k) => sizes[type] * counts[k]);
  const directory = 8;
  let free = directory + 2 + 12 * fields.length + 4;
  const places = lengths.map((bytes) => {
    if (bytes <= 4) return 0;
    const at = free;
    free += bytes + (bytes % 2);
    return at;
  });
  const view = new DataView(new ArrayBuffer(free));
  view.setUint16(0, 0x4949);
  view.setUint16(2, 42, true);
  view.setUint32(4, directory, true);
  view.setUint16(directory, fields.length, true);
  fields.forEach(([tag, type, given], k) => {
    const entry = directory + 2 + 12 * k;
    view.setUint16(entry, tag, true);
    view.setUint16(entry + 2, type, true);
    view.setUint32(entry + 4, counts[k], true);
    let at = places[k] || entry + 8;
    if (places[k]) view.setUint32(entry + 8, at, true);
    const values = tag === offsetTag ? [free] : typeof given === "string" ? [...given].map((c) => c.charCodeAt(0)) : given;
    for (const value of values) {
      if (type === ASCII) view.setUint8(at, value);
      else if (type === SHORT) view.setUint16(at, value, true);
      else if (type === LONG) view.setUint32(at, value, true);
      else view.setFloat64(at, value, true);
      at += sizes[type];
    }
  });
  return view.buffer;
}

/** The six lines of a world file: cell sizes and the center of the first cell. */
function worldFile() {
  const { x_min, y_max, cell_width, cell_height } = grid;
  return [cell_width, 0, 0, -cell_height, x_min + cell_width / 2, y_max - cell_height / 2].map((v) => `${v}\n`).join("");
}

/** A mask as PNG of a pixel a cell. @param {Uint8Array} mask @returns {Promise<Uint8Array<ArrayBuffer>>} */
async function maskPng(mask) {
  const canvas = make("canvas", { width: grid.n_cols, height: grid.n_rows });
  const context = canvas.getContext("2d");
  const image = new ImageData(grid.n_cols, grid.n_rows);
  const pixels = new Uint32Array(image.data.buffer);
  const colors = new Uint32Array(256);
  // Pixels lie in memory as red, green, blue, opacity; all machines of today are little-endian.
  for (const [value, [r, g, b]] of FILE_COLORS) if (value < 255) colors[value] = (r | (g << 8) | (b << 16) | (255 << 24)) >>> 0;
  for (let i = 0; i < pixels.length; i += 1) pixels[i] = colors[mask[i]];
  context?.putImageData(image, 0, 0);
  return new Uint8Array(await (await canvasBlob(canvas)).arrayBuffer());
}

/** @param {HTMLCanvasElement} canvas @returns {Promise<Blob>} */
function canvasBlob(canvas) {
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the picture is too large"))), "image/png"));
}

/** The checksum of ZIP files. @param {Uint8Array} bytes */
function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; k += 1) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/**
 * A ZIP file; what it holds is stored as it is.
 * @param {[string, Uint8Array<ArrayBuffer>][]} files names of plain letters, and contents
 * @returns {BlobPart[]}
 */
function zip(files) {
  /** @type {BlobPart[]} */
  const parts = [];
  /** @type {BlobPart[]} */
  const directory = [];
  let [offset, directoryLength] = [0, 0];
  for (const [name, bytes] of files) {
    const nameBytes = new TextEncoder().encode(name);
    // Version, flags, method, time, date, checksum, two sizes, length of the name, no extra.
    const common = new DataView(new ArrayBuffer(26));
    common.setUint16(0, 10, true);
    common.setUint16(8, 0x21, true);
    common.setUint32(10, crc32(bytes), true);
    common.setUint32(14, bytes.length, true);
    common.setUint32(18, bytes.length, true);
    common.setUint16(22, nameBytes.length, true);
    parts.push(new Uint8Array([0x50, 0x4b, 3, 4]), common.buffer, nameBytes, bytes);
    const entry = new DataView(new ArrayBuffer(14));
    entry.setUint32(10, offset, true);
    directory.push(new Uint8Array([0x50, 0x4b, 1, 2, 10, 0]), common.buffer, entry.buffer, nameBytes);
    offset += 4 + 26 + nameBytes.length + bytes.length;
    directoryLength += 6 + 26 + 14 + nameBytes.length;
  }
  const end = new DataView(new ArrayBuffer(18));
  end.setUint16(4, files.length, true);
  end.setUint16(6, files.length, true);
  end.setUint32(8, directoryLength, true);
  end.setUint32(12, offset, true);
  return [...parts, ...directory, new Uint8Array([0x50, 0x4b, 5, 6]), end.buffer];
}
