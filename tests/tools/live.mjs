// Asks the engine of a live page, without a browser: the worker's own script, run here.
// node live.mjs PAGE.html < questions, one JSON a line > answers, one JSON a line
import { readFileSync } from 'node:fs';

const [file] = process.argv.slice(2);
const page = readFileSync(file, 'utf8');
const block = (id) => {
  const found = page.match(new RegExp(`<script type="[^"]*" id="${id}">([^]*?)</script>`));
  if (!found) throw new Error(`the page has no block ${id}`);
  return found[1];
};
let told = () => {};
globalThis.self = globalThis;
globalThis.postMessage = (message) => told(message);
(0, eval)(block('worker'));
/** Sends a message and waits for its answer; what comes before it is progress. */
const send = (message) =>
  new Promise((resolve) => {
    told = (answer) => {
      const isLast = message.do === 'open' ? ['opened', 'failed'].includes(answer.do) : answer.id === message.id && !(answer.share < 1 && !answer.done);
      if (isLast) resolve(answer);
    };
    globalThis.onmessage({ data: message });
  });
const opened = await send({ do: 'open', scene: block('scene'), engine: block('engine') });
if (opened.do === 'failed') throw new Error(opened.words);
const { tone, ...facts } = opened;
console.log(JSON.stringify({ ...facts, cells: tone.byteLength }));
let id = 0;
for (const line of readFileSync(0, 'utf8').split('\n').filter(Boolean)) {
  const { picture, mask, ...answer } = await send({ id: (id += 1), ...JSON.parse(line) });
  console.log(JSON.stringify(answer));
}
