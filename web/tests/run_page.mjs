// run_page.mjs PAGE FOLDER: opens a page of runs in Chromium as a desktop and as a phone would and uses
// it as a person does. Pictures and files stay in FOLDER. Exit 1: something failed; 77: no Chromium.
import { mkdirSync, readFileSync } from 'node:fs';
import { check, picture, until, verdict, visit } from './checks.mjs';
import { camera } from './run_camera.mjs';
import { DESKTOP, findBrowser, launch, PHONE, settle } from './browser.mjs';

const [file, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const data = JSON.parse(/id="report-data">([^]*?)<\/script/.exec(readFileSync(file, 'utf8'))[1]);
const run = data.runs[0];
const single = data.runs.length === 1;

const cursor = (page) => page.inputValue('#time').then(Number);
const plot = (page, k = 0) => page.locator('.plot .u-over').nth(k);

async function timeCursor(page) {
  await plot(page).scrollIntoViewIfNeeded();
  const box = await plot(page).boundingBox();
  const last = Number(await page.getAttribute('#time', 'max'));
  let nudge = 0;
  await until('a plot moves the cursor', async () => {
    await page.mouse.move(box.x + 0.4 * box.width + (nudge++ % 2), box.y + 30);
    return Math.abs(await cursor(page) - 0.4 * last) < 4;
  });
  const lines = await page.locator('.plot-host .time-cursor').evaluateAll((all) => all
    .filter((line) => line.offsetParent).map((line) => Number.parseFloat(line.style.left)));
  check('all plots show the cursor at one time', lines.length > 3 &&
    lines.every((left) => Math.abs(left - 40) < 1), lines.join());
  const before = await cursor(page);
  await page.locator('.plot-stack').first().press('ArrowLeft');
  await settle(page);
  check('the left arrow goes back a frame', await cursor(page) === before - 1);
  await page.locator('#time').focus();
  await page.locator('#time').press('Home');
  await until('the slider scrubs', async () => await cursor(page) === 0);
  await until('the time is told', async () => await page.textContent('#time-text') === '0.00 s');
}

async function play(page) {
  await page.selectOption('#speed', '20');
  await page.click('#play');
  await until('play moves the cursor', async () => await cursor(page) > 5);
  // In one go: the run may end at any time, and the button then starts it again.
  await page.evaluate(() => {
    const button = document.getElementById('play');
    if (button.getAttribute('aria-label') === 'Pause') button.click();
  });
  await settle(page);
  const stopped = await cursor(page);
  await settle(page);
  check('pause stops it', await cursor(page) === stopped);
}

async function timeSpan(page) {
  await plot(page).scrollIntoViewIfNeeded();
  const box = await plot(page).boundingBox();
  await page.mouse.move(box.x + 100, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + 220, box.y + 30, { steps: 4 });
  await page.mouse.up();
  await until('dragging zooms in time', () => page.isVisible('#zoom-reset'));
  await page.locator('.plot-stack').first().press('Escape');
  await until('escape shows all times', async () => !await page.isVisible('#zoom-reset'));
}

async function toggles(page) {
  const figure = page.locator('figure.plot', { has: page.locator('.toggle') }).first();
  const canvas = figure.locator('canvas').first(), box = figure.locator('.toggle input').last();
  await figure.scrollIntoViewIfNeeded();
  await page.mouse.move(2, 2);
  await settle(page);
  const before = await picture(canvas);
  await box.click();
  await until('a legend hides a series', async () => await picture(canvas) !== before);
  await box.click();
  await until('a legend shows the series again', async () => await picture(canvas) === before);
}

/** Lets the page save a file, and gives its text. */
async function saved(page, trigger) {
  const [download] = await Promise.all([page.waitForEvent('download'), trigger()]);
  const path = `${folder}/${download.suggestedFilename()}`;
  await download.saveAs(path);
  return { name: download.suggestedFilename(), bytes: readFileSync(path) };
}

async function exports(page) {
  const figure = page.locator('figure.plot').first();
  const files = {};
  for (const kind of ['PNG', 'SVG', 'CSV']) {
    files[kind] = await saved(page, () => figure.getByRole('button', { name: kind }).click());
    check(`${kind}: the file's name is safe`, /^[A-Za-z0-9_][A-Za-z0-9._-]*$/.test(files[kind].name),
      files[kind].name);
  }
  check('the PNG is one', files.PNG.bytes.subarray(1, 4).toString() === 'PNG' &&
    files.PNG.bytes.length > 10000, String(files.PNG.bytes.length));
  const rows = files.CSV.bytes.toString().trim().split('\n').length;
  const last = Number(await page.getAttribute('#time', 'max'));
  check('the csv has a row a frame', rows === last + 2, `${rows}`);
  const svg = files.SVG.bytes.toString();
  const sound = await page.evaluate((text) => {
    const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
    return !parsed.querySelector('parsererror') && parsed.querySelectorAll('path').length > 3 &&
      !parsed.querySelector('script');
  }, svg);
  check('the SVG is well formed and without scripts', sound);
}

async function exactNumbers(page) {
  const { nees_pose: value } = run.summary;
  if (typeof value !== 'number') return;
  const card = page.locator('.card-value[data-exact^="nees_pose:"]');
  await card.scrollIntoViewIfNeeded();
  await settle(page);
  await card.hover();
  await until('a figure tells the number of summary.json under the pointer', async () =>
    await page.textContent('.exact-tip') === `nees_pose: ${value}` && page.isVisible('.exact-tip'));
  await page.mouse.move(2, 2);
}

/** The scene is drawn by WebGL, which keeps no picture: a screenshot of it. */
const sceneShot = async (page) => (await page.locator('#scene').screenshot()).toString('base64');

async function scene(page) {
  const canvas = page.locator('#scene');
  check('the scene is shown at first', await canvas.isVisible() && !await page.isVisible('#map'));
  await canvas.scrollIntoViewIfNeeded();
  await page.mouse.move(2, 2);
  await settle(page);
  const first = await sceneShot(page);
  await canvas.press('ArrowLeft');
  await until('an arrow key turns the scene', async () => await sceneShot(page) !== first);
  await canvas.press('0');
  if (run.plan) await planInScene(page);
  await page.selectOption('#map-view', 'above');
  await until('from above it looks different', async () => await sceneShot(page) !== first);
  await page.selectOption('#map-view', 'follow');
  await settle(page);
  const behind = await sceneShot(page);
  await page.locator('#time').press('Home');
  await until('the scene follows the cursor', async () => await sceneShot(page) !== behind);
  const { bytes } = await saved(page, () => page.click('#map-png'));
  check('the scene is saved as a picture', bytes.length > 10000, String(bytes.length));
}

/** The legend takes the floor plan away and brings it back. */
async function planInScene(page) {
  const box = page.locator('#map-legend label', { hasText: 'Floor plan' }).locator('input');
  await box.click();
  await settle(page);
  const without = await sceneShot(page);
  await box.click();
  await until('the legend shows the floor plan', async () => await sceneShot(page) !== without);
  await box.click();
  await until('the legend hides the floor plan', async () => await sceneShot(page) === without);
  await box.click();
}

async function mapMoves(page) {
  await page.selectOption('#map-view', 'top');
  const map = page.locator('#map');
  await map.scrollIntoViewIfNeeded();
  await settle(page);
  const box = await map.boundingBox(), before = await picture(map);
  await page.mouse.move(box.x + 150, box.y + 150);
  await page.mouse.wheel(0, -100);
  await until('the wheel scrolls the page at first', () => page.isVisible('#map-hint'));
  await map.focus();
  await map.press('+');
  await until('+ zooms', async () => await picture(map) !== before);
  await map.press('0');
  await page.selectOption('#map-view', 'side');
  await settle(page);
  check('the side view differs', await picture(map) !== before);
  await page.selectOption('#map-view', 'top');
  if (!await page.locator('#map-legend .dots').count()) return;
  await findTip(page, map);
}

/** Goes over the map until a landmark answers. */
async function findTip(page, map) {
  const box = await map.boundingBox(), tip = page.locator('#map-tip');
  await map.evaluate((canvas) => {
    const frame = canvas.getBoundingClientRect(), tipBox = document.getElementById('map-tip');
    for (let y = 20; y < frame.height && tipBox.hidden; y += 9) {
      for (let x = 20; x < frame.width && tipBox.hidden; x += 9) {
        canvas.dispatchEvent(new PointerEvent('pointermove', { pointerType: 'mouse', pointerId: 1,
          clientX: frame.left + x, clientY: frame.top + y }));
      }
    }
  });
  const text = await tip.textContent();
  check('a landmark tells its numbers', await tip.isVisible() && /Landmark \d+/.test(text) &&
    text.includes('σ'), text);
  const place = await tip.boundingBox();
  check('the numbers stay within the map', place && place.x >= box.x &&
    place.x + place.width <= box.x + box.width + 1);
}

/** Landmarks in view, retired and seen later differ at the cursor's time, and go one by one. */
async function landmarkLives(page) {
  if (!await page.locator('#map-legend .dots').count()) return;
  const map = page.locator('#map'), start = await picture(map);
  await page.locator('#time').focus();
  await page.locator('#time').press('End');
  await until('landmarks age with the cursor', async () => await picture(map) !== start);
  await page.mouse.move(2, 2);
  await settle(page);
  for (const name of ['Landmarks in view', 'retired']) {
    const before = await picture(map);
    const box = page.locator('#map-legend label', { hasText: name }).locator('input');
    await box.click();
    await until(`${name}: the legend hides them`, async () => await picture(map) !== before);
    await box.click();
    await until(`${name}: and shows them again`, async () => await picture(map) === before);
  }
}

/** What a frame took, by stages. */
async function stages(page) {
  const figure = page.locator('figure.plot', { hasText: run.stages.length ? 'Time per stage' :
    'Time per frame' });
  await figure.scrollIntoViewIfNeeded();
  check('there is a plot of times', await figure.count() === 1);
  for (const name of run.stage_names) {
    check(`${name}: is in the legend`,
      await figure.locator('.legend', { hasText: name.replace('_', ' ') }).count() === 1);
  }
  if (run.stages.length) {
    const { bytes } = await saved(page, () => figure.getByRole('button', { name: 'CSV' }).click());
    const head = bytes.toString().split('\n')[0];
    check('the csv has a column a stage', head.split(',').length ===
      run.stages.length + 2 && head.includes('front end'), head);
  }
}

const keptImages = (page) => camera(page, run);

/** The runs of one recording on their truth: only where the data has them. */
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
  await page.selectOption('#overview-factor', '20');
  await until('deviations are drawn larger', async () => await picture(map) !== before);
  await page.selectOption('#overview-factor', '1');
  await until('and true to scale again', async () => await picture(map) === before);
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
  await settle(page);
}

async function print(page, label) {
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  check('on paper each plot is a vector picture', await page.locator('.paper-plot > svg').count() ===
    await page.locator('.plot:not(.box-plot)').count());
  await page.pdf({ path: `${folder}/${label}.pdf` });
  await page.evaluate(() => window.dispatchEvent(new Event('afterprint')));
}

async function use(page, label) {
  for (const step of [timeCursor, play, timeSpan, toggles, exports, exactNumbers, scene, mapMoves, landmarkLives,
    stages, keptImages, overview, theme, otherRuns]) {
    await step(page).catch((error) => check(step.name, false, String(error)));
  }
  await print(page, label).catch((error) => check('print', false, String(error)));
}

const browser = await launch();
const title = run.name || 'Chasles';
await visit(browser, file, folder, { label: 'desktop', title, colorScheme: 'light', ...DESKTOP,
  use });
await visit(browser, file, folder, { label: 'phone', title, colorScheme: 'dark', ...PHONE });
await browser.close();

// Where there is no WebGL the map stands in for the scene.
const flat = await launch(['--disable-3d-apis']);
await visit(flat, file, folder, { label: 'flat', title, ...DESKTOP, use: async (page) => {
  check('without WebGL the map is shown, and said to be', await page.isVisible('#map') &&
    await page.isVisible('#scene-missing') && !await page.isVisible('#scene'));
  check('and no view of a scene is offered',
    !await page.locator('#map-view option[value=orbit]').count());
} });
await flat.close();
process.exit(verdict());
