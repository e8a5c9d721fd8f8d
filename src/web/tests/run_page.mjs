// run_page.mjs PAGE FOLDER [STEP...]: opens a page of runs in Chromium as a desktop and as a phone would and
// uses it as a person does: all steps of that, or those. Pictures and files stay in FOLDER. Exit 1: something
// failed; 77: no Chromium.
import { mkdirSync, readFileSync } from 'node:fs';
import { check, picture, until, verdict, visit } from './checks.mjs';
import { DESKTOP, findBrowser, launch, PHONE, drawn } from './browser.mjs';
import { camera } from './run_camera.mjs';
import { explanations, opening } from './run_opening.mjs';
import { axes, exactNumbers, exports, play, stages, timeCursor, timeSpan, timeTicks, toggles }
  from './run_plots.mjs';
import { initialPositions, landmarkLives, mapMoves, scene } from './run_world.mjs';

const [file, folder, ...chosen] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const data = JSON.parse(/id="report-data">([^]*?)<\/script/.exec(readFileSync(file, 'utf8'))[1]);
const run = data.runs[0];
const single = data.runs.length === 1;

/** The runs of one recording on their truth, or on their floor plan: only where the data has them. */
async function overview(page) {
  const scene = data.scenes.find((s) => s.runs.some((r) => r.run === 0));
  check('the overview is there with several runs or a plan',
    await page.isVisible('#overview') === Boolean(scene));
  if (!scene) return;
  check('its table has a row a run',
    await page.locator('#overview-table tbody tr').count() === scene.runs.length);
  const labels = await page.locator('#overview .legend .key').allTextContents();
  check('each line has a name of its own', new Set(labels).size === labels.length);
  const map = page.locator('#overview-map'), before = await picture(map);
  check('errors are offered only from a truth',
    await page.isVisible('#overview-factor') === Boolean(scene.truth));
  check('and the help mentions a truth, or of its absence',
    await page.isVisible('#overview-help-truth') === Boolean(scene.truth) &&
    await page.isVisible('#overview-help-plan') === !scene.truth);
  if (scene.truth) {
    await page.selectOption('#overview-factor', '20');
    await until('errors are drawn larger', async () => await picture(map) !== before);
    await page.selectOption('#overview-factor', '1');
    await until('and true to scale again', async () => await picture(map) === before);
  }
  const box = page.locator('#overview .legend input').last();
  await box.click();
  await until('its legend hides a run', async () => await picture(map) !== before);
  await box.click();
  await map.press('+');
  await until('it zooms', async () => await picture(map) !== before);
  await map.press('0');
  await until('it shows everything again', async () => await picture(map) === before);
}

async function theme(page) {
  const before = await page.getAttribute('html', 'data-theme');
  await page.click('#theme-button');
  check('the theme changes', await page.getAttribute('html', 'data-theme') !== before);
  await page.click('#theme-button');
}

async function otherRuns(page) {
  if (single) return;
  await page.selectOption('#run-select', '1');
  await until('another run is shown', async () =>
    await page.textContent('#run-name') === (data.runs[1].name || 'Chasles'));
  await drawn(page);
}

async function print(page) {
  // Looks at the page when it has prepared itself for the paper.
  await page.evaluate(() => addEventListener('beforeprint', () => {
    const count = (selector) => document.querySelectorAll(selector).length;
    window.onPaper = [count('.paper-plot > svg'), count('.plot:not(.box-plot)')];
  }, { once: true }));
  await page.pdf({ path: `${folder}/desktop.pdf` });
  const [pictures, plots] = await page.evaluate(() => window.onPaper);
  check('on paper each plot is a vector picture', plots > 0 && pictures === plots, `${pictures} of ${plots}`);
}

const STEPS = [opening, explanations, axes, timeCursor, play, timeSpan, timeTicks, toggles, exports,
  exactNumbers, scene, mapMoves, landmarkLives, initialPositions, stages, camera, overview, theme,
  otherRuns, print];
const unknown = chosen.filter((name) => !STEPS.some((step) => step.name === name));
if (unknown.length) throw new Error(`no step ${unknown}, expected of ${STEPS.map((step) => step.name)}`);
const steps = chosen.length ? STEPS.filter((step) => chosen.includes(step.name)) : STEPS;

async function use(page) {
  for (const step of steps) {
    await step(page, { run, folder }).catch((error) => check(step.name, false, String(error)));
  }
}

const browser = await launch();
const title = run.name || 'Chasles';
await visit(browser, file, folder, { label: 'desktop', title, colorScheme: 'light', ...DESKTOP,
  use });
await visit(browser, file, folder, { label: 'phone', title, colorScheme: 'dark', ...PHONE });
await browser.close();

if (chosen.length) process.exit(verdict());

// Where there is no WebGL the map stands in for the scene.
const flat = await launch(['--disable-3d-apis']);
await visit(flat, file, folder, { label: 'flat', title, ...DESKTOP, use: async (page) => {
  check('without WebGL the map is shown, with a notice', await page.isVisible('#map') &&
    await page.isVisible('#scene-missing') && !await page.isVisible('#scene'));
  check('and no view of a scene is offered',
    !await page.locator('#map-view option[value=orbit]').count());
} });
await flat.close();
process.exit(verdict());
