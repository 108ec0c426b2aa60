// @ts-check
// The other end of the worker: requests and their answers.

/** @typedef {{what: string, settle: (answer: any) => void, refuse: (error: Error) => void, progress?: (answer: any) => void}} Waiting */

const engine = {
  /** @type {Worker | null} */ worker: null,
  /** Facts of the opened scene. @type {Opened | null} */ opened: null,
  nextId: 1,
  /** What waits for an answer, by id. @type {Map<number, Waiting>} */ waiting: new Map(),
  /** Ids of requests that run long and can be stopped. @type {Set<number>} */ long: new Set(),
};

/** Requests whose answers come in parts, the last of them marked as done. */
const IN_PARTS = new Set(["curve", "best"]);

/** The shortest module with vectors of 128 bits, which the engine has: browsers from 2023 on take it. */
const WITH_VECTORS = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

/**
 * Starts the worker and opens the scene.
 * @param {(step: 'engine' | 'unpack' | 'build', share: number | null) => void} onProgress
 * @returns {Promise<Opened>}
 */
function openScene(onProgress) {
  return new Promise((resolve, reject) => {
    const text = (/** @type {string} */ id) => document.getElementById(id)?.textContent ?? "";
    const source = URL.createObjectURL(new Blob([text("worker")], { type: "text/javascript" }));
    const worker = new Worker(source);
    engine.worker = worker;
    worker.onerror = (event) => {
      event.preventDefault();
      const error = new Error(event.message || "the worker did not start");
      reject(error);
      // Nobody answers any more.
      for (const { refuse } of engine.waiting.values()) refuse(error);
      engine.waiting.clear();
    };
    worker.onmessage = ({ data }) => {
      if (data.do === "progress") onProgress(data.step, data.share);
      else if (data.do === "failed") reject(new Error(data.words));
      else if (data.do === "opened") {
        URL.revokeObjectURL(source);
        engine.opened = data;
        resolve(data);
      } else answered(data);
    };
    worker.postMessage({ do: "open", scene: text("scene"), engine: text("engine") });
    // The worker has its copies; the page needs the texts no more.
    for (const id of ["scene", "engine", "worker"]) document.getElementById(id)?.remove();
  });
}

/** Hands an answer to who waits for it. @param {any} answer */
function answered(answer) {
  const waiting = engine.waiting.get(answer.id);
  if (!waiting) return;
  if (IN_PARTS.has(answer.do) && !answer.done) {
    waiting.progress?.(answer);
    return;
  }
  engine.waiting.delete(answer.id);
  engine.long.delete(answer.id);
  // A link or a number that cannot be is an answer like any other.
  if (answer.ok === false && answer.do !== "link" && answer.do !== "read") waiting.refuse(new Error(answer.words));
  else waiting.settle(answer);
}

/**
 * Asks the worker.
 * @param {{do: string, [key: string]: unknown}} request
 * @param {(answer: any) => void} [progress] for answers in parts
 * @returns {Promise<any>}
 */
function ask(request, progress) {
  const id = engine.nextId;
  engine.nextId += 1;
  return new Promise((settle, refuse) => {
    engine.waiting.set(id, { what: request.do, settle, refuse, progress });
    if (IN_PARTS.has(request.do)) engine.long.add(id);
    engine.worker?.postMessage({ ...request, id });
  });
}

/** Questions about tracks, whose answers belong to the map. */
const OF_TRACKS = new Set(["stretches", "track_heights"]);

/** Whether an answer about tracks is on its way. */
const waitsForTrack = () => [...engine.waiting.values()].some(({ what }) => OF_TRACKS.has(what));

/** What went wrong, in words. @param {unknown} error */
const wordsOf = (error) => (error instanceof Error ? error.message : String(error));

/** Ends curves and searches early; each still answers. */
function stopLong() {
  if (engine.long.size > 0) engine.worker?.postMessage({ do: "stop" });
}

/**
 * A question of which only the newest matters: at most one is under way, and the newest is sent when its answer comes.
 * @param {() => ({do: string, [key: string]: unknown} | null)} request null if there is nothing to ask any more
 * @param {(answer: any) => void} onAnswer
 * @returns {() => void} call it when something changed
 */
function newestOnly(request, onAnswer) {
  let isAsking = false;
  let isStale = false;
  const send = async () => {
    const wanted = engine.opened ? request() : null;
    if (!wanted) return;
    isAsking = true;
    isStale = false;
    try {
      onAnswer(await ask(wanted));
    } catch (error) {
      notify(wordsOf(error));
    }
    isAsking = false;
    if (isStale) void send();
    settle();
  };
  return () => {
    if (isAsking) isStale = true;
    else void send();
  };
}
