// Does to a page of the program what a person does, step by step, in headless Chromium. Any word on its console is a failure.
// node live_steps.mjs PAGE.html [WIDTH,HEIGHT[,dark]] < steps, one JSON a line > answers of the steps that ask, one JSON a line
// {"open": "#fragment"}, {"fill": ["#id", "text"]}, {"leave": "#id"}, {"choose": ["#id", "value"]}, {"press": ["#id", "Key"]},
// {"click": "#id"}, {"follow": "#id"} (a click that opens another page, which the next steps are about), {"ask": "expression"},
// {"look": "file.png"}, {"before": "script"} (that runs before those of pages opened from then on)
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';

const { chromium } = createRequire(`${process.env.NODE_PATH}/`)('playwright-core');
const [file, size = '1280,800'] = process.argv.slice(2);
const [width, height, theme] = size.split(',');
// However busy the machine is: only what never happens fails.
const NEVER_MS = 300_000;
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] });
const viewport = { width: Number(width), height: Number(height) };
const context = await browser.newContext({ viewport, colorScheme: theme === 'dark' ? 'dark' : 'light', locale: 'en-US' });
context.setDefaultTimeout(NEVER_MS);
const said = [];
context.on('console', (message) => said.push(message.text()));
context.on('weberror', (error) => said.push(error.error().stack ?? error.error().message));
let page = await context.newPage();
/** Waits until a live page rests, unless it cannot work; others are ready at once. */
const rest = () => page.evaluate('window.skyshed && skyshed.ready.then(() => engine.opened && skyshed.idle())');
const steps = {
  open: async (fragment) => {
    // A fragment alone would not load the page anew.
    await page.goto('about:blank');
    await page.goto(`file://${file}${fragment}`);
  },
  fill: ([selector, text]) => page.locator(selector).fill(text),
  leave: (selector) => page.locator(selector).blur(),
  choose: ([selector, value]) => page.locator(selector).selectOption(value),
  press: ([selector, key]) => page.locator(selector).press(key),
  click: (selector) => page.locator(selector).click(),
  follow: async (selector) => {
    [page] = await Promise.all([context.waitForEvent('page'), page.locator(selector).click()]);
    await page.waitForLoadState();
  },
  before: (script) => context.addInitScript(script),
  look: (path) => page.screenshot({ path }),
  ask: async (expression) => console.log(JSON.stringify((await page.evaluate(expression)) ?? null)),
};
for (const line of readFileSync(0, 'utf8').split('\n').filter(Boolean)) {
  for (const [what, how] of Object.entries(JSON.parse(line))) await steps[what](how);
  await rest();
}
await browser.close();
if (said.length > 0) throw new Error(said.join('\n'));
