// @ts-check
// Paints the map with WebGL 2. Backdrop and mask are textures of bytes addressed by the index of a cell; a table has the color
// of each pair of them. A pixel that covers several cells is the average of up to four by four of them.

/** Cells per row of a texture. Every WebGL 2 of the last ten years has textures so wide. */
const TEXTURE_WIDTH = 4096;

/**
 * What is painted: the cell coordinates of the upper left corner of a picture, and cells per pixel.
 * @typedef {{col: number, row: number, colsPerPx: number, rowsPerPx: number, width: number, height: number,
 *   pxPerPoint: number, stripePx: number}} MapWindow pxPerPoint: device pixels per CSS pixel; stripePx: from stripe to stripe
 *   where there are no data [px]
 */

/**
 * @typedef {{setTone: (tone: Uint8Array) => void, setMask: (mask: Uint8Array | null) => void,
 *   setLooks: (looks: Uint8Array, backdrop: Backdrop) => void, paint: (window: MapWindow, isDraft?: boolean) => void,
 *   pixels: (window: MapWindow) => ImageData}} Painter
 */

const VERTEX_SHADER = `#version 300 es
void main() {
  // One triangle that covers the picture.
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D tone;
uniform usampler2D mask;
uniform sampler2D looks;
uniform ivec2 size;
uniform vec2 corner;
uniform vec2 perPx;
uniform float height;
uniform float pxPerPoint;
uniform float stripePx;
uniform ivec2 samples;
uniform bool hasMask;
uniform bool hasTone;
uniform bool isFlipped;
uniform vec3 paper;
uniform vec3 stripes;
out vec4 color;

// The color of a cell; opacity 0 where it has none.
vec4 lookOf(ivec2 cell) {
  if (!hasTone || any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, size))) return vec4(paper, 1.0);
  int index = cell.y * size.x + cell.x;
  ivec2 texel = ivec2(index & 4095, index >> 12);
  int across = int(texelFetch(tone, texel, 0).r);
  int down = hasMask ? min(int(texelFetch(mask, texel, 0).r), 63) : 2;
  return texelFetch(looks, ivec2(across, down), 0);
}

void main() {
  vec2 px = vec2(gl_FragCoord.x, isFlipped ? gl_FragCoord.y : height - gl_FragCoord.y);
  vec2 first = corner + (px - 0.5) * perPx;
  vec3 sum = vec3(0.0);
  float n = 0.0;
  float all = float(samples.x * samples.y);
  for (int j = 0; j < samples.y; j += 1) {
    for (int i = 0; i < samples.x; i += 1) {
      vec2 at = first + (vec2(i, j) + 0.5) / vec2(samples) * perPx;
      vec4 look = lookOf(ivec2(floor(at)));
      // Squares are close to linear light, and their root gives a single color back exactly.
      sum += look.rgb * look.rgb * look.a;
      n += look.a;
    }
  }
  if (2.0 * n < all) {
    color = vec4(mod(px.x + px.y, stripePx) < 0.21 * stripePx ? stripes : paper, 1.0);
    return;
  }
  vec3 mixed = sqrt(sum / n);
  // Large cells have hairlines between them.
  float cellPx = 1.0 / max(perPx.x, perPx.y);
  if (cellPx >= 24.0 * pxPerPoint) {
    vec2 at = corner + px * perPx;
    vec2 toBorder = fract(at) / perPx;
    if (min(toBorder.x, toBorder.y) < pxPerPoint) mixed = mix(mixed, vec3(0.06, 0.08, 0.09), 0.16);
  }
  color = vec4(mixed, 1.0);
}`;

/**
 * A painter on a canvas, or null where the browser has no WebGL 2.
 * @param {HTMLCanvasElement} canvas
 * @param {boolean} isForced whether WebGL is taken even where the processor computes it
 * @returns {Painter | null}
 */
function glPainter(canvas, isForced) {
  const context = canvas.getContext("webgl2", {
    alpha: false, antialias: false, depth: false, stencil: false, failIfMajorPerformanceCaveat: !isForced,
  });
  if (!context) return null;
  const gl = context;
  if (gl.getParameter(gl.MAX_TEXTURE_SIZE) < TEXTURE_WIDTH || (!isForced && isComputed(gl))) {
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return null;
  }

  const { n_cols, n_rows } = grid;
  const nCells = n_cols * n_rows;
  const held = {
    /** @type {Uint8Array | null} */ tone: null,
    /** @type {Uint8Array | null} */ looks: null,
    /** @type {Backdrop} */ backdrop: BACKDROPS.light,
    hasMask: false,
    isLost: false,
  };

  /** @type {WebGLProgram} */ let program;
  /** @type {Map<string, WebGLUniformLocation | null>} */ let places;
  const uniform = (/** @type {string} */ name) => places.get(name) ?? null;

  /** @param {number} unit */
  function texture(unit) {
    const made = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, made);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    return /** @type {WebGLTexture} */ (made);
  }

  /** Makes everything that lives in the graphics memory. */
  function setUp() {
    program = linked(gl);
    gl.useProgram(program);
    const names = ["tone", "mask", "looks", "size", "corner", "perPx", "height", "pxPerPoint", "stripePx", "samples", "hasMask", "hasTone",
      "isFlipped", "paper", "stripes"];
    places = new Map(names.map((name) => [name, gl.getUniformLocation(program, name)]));
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const height = Math.ceil(nCells / TEXTURE_WIDTH);
    texture(0);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R8UI, TEXTURE_WIDTH, height);
    texture(1);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R8UI, TEXTURE_WIDTH, height);
    texture(2);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, 256, LOOK_ROWS);
    gl.bindVertexArray(gl.createVertexArray());
    gl.uniform1i(uniform("tone"), 0);
    gl.uniform1i(uniform("mask"), 1);
    gl.uniform1i(uniform("looks"), 2);
    gl.uniform2i(uniform("size"), n_cols, n_rows);
  }

  /** Copies a byte a cell into a texture, in place. @param {number} unit @param {Uint8Array} cells */
  function upload(unit, cells) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    const whole = Math.floor(nCells / TEXTURE_WIDTH);
    const rest = nCells - whole * TEXTURE_WIDTH;
    if (whole > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, TEXTURE_WIDTH, whole, gl.RED_INTEGER, gl.UNSIGNED_BYTE, cells, 0);
    if (rest > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, whole, rest, 1, gl.RED_INTEGER, gl.UNSIGNED_BYTE, cells, whole * TEXTURE_WIDTH);
  }

  /** @param {Uint8Array} looks */
  function uploadLooks(looks) {
    gl.activeTexture(gl.TEXTURE0 + 2);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 256, LOOK_ROWS, gl.RGBA, gl.UNSIGNED_BYTE, looks);
  }

  /** @param {MapWindow} window @param {boolean} isFlipped whether the first row of pixels is the upper one */
  function render(window, isFlipped) {
    const { paper, hatch } = held.backdrop;
    const samplesOf = (/** @type {number} */ perPx) => within(Math.ceil(perPx - 0.01), 1, 4);
    gl.viewport(0, 0, window.width, window.height);
    gl.uniform2f(uniform("corner"), window.col, window.row);
    gl.uniform2f(uniform("perPx"), window.colsPerPx, window.rowsPerPx);
    gl.uniform1f(uniform("height"), window.height);
    gl.uniform1f(uniform("pxPerPoint"), window.pxPerPoint);
    gl.uniform1f(uniform("stripePx"), window.stripePx);
    gl.uniform2i(uniform("samples"), samplesOf(window.colsPerPx), samplesOf(window.rowsPerPx));
    gl.uniform1i(uniform("hasMask"), held.hasMask ? 1 : 0);
    gl.uniform1i(uniform("hasTone"), held.tone ? 1 : 0);
    gl.uniform1i(uniform("isFlipped"), isFlipped ? 1 : 0);
    gl.uniform3f(uniform("paper"), paper[0] / 255, paper[1] / 255, paper[2] / 255);
    gl.uniform3f(uniform("stripes"), hatch[0] / 255, hatch[1] / 255, hatch[2] / 255);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    held.isLost = true;
  });
  canvas.addEventListener("webglcontextrestored", () => {
    held.isLost = false;
    held.hasMask = false;
    setUp();
    if (held.tone) upload(0, held.tone);
    if (held.looks) uploadLooks(held.looks);
    // The mask is the worker's to give again.
    changed("layer");
  });
  setUp();

  return {
    setTone(tone) {
      held.tone = tone;
      if (!held.isLost) upload(0, tone);
    },
    setMask(mask) {
      held.hasMask = mask !== null;
      if (mask && !held.isLost) upload(1, mask);
    },
    setLooks(looks, backdrop) {
      Object.assign(held, { looks, backdrop });
      if (!held.isLost) uploadLooks(looks);
    },
    paint(window) {
      if (!held.isLost) render(window, false);
    },
    pixels(window) {
      const target = gl.createFramebuffer();
      const picture = texture(3);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, window.width, window.height);
      gl.bindFramebuffer(gl.FRAMEBUFFER, target);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, picture, 0);
      render(window, true);
      const pixels = new ImageData(window.width, window.height);
      gl.readPixels(0, 0, window.width, window.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels.data);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.deleteFramebuffer(target);
      gl.deleteTexture(picture);
      return pixels;
    },
  };
}

/** Whether the processor computes what a graphics card should: browsers tell it by name only. @param {WebGL2RenderingContext} gl */
function isComputed(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** Compiles and links the two shaders. @param {WebGL2RenderingContext} gl */
function linked(gl) {
  const program = /** @type {WebGLProgram} */ (gl.createProgram());
  for (const [kind, source] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const logs = (gl.getAttachedShaders(program) ?? []).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`the shaders do not link: ${logs.join(" ")}`);
  }
  return program;
}
