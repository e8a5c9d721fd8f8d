// What holds for every page, on a desktop and on a phone.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { frames, open, settle } from './browser.mjs';
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

/** The colours that the visible part of a canvas has, at most a few. */
export const coloursOf = (locator) => locator.evaluate((canvas) => {
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext('2d');
  pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data;
  return new Set(new Uint32Array(data.buffer).filter((_, i) => i % 7 === 0)).size;
});

/** Lets the page save a file into the folder, and gives its name and bytes. */
export async function saved(page, folder, trigger) {
  const [download] = await Promise.all([page.waitForEvent('download'), trigger()]);
  const path = `${folder}/${download.suggestedFilename()}`;
  await download.saveAs(path);
  return { name: download.suggestedFilename(), bytes: readFileSync(path) };
}

export const picture = (locator) => locator.evaluate((canvas) => canvas.toDataURL());

/** Scrolls through the page, for what is drawn only when it comes near. */
async function scrollThrough(page) {
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  for (let y = 0; y < height; y += 1200) {
    await page.evaluate((top) => scrollTo(0, top), y);
    await frames(page);
  }
  await page.evaluate(() => scrollTo(0, 0));
  await settle(page);
}

async function accessibility(page, name) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => axe.run());
  for (const v of violations.filter(({ impact }) => ['serious', 'critical'].includes(impact))) {
    check(`${name}: axe ${v.id}`, false, v.nodes.slice(0, 3).map((n) => n.html.slice(0, 160)).join(' | '));
  }
}

/** Looks at a page of that size and theme once it is `ready`, leaves a picture in the folder, and lets
 *  `use` use it. At least `plots` canvases are there. */
export async function visit(browser, file, folder, { label, title, ready, use, plots = 5, ...options }) {
  const { page, words, context } = await open(browser, file, options);
  if (ready) await ready(page);
  await settle(page);
  await page.screenshot({ path: `${folder}/${label}.png` });
  await scrollThrough(page);
  check(`${label}: the name is shown as text`, await page.textContent('#run-name') === title);
  check(`${label}: nothing came in with a name`, await page.evaluate(() =>
    window.hostile === undefined && !document.querySelector('img')));
  check(`${label}: nothing sticks out to the side`, await page.evaluate(() =>
    document.documentElement.scrollWidth <= document.documentElement.clientWidth));
  const text = await page.evaluate(() => document.body.innerText);
  check(`${label}: no number is NaN or undefined`, !/\bNaN\b|undefined|Infinity|\bnull\b/.test(text),
    /.{0,40}(\bNaN\b|undefined|Infinity|\bnull\b).{0,20}/.exec(text)?.[0]);
  const canvases = await page.locator('canvas:not(#scene, .sign):visible').all();
  check(`${label}: there are plots`, canvases.length >= plots, String(canvases.length));
  for (const [k, canvas] of canvases.entries()) {
    check(`${label}: canvas ${k} is drawn`, await coloursOf(canvas) > 3);
  }
  await accessibility(page, label);
  if (use) await use(page, label);
  check(`${label}: the console is silent and nothing is loaded`, words.length === 0, words.join(' | '));
  await context.close();
}
