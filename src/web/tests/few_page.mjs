// few_page.mjs PAGE FOLDER: a page of runs that have hardly anything, or what is no number, in Chromium:
// each is looked at from everywhere. Exit 1: something failed; 77: no Chromium.
import { mkdirSync } from 'node:fs';
import { findBrowser, launch, open, drawn } from './browser.mjs';
import { check, saved, verdict } from './checks.mjs';

const [file, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const browser = await launch();
const { page, words } = await open(browser, file);
await drawn(page);
for (const [k, { count }] of (await page.evaluate(() =>
  JSON.parse(document.getElementById('report-data').textContent).runs.map(({ states }) =>
    ({ count: states.t.length })))).entries()) {
  await page.selectOption('#run-select', String(k));
  // A processor takes seconds to draw a scene of 1e30 m: the last run is looked at on the map alone.
  for (const view of [...(k < 3 ? ['orbit', 'above', 'follow'] : []), 'top', 'side']) {
    await page.selectOption('#map-view', view);
    await drawn(page);
    for (const key of ['Home', 'End']) await page.locator('#time').press(key);
    await page.click('#play');
    await drawn(page);
  }
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  for (let y = 0; y < height; y += 600) {
    await page.evaluate((top) => scrollTo(0, top), y);
    await drawn(page);
  }
  const text = await page.evaluate(() => document.body.innerText);
  const odd = /.{0,40}(\bNaN\b|undefined|Infinity|\bnull\b).{0,20}/.exec(text)?.[0];
  check(`run ${k}: no number is NaN or undefined`, odd === undefined, odd);
  const figure = page.locator('figure.plot').first();
  for (const kind of ['CSV', 'SVG', 'PNG']) {
    const { bytes } = await saved(page, folder, () => figure.getByRole('button', { name: kind }).click());
    check(`run ${k}: ${kind} is saved`, bytes.length > 0 && !/NaN/.test(bytes.toString()), `${count}`);
  }
  await saved(page, folder, () => page.click('#map-png'));
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  await page.evaluate(() => window.dispatchEvent(new Event('afterprint')));
  check(`run ${k}: the console is silent`, words.length === 0, words.splice(0).join(' | '));
}
await browser.close();
process.exit(verdict());
