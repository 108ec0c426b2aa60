// The worker of the page: it holds the engine, and answers one question after another.
//
// The engine is WebAssembly without imports that a map calls. Questions go in as JSON; answers come out as JSON and as bytes of cells,
// in buffers that the page gives back.
// @ts-check
'use strict';

/**
 * What the module exports; addresses are in its memory.
 * @typedef {{
 *   memory: WebAssembly.Memory, input(length: number): number, open(): number, ask(): number,
 *   answer(): number, answer_length(): number, picture(): number, picture_length(): number,
 *   backdrop(): number, backdrop_length(): number,
 * }} Exports
 */

/** Long work looks this often at what else was asked [ms]. */
const PIECE_MS = 12;
/** Questions that take no time, and are answered between two pieces of long work; any other ends that. */
const LIGHT = new Set(['cell', 'link', 'digest', 'read', 'stretches', 'track_heights']);

/** @type {Exports} */
let engine;
/** @type {any[]} */
const waiting = [];
/** Buffers that the page has given back. @type {ArrayBuffer[]} */
const spare = [];
let isWorking = false;
let isStopped = false;

/** Bytes of their text: four for five digits, a sign from `(` on, but `}` for `<`; 84 for what the last group lacks. @param {string} text */
function decoded(text) {
  const digits = text.trim();
  const bytes = new Uint8Array(Math.floor(digits.length * 4 / 5));
  const view = new DataView(new ArrayBuffer(4));
  for (let at = 0, k = 0; k < digits.length; at += 4, k += 5) {
    let word = 0;
    for (let i = k; i < k + 5; i += 1) {
      const sign = i < digits.length ? digits.charCodeAt(i) : 124;
      word = word * 85 + (sign === 125 ? 20 : sign - 40);
    }
    view.setUint32(0, word);
    for (let i = 0; i < 4 && at + i < bytes.length; i += 1) bytes[at + i] = view.getUint8(i);
  }
  return bytes;
}

/** What is packed in a text. @param {string} text @returns {Promise<Uint8Array<ArrayBuffer>>} */
async function unpacked(text) {
  const stream = new Blob([decoded(text)]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {Uint8Array<ArrayBuffer>} bytes @returns {Promise<Exports>} */
async function instance(bytes) {
  const compiled = await WebAssembly.compile(bytes);
  // Libraries name functions of a page (clocks, random numbers) that no question calls.
  /** @type {Record<string, Record<string, () => never>>} */
  const imports = {};
  for (const { module, name } of WebAssembly.Module.imports(compiled)) {
    (imports[module] ??= {})[name] = () => {
      throw new Error(`the engine calls ${module}.${name}`);
    };
  }
  const { exports } = await WebAssembly.instantiate(compiled, imports);
  return /** @type {Exports} */ (/** @type {unknown} */ (exports));
}

/** @param {Uint8Array} bytes */
function hand(bytes) {
  const at = engine.input(bytes.length);
  new Uint8Array(engine.memory.buffer, at, bytes.length).set(bytes);
}

/** The words of the last call. */
function words() {
  return new TextDecoder().decode(new Uint8Array(engine.memory.buffer, engine.answer(), engine.answer_length()));
}

/** @param {object} question @returns {any} */
function ask(question) {
  hand(new TextEncoder().encode(JSON.stringify(question)));
  if (engine.ask() !== 0) throw new Error(words());
  return JSON.parse(words());
}

/** A copy of bytes of the engine, in a buffer that the page gave back where one is as long. @param {number} at @param {number} length */
function copied(at, length) {
  const k = spare.findIndex((buffer) => buffer.byteLength === length);
  const buffer = k < 0 ? new ArrayBuffer(length) : spare.splice(k, 1)[0];
  new Uint8Array(buffer).set(new Uint8Array(engine.memory.buffer, at, length));
  return buffer;
}

/** @param {any} message @param {ArrayBuffer[]} [buffers] */
function tell(message, buffers = []) {
  self.postMessage(message, /** @type {any} */ (buffers));
}

/** @param {{scene: string, engine: string}} request */
async function open(request) {
  const start = performance.now();
  tell({ do: 'progress', step: 'engine', share: null });
  engine = await instance(await unpacked(request.engine));
  tell({ do: 'progress', step: 'unpack', share: null });
  hand(await unpacked(request.scene));
  tell({ do: 'progress', step: 'build', share: null });
  // The page is to see that before the work begins.
  await pause();
  if (engine.open() !== 0) throw new Error(words());
  const tone = copied(engine.backdrop(), engine.backdrop_length());
  tell({ do: 'opened', ...JSON.parse(words()), tone, ms: performance.now() - start }, [tone]);
}

/** Lets messages come in. @returns {Promise<void>} */
function pause() {
  return new Promise((resolve) => {
    setTimeout(resolve);
  });
}

/**
 * Work in pieces, until it is done or the page wants something else.
 * @param {any} request @param {object} begin @param {() => object} next
 */
async function inPieces(request, begin, next) {
  isStopped = false;
  ask(begin);
  for (;;) {
    const start = performance.now();
    let facts;
    do facts = ask(next());
    while (!facts.done && performance.now() - start < PIECE_MS);
    if (facts.done) return facts;
    tell({ do: request.do, id: request.id, ...facts });
    await pause();
    while (waiting.length > 0 && LIGHT.has(waiting[0].do)) await answerOrTell(waiting.shift());
    if (isStopped) return { ...facts, done: true, stopped: true };
  }
}

/** @param {any} request */
async function answer(request) {
  const { do: what, id } = request;
  switch (what) {
    case 'open':
      await open(request);
      break;
    case 'map': {
      const start = performance.now();
      const { picture: wanted, id: _, ...question } = request;
      const facts = ask(question);
      const length = engine.picture_length();
      const picture = wanted && length > 0 ? copied(engine.picture(), length) : null;
      tell({ do: what, id, ...facts, picture, ms: performance.now() - start }, picture ? [picture] : []);
      break;
    }
    case 'mask': {
      const { id: _, ...question } = request;
      ask(question);
      const mask = copied(engine.picture(), engine.picture_length());
      tell({ do: what, id, mask }, [mask]);
      break;
    }
    case 'curve':
      tell({ do: what, id, ...(await inPieces(request, { do: 'curve', which: request.which }, () => ({ do: 'curve_rows', rows: 4 }))) });
      break;
    case 'best': {
      const begin = { do: 'best', which: request.which, radius_m: request.radius_m };
      tell({ do: what, id, ...(await inPieces(request, begin, () => ({ do: 'best_next' }))) });
      break;
    }
    default: {
      const { id: _, ...question } = request;
      tell({ do: what, id, ...ask(question) });
    }
  }
}

/** Answers, or tells why not. @param {any} request */
async function answerOrTell(request) {
  try {
    await answer(request);
  } catch (error) {
    const words = error instanceof Error ? error.message : String(error);
    tell({ do: request.do === 'open' ? 'failed' : request.do, id: request.id, ok: false, words });
  }
}

self.onmessage = async ({ data }) => {
  if (data.do === 'stop') {
    isStopped = true;
    return;
  }
  if (data.do === 'give_back') {
    if (spare.length < 3) spare.push(data.picture);
    return;
  }
  // Long work makes way: it is the page that asks again.
  if (!LIGHT.has(data.do)) isStopped = true;
  waiting.push(data);
  if (isWorking) return;
  isWorking = true;
  for (let request = waiting.shift(); request; request = waiting.shift()) await answerOrTell(request);
  isWorking = false;
};
