// The digest of Munich's mask by the engine as WebAssembly: that of `skyshed map maps/munich.geojson --uav X,Y,H --json`.
// node scripts/munich.mjs MODULE.wasm X Y H
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';

const [module, ...numbers] = process.argv.slice(2);
// Libraries name functions of a page (clocks, random numbers) that no map calls.
const compiled = new WebAssembly.Module(readFileSync(module));
const imports = {};
for (const { module: from, name } of WebAssembly.Module.imports(compiled)) {
  (imports[from] ??= {})[name] = () => {
    throw new Error(`the engine calls ${from}.${name}`);
  };
}
const instance = new WebAssembly.Instance(compiled, imports);
const engine = instance.exports;
const bytes = (at, length) => new Uint8Array(engine.memory.buffer, at, length);
const done = (code) => {
  if (code !== 0) {
    throw new Error(Buffer.from(bytes(engine.text(), engine.text_length())).toString());
  }
};

const city = readFileSync('maps/munich.geojson');
bytes(engine.input(city.length), city.length).set(city);
done(engine.load());
done(engine.map(...numbers.map(Number)));
const shape = BigInt.asUintN(64, engine.shape());
const [cols, rows] = [shape >> 32n, shape & 0xffffffffn];
const head = Buffer.alloc(16);
head.writeBigUInt64LE(cols, 0);
head.writeBigUInt64LE(rows, 8);
const mask = bytes(engine.mask(), Number(cols * rows));
console.log(`sha256:${createHash('sha256').update(head).update(mask).digest('hex')}`);
