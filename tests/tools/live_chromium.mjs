// Asks the engine of a live page in headless Chromium, as live.mjs does without one.
// node live_chromium.mjs PAGE.html < questions, one JSON a line > answers, one JSON a line
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';

const { chromium } = createRequire(`${process.env.NODE_PATH}/`)('playwright-core');
const [file] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] });
const page = await browser.newPage();
await page.goto(`file://${file}`);
await page.evaluate('skyshed.ready');
console.log(await page.evaluate('JSON.stringify({ ...engine.opened, tone: null })'));
for (const line of readFileSync(0, 'utf8').split('\n').filter(Boolean)) {
  console.log(await page.evaluate(`ask(${line}).then(({ picture, ...answer }) => JSON.stringify(answer))`));
}
await browser.close();
