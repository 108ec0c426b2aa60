// How fast the live page follows: milliseconds from a pointer's event to the drawn mask, and memory over many moves.
// node benches/live.mjs [PROGRAM] ; needs Chromium, and playwright-core where NODE_PATH says (npm install playwright-core).
// Scenes: Munich, 4 million cells of footprints, 1 million of noisy surface.
import { createRequire } from 'node:module';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const { chromium } = createRequire(`${process.env.NODE_PATH}/`)('playwright-core');
const program = process.argv[2] ?? 'target/release/skyshed';
const n_moves = Number(process.env.MOVES ?? 300);
const folder = mkdtempSync(join(tmpdir(), 'skyshed-bench-'));

/** A surface of 1024 × 1024 cells of 1 m: blocks of houses, and 5 cm of noise as LiDAR has it. */
function noisy() {
  let seed = 1;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  const rows = Array.from({ length: 1024 }, (_, row) =>
    Array.from({ length: 1024 }, (_, col) => {
      const house = row % 60 > 18 && col % 50 > 15 ? 8 + (((row / 60) | 0) * 7 + ((col / 50) | 0) * 13) % 17 : 0;
      return (house + 0.1 * random()).toFixed(2);
    }).join(' '));
  writeFileSync(join(folder, 'noisy.asc'), `ncols 1024\nnrows 1024\nxllcorner 0\nyllcorner 0\ncellsize 1\n${rows.join('\n')}\n`);
  return join(folder, 'noisy.asc');
}

const scenes = [
  ['Munich, footprints, 1.6 million cells', ['maps/munich.geojson', '--uav', '691549.7,5334762.2,120']],
  ['itu:urban, footprints, 4.2 million cells', ['itu:urban', '--size', '2048']],
  ['noisy surface, 1.0 million cells', [noisy(), '--uav', '500,500,60']],
];
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox', '--enable-precise-memory-info'] });
for (const [name, words] of scenes) {
  const file = join(folder, 'page.html');
  execFileSync(program, ['live', ...words, '-o', file, '--overwrite', '-q']);
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const began = Date.now();
  await page.goto(`file://${file}`);
  await page.evaluate('skyshed.ready.then(() => skyshed.idle())');
  const opened = Date.now() - began;
  const mark = await page.locator('#mark-1').boundingBox();
  const [x, y] = [mark.x + 24, mark.y + 24];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const memory = () => page.evaluate('performance.memory.usedJSHeapSize');
  await page.evaluate('skyshedTimes.length = 0');
  let before = 0;
  for (let k = 0; k < n_moves; k += 1) {
    await page.mouse.move(x + 180 * Math.sin(k / 9), y + 120 * Math.sin(k / 13));
    // A hand moves at most as often as the screen is drawn.
    await page.waitForTimeout(n_moves > 1000 ? 1 : 16);
    if (k === Math.floor(n_moves / 10)) before = await memory();
  }
  await page.evaluate('skyshed.idle()');
  const times = (await page.evaluate('[...skyshedTimes]')).sort((a, b) => a - b);
  const at = (share) => times[Math.floor(times.length * share)]?.toFixed(1);
  const growth = ((await memory()) - before) / 1e6;
  console.log(`${name}: opened in ${opened} ms; ${times.length} masks; median ${at(0.5)} ms, 95 % ${at(0.95)} ms; memory ${growth > 0 ? '+' : ''}${growth.toFixed(1)} MB over ${n_moves} moves`);
  await page.close();
}
await browser.close();
rmSync(folder, { recursive: true });
