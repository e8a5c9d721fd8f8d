// What holds for every page, on a desktop and on a phone.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { frames, open, drawn } from './browser.mjs';
import { check } from './verdict.mjs';

export { check, verdict } from './verdict.mjs';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
/** Waits until `probe` is true; a machine that is busy answers late. */
export async function until(name, probe, seconds = 3) {
  for (let tries = 0; tries < 20 * seconds; tries++) {
    if (await probe()) return;
    await new Promise((done) => setTimeout(done, 50));
  }
  check(name, false);
}

/** How many colours each canvas has among a seventh of its pixels. */
export const coloursOf = (locator) => locator.evaluateAll((canvases) => canvases.map((canvas) =>
  new Set(pixelsOf(canvas).filter((_, i) => i % 7 === 0)).size));

/** Distinguishes one picture of a canvas from another: its size and two sums over all pixels, which take a third
 *  of the time of a PNG. */
export const picture = (locator) => locator.evaluate((canvas) => {
  let a = 1, b = 1;
  for (const pixel of pixelsOf(canvas)) {
    a = Math.imul(a ^ pixel, 0x9e3779b1);
    b = Math.imul(b + pixel, 0x85ebca6b) ^ (b >>> 15);
  }
  return `${canvas.width}x${canvas.height}:${a >>> 0}:${b >>> 0}`;
});

const sessions = new WeakMap();

/** A screenshot of an element, for WebGL keeps no picture; of little compression, which is quick. */
export async function screenshot(page, selector) {
  if (!sessions.has(page)) sessions.set(page, await page.context().newCDPSession(page));
  const clip = await page.locator(selector).evaluate((element) => {
    element.scrollIntoViewIfNeeded();
    const { x, y, width, height } = element.getBoundingClientRect();
    return { x: Math.round(x + scrollX), y: Math.round(y + scrollY), width: Math.round(width),
      height: Math.round(height), scale: 1 };
  });
  const { data } = await sessions.get(page).send('Page.captureScreenshot',
    { format: 'png', optimizeForSpeed: true, clip });
  return data;
}

/** Lets the page save a file into the folder, and gives its name and bytes. */
export async function saved(page, folder, trigger) {
  const [download] = await Promise.all([page.waitForEvent('download'), trigger()]);
  const path = `${folder}/${download.suggestedFilename()}`;
  await download.saveAs(path);
  return { name: download.suggestedFilename(), bytes: readFileSync(path) };
}

/** Scrolls through the page, for what is drawn only when it comes near. */
async function scrollThrough(page) {
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  for (let y = 0; y < height; y += 1200) {
    await page.evaluate((top) => scrollTo(0, top), y);
    await frames(page);
  }
  await page.evaluate(() => scrollTo(0, 0));
  await drawn(page);
}

async function accessibility(page, name) {
  await page.evaluate(AXE);
  // To list what passes would take as long as the rules.
  const violations = await page.evaluate(async () =>
    (await axe.run({ resultTypes: ['violations'] })).violations.map(({ id, impact, nodes }) =>
      ({ id, impact, html: nodes.slice(0, 3).map((n) => n.html.slice(0, 160)).join(' | ') })));
  for (const { id, html } of violations.filter((v) => ['serious', 'critical'].includes(v.impact))) {
    check(`${name}: axe ${id}`, false, html);
  }
}

/** Looks at a page of that size and theme once it is `ready`, leaves a picture in the folder, and lets
 *  `use` use it. At least `plots` canvases are there. */
export async function visit(browser, file, folder, { label, title, ready, use, plots = 5, ...options }) {
  const { page, words, context } = await open(browser, file, options);
  if (ready) await ready(page);
  await drawn(page);
  await page.screenshot({ path: `${folder}/${label}.png` });
  await scrollThrough(page);
  check(`${label}: the name is shown as text`, await page.textContent('#run-name') === title);
  check(`${label}: nothing came in with a name`, await page.evaluate(() =>
    window.hostile === undefined && !document.querySelector('img:not(.thumbnail)')));
  check(`${label}: nothing sticks out to the side`, await page.evaluate(() =>
    document.documentElement.scrollWidth <= document.documentElement.clientWidth));
  const text = await page.evaluate(() => document.body.innerText);
  check(`${label}: no number is NaN or undefined`, !/\bNaN\b|undefined|Infinity|\bnull\b/.test(text),
    /.{0,40}(\bNaN\b|undefined|Infinity|\bnull\b).{0,20}/.exec(text)?.[0]);
  const colours = await coloursOf(page.locator('canvas:not(#scene, .sign):visible'));
  check(`${label}: there are plots`, colours.length >= plots, String(colours.length));
  for (const [k, count] of colours.entries()) check(`${label}: canvas ${k} is drawn`, count > 3);
  await accessibility(page, label);
  if (use) await use(page, label);
  check(`${label}: the console is silent and nothing is loaded`, words.length === 0, words.join(' | '));
  await context.close();
}
