// A person at a live page: drags, types a height, adds a second UAV, clicks a receiver, keeps two placements, exports, saves,
// reloads by address; at the size of a desk and of a phone. Any word on the console and any request is a failure.
// node live_browser.mjs PAGE.html FOLDER COMPARISON.html [SIZE ...] > facts, one JSON on the last line
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';
import assert from 'node:assert/strict';

const require = createRequire(`${process.env.NODE_PATH}/`);
const { chromium } = require('playwright-core');
const [file, folder, comparison, ...wanted] = process.argv.slice(2);
// However busy the machine is: only what never happens fails.
const NEVER_MS = 300_000;
const browser = await chromium.launch({ channel: undefined, executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] });

const SIZES = [
  { name: 'desk', viewport: { width: 1280, height: 800 }, hasTouch: false, colorScheme: 'light', locale: 'en-US' },
  { name: 'dark', viewport: { width: 1280, height: 800 }, hasTouch: false, colorScheme: 'dark', locale: 'de-DE' },
  { name: 'phone', viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2, colorScheme: 'light', locale: 'en-US' },
];

/** @param {(typeof SIZES)[number]} size */
async function use({ name, ...options }) {
  const said = [];
  const context = await browser.newContext({ ...options, acceptDownloads: true });
  context.setDefaultTimeout(NEVER_MS);
  const watch = (page) => {
    page.on('console', (message) => said.push(message.text()));
    page.on('pageerror', (error) => said.push(error.stack ?? error.message));
    page.on('request', (request) => /^(file|blob|data):/.test(request.url()) || said.push(`request ${request.url()}`));
    return page;
  };
  const page = watch(await context.newPage());
  const read = (expression) => page.evaluate(expression);
  const exact = () => read('skyshed.ready.then(() => skyshed.idle())');
  const shot = async (what) => {
    await exact();
    await page.waitForTimeout(150);
    await page.screenshot({ path: `${folder}/live-${name}-${what}.png` });
  };
  const drag = async (mark, dx, dy) => {
    const box = await page.locator(mark).boundingBox();
    const [x, y] = [box.x + 24, box.y + 24];
    const n = 20;
    if (options.hasTouch) {
      const touch = await context.newCDPSession(page);
      const send = (type, points) => touch.send('Input.dispatchTouchEvent', { type, touchPoints: points });
      await send('touchStart', [{ x, y }]);
      for (let i = 1; i <= n; i += 1) await send('touchMove', [{ x: x + (dx * i) / n, y: y + (dy * i) / n }]);
      await send('touchEnd', []);
    } else {
      await page.mouse.move(x, y);
      await page.mouse.down();
      for (let i = 1; i <= n; i += 1) await page.mouse.move(x + (dx * i) / n, y + (dy * i) / n);
      await page.mouse.up();
    }
    await exact();
  };
  const sheet = async () => {
    if (options.hasTouch) {
      await page.locator('#sheet-handle').click();
      await page.waitForTimeout(400);
    }
  };
  const download = async (button) => {
    const [got] = await Promise.all([page.waitForEvent('download'), page.locator(button).click()]);
    return readFileSync(await got.path());
  };

  await page.goto(`file://${file}`);
  await exact();
  await shot('1-opened');
  const start = await read('({ ...skyshed.state.uavs[0] })');
  await drag('#mark-1', options.hasTouch ? 40 : 120, -30);
  const moved = await read('({ ...skyshed.state.uavs[0] })');
  assert.notEqual(moved.x, start.x, `${name}: the UAV did not follow`);
  await shot('2-dragged');

  await page.locator('#height').fill('60');
  await page.locator('#height').blur();
  await exact();
  const uav = await read('({ ...skyshed.state.uavs[0] })');
  assert.deepEqual(uav.height, { kind: 'agl', m: 60 });
  if (!options.hasTouch) {
    await page.locator('#mark-1').focus();
    await page.keyboard.press('Shift+ArrowLeft');
    await page.keyboard.press('Shift+ArrowRight');
    await exact();
    assert.deepEqual(await read('({ ...skyshed.state.uavs[0] })'), uav);
  }
  await page.locator('#save').click();
  await page.locator('#digest', { hasText: 'sha256:' }).waitFor();
  const digest = await page.locator('#digest').textContent();
  const command = await page.locator('#command').textContent();
  await page.locator('#save-close').click();
  await sheet();
  await page.locator('#keep-here').scrollIntoViewIfNeeded();
  await page.locator('#keep-here').click();
  await sheet();

  await drag('#mark-1', -30, options.hasTouch ? -25 : 40);
  await sheet();
  await page.locator('#keep-here').scrollIntoViewIfNeeded();
  await page.locator('#keep-here').click();
  await page.waitForFunction("document.querySelectorAll('#kept-rows tr:not(.now)').length === 2");
  await page.locator('#kept').scrollIntoViewIfNeeded();
  await shot('3-kept');
  const [csv, geojson] = [await download('#export-csv'), await download('#export-geojson')];
  await sheet();

  await page.locator('#add').click();
  await exact();
  assert.equal(await read('skyshed.state.uavs.length'), 2);
  await shot('4-two');
  const box = await page.locator('#map').boundingBox();
  const [x, y] = [box.x + box.width * 0.25, box.y + box.height * (options.hasTouch ? 0.3 : 0.42)];
  await (options.hasTouch ? page.touchscreen.tap(x, y) : page.mouse.click(x, y));
  await page.locator('#drawer').waitFor({ state: 'visible' });
  await shot('5-link');
  await page.locator('#link-close').click();

  await page.locator('#save').click();
  await page.locator('#save-picture').waitFor();
  await shot('6-save');
  const [picture, tiff] = [await download('#save-picture'), await download('#save-tiff')];
  assert.equal(picture.subarray(1, 4).toString(), 'PNG');
  assert.equal(tiff.subarray(0, 2).toString(), 'II');
  await page.locator('#save-close').click();

  const state = () => 'JSON.stringify([skyshed.state.uavs, skyshed.state.sight, skyshed.state.layer, skyshed.state.kept])';
  const before = await read(state());
  const again = watch(await context.newPage());
  // The address follows the state a moment later.
  for (const until = Date.now() + NEVER_MS; ; await page.waitForTimeout(200)) {
    await again.goto(page.url());
    await again.evaluate('skyshed.ready.then(() => skyshed.idle())');
    if ((await again.evaluate(state())) === before) break;
    assert.ok(Date.now() < until, `${name}: the address does not restore ${before}`);
    await again.goto('about:blank');
  }
  assert.deepEqual(said, [], name);
  assert.equal(await read('window.hacked === undefined'), true);
  await context.close();
  return { uav, digest, command, csv: csv.toString(), geojson: geojson.toString() };
}

let facts;
for (const size of SIZES.filter(({ name }) => wanted.length === 0 || wanted.includes(name))) {
  const found = await use(size);
  facts ??= found;
}

// The page of a comparison opens the same place live, with both placements kept.
const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
context.setDefaultTimeout(NEVER_MS);
const compare = await context.newPage();
const said = [];
context.on('console', (message) => said.push(message.text()));
context.on('weberror', (error) => said.push(error.error().message));
await compare.goto(`file://${comparison}`);
const [live] = await Promise.all([context.waitForEvent('page'), compare.locator('#live').click()]);
await live.waitForLoadState();
await live.evaluate('skyshed.ready.then(() => skyshed.idle())');
assert.deepEqual(await live.evaluate('skyshed.state.kept.map(({ name }) => name)'), ['1', '2']);
assert.equal(await live.evaluate('skyshed.state.uavs[0].id'), '2');
await live.waitForTimeout(800);
await live.screenshot({ path: `${folder}/live-of-compare.png` });
assert.deepEqual(said, [], 'the page of a comparison and its live page');
await browser.close();
console.log(JSON.stringify(facts));
