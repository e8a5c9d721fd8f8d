// calibration_page.mjs PAGE FOLDER KIND: as run_page.mjs, with the page of a calibration of `cameras` or of `noise`.
import { mkdirSync, readFileSync } from 'node:fs';
import { check, until, verdict, visit } from './checks.mjs';
import { DESKTOP, PHONE, findBrowser, launch } from './browser.mjs';

const [file, folder, kind] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const data = JSON.parse(/id="report-data">([^]*?)<\/script/.exec(readFileSync(file, 'utf8'))[1]);

/** Points at a share of a canvas's width and height, and waits until its tip says that. */
async function pointAt(page, label, x, y, expected) {
  const canvas = page.locator(`canvas[aria-label^="${label}"]`).first();
  const { width, height } = await canvas.boundingBox();
  await canvas.hover({ position: { x: x * width, y: y * height } });
  const tip = page.locator('figure', { has: canvas }).locator('.tip');
  await until(`${label}: the tip says ${expected}`, async () =>
    await tip.isVisible() && expected.test(await tip.textContent()));
}

async function useCameras(page) {
  const { calibration } = data, text = await page.textContent('main');
  for (const part of ['Error of cam0', 'before: 0.400 px', 'Held-out error', '1.50']) {
    check(`the head has ${part}`, text.includes(part));
  }
  for (const sentence of [...calibration.suspicious, ...calibration.remarks]) {
    check('sentences are shown as text', text.includes(sentence));
  }
  check('halves that differ are named', /in 1 of 5 parameters, at most by 4.0 σ in cam1.fx/.test(text));
  check('there are four figures a camera', await page.locator('.figure-box canvas').count() === 8);
  const rows = page.locator('table.calibration').first().locator('tbody tr');
  check('there is a row a parameter', await rows.count() === calibration.parameters.length);
  check('one of them is marked', await rows.locator('.badge').count() === 1);
  check('strong correlations are listed', text.includes('cam0.fx and cam0.fy: −0.400'));
  check('the lens is marked', await page.locator('tr', { hasText: 'chosen' }).locator('th').textContent() === 'radtan');
  await pointAt(page, 'standard deviation of the projection over the image of cam0', 0.5, 0.45, /0\.0\d+ px, 0\.1\d* mm at 1 m/);
  await pointAt(page, 'corners over the image of cam0', 0.82, 0.2, /^0 corners/);
  await pointAt(page, 'reprojection errors over the image of cam1', 0.4, 0.33, /corners here, mean error/);
  await pointAt(page, 'correlations of 5', 0.6, 0.4, /cam\d.* and cam\d/);
}

async function useNoise(page) {
  const text = await page.textContent('main');
  check('limits are limits', text.includes('≤\u00a02.00e−5'));
  check('what is not shown is a limit', text.includes('≤ 1.00e−5'));
  check('remarks are shown as text', text.includes(data.noise.remarks[0]));
  check('there is a plot a sensor', await page.locator('canvas').count() === 2);
}

const page = kind === 'noise' ? { title: 'Noise of an IMU', plots: 2, use: useNoise } :
  { title: 'Calibration of cameras', plots: 10, use: useCameras };
const browser = await launch();
await visit(browser, file, folder, { label: 'desktop', ...page, ...DESKTOP });
await visit(browser, file, folder, { label: 'phone', ...page, use: undefined, colorScheme: 'dark', ...PHONE });
await browser.close();
process.exit(verdict());
