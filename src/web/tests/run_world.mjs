// The scene and the map of a page of runs, used as a person does.
import { inflateSync } from 'node:zlib';
import { drawn } from './browser.mjs';
import { check, picture, saved, screenshot, until } from './checks.mjs';

const detail = (page) => page.getAttribute('#scene', 'data-detail');

/** A screenshot of the scene once it is still, and without the frame that shows that it has the focus. */
async function sceneShot(page) {
  await page.locator('#scene').evaluate((canvas) => {
    canvas.scrollIntoViewIfNeeded();  // far from the screen it would stay as it is
    canvas.blur();
  });
  await drawn(page);
  await until('a static scene is drawn in full', async () => await detail(page) === 'full');
  return screenshot(page, '#scene');
}

export async function scene(page, { run, folder }) {
  const canvas = page.locator('#scene');
  check('the scene is shown at first', await canvas.isVisible() && !await page.isVisible('#map'));
  await drawnNearTheScreen(page);
  await canvas.scrollIntoViewIfNeeded();
  await page.mouse.move(2, 2);
  await drawn(page);
  const first = await sceneShot(page);
  await canvas.press('ArrowLeft');
  await until('an arrow key turns the scene', async () => await sceneShot(page) !== first);
  await motion(page);
  check('at first it shows what 0 makes it show', await sceneShot(page) === first);
  if (run.plan) await planInScene(page);
  if (run.summary.closures) await closuresInScene(page, first);
  if (run.map) await savedMapInScene(page, run.map);
  await page.selectOption('#map-view', 'above');
  await until('the view from above differs', async () => await sceneShot(page) !== first);
  await page.selectOption('#map-view', 'follow');
  await drawn(page);
  const behind = await sceneShot(page);
  await page.locator('#time').press('Home');
  await until('the scene follows the cursor', async () => await sceneShot(page) !== behind);
  const { bytes } = await saved(page, folder, () => page.click('#map-png'));
  check('the scene is saved as a picture', bytes.length > 10000, String(bytes.length));
}

/** Far from the screen the scene is not drawn; when it comes near it shows what has changed. */
async function drawnNearTheScreen(page) {
  const last = page.locator('.plot-stack').last();
  await last.press('End');
  const before = await sceneShot(page);
  await last.scrollIntoViewIfNeeded();
  await drawn(page);
  await page.evaluate(() => {
    const { prototype } = WebGL2RenderingContext, { clear } = prototype;
    window.drawings = 0;
    prototype.clear = function count(mask) {
      window.drawings++;
      clear.call(this, mask);
    };
  });
  const drawings = () => page.evaluate(() => window.drawings);
  await last.press('Home');
  await drawn(page);
  check('far from the screen the scene is not drawn', await drawings() === 0, String(await drawings()));
  check('and it catches up', await sceneShot(page) !== before && await drawings() > 0);
  await last.press('End');
}

/** The rings where loops were closed, and what the figures say about them. */
async function closuresInScene(page, before) {
  const box = page.getByLabel('Loop closures');
  await box.uncheck();
  await until('the legend hides the loop closures', async () => await sceneShot(page) !== before);
  const without = await sceneShot(page);
  await box.check();
  await until('and shows them again', async () => await sceneShot(page) !== without);
  const figures = await page.locator('#figures tr').allTextContents();
  check('their number is a figure', figures.some((row) => row.startsWith('Loop closures2')));
  await page.click('#closures-title');
  const description = await page.locator('#closures tbody tr').first().textContent();
  check('each shows its jump and its chi2', /20\.\d\d s.*0\.250 m.*8\.50 of 12/.test(description), description);
  check('so is their largest jump', figures.some((row) => row.includes('closure0.250 m')), figures.join('|'));
}

/** The map in which the run found its place, in the colours of its sessions. */
async function savedMapInScene(page, { sessions }) {
  const before = await sceneShot(page);
  for (const { name } of sessions) {
    const box = page.getByLabel(`Map: ${name}`);
    await box.uncheck();
    await until(`the legend hides ${name}`, async () => await sceneShot(page) !== before);
    await box.check();
  }
  await until('and shows both again', async () => await sceneShot(page) === before);
  check('what that means is shown', await page.locator('#saved-help').isVisible());
}

/** A processor draws a scene in motion with fewer dots; without motion it is the picture that it was. Returns
 *  how many dots there were in motion, at most. */
export async function motion(page) {
  const canvas = page.locator('#scene');
  await canvas.press('0');
  const still = await sceneShot(page);
  const details = await canvas.evaluate(async (scene) => {
    const seen = [];
    for (let i = 0; i < 12; i++) {
      scene.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight' }));
      await new Promise(requestAnimationFrame);
      await new Promise(requestAnimationFrame);
      seen.push(scene.dataset.detail);
    }
    return seen;
  });
  const dots = details.map((description) => /^coarse: (\d+) of (\d+) dots$/.exec(description)).filter(Boolean);
  check('in motion it is drawn coarsely', dots.length > 6, details.join());
  check('and none is drawn twice or invented', dots.every(([, n, all]) => Number(n) <= Number(all)));
  const many = Number(dots[0]?.[2]) >= 2000;
  check('in motion many dots at one place are one', !many ||
    dots.every(([, n, all]) => Number(n) < 0.8 * Number(all)), details.join());
  await canvas.press('0');
  check('a static scene is unchanged', await sceneShot(page) === still);
  return Math.max(...dots.map(([, n]) => Number(n)));
}

/** The legend takes the floor plan away and brings it back. */
async function planInScene(page) {
  const box = page.locator('#map-legend label', { hasText: 'Floor plan' }).locator('input');
  const before = await sceneShot(page);
  await box.click();
  await until('the legend hides the floor plan', async () => await sceneShot(page) !== before);
  await box.click();
  await until('the legend shows the floor plan', async () => await sceneShot(page) === before);
}

export async function mapMoves(page, { run }) {
  await page.selectOption('#map-view', 'top');
  const map = page.locator('#map');
  await map.scrollIntoViewIfNeeded();
  await drawn(page);
  const box = await map.boundingBox(), before = await picture(map);
  await page.mouse.move(box.x + 150, box.y + 150);
  await page.mouse.wheel(0, -100);
  await until('the wheel scrolls the page at first', () => page.isVisible('#map-hint'));
  await map.focus();
  await map.press('+');
  await until('+ zooms', async () => await picture(map) !== before);
  await map.press('0');
  await page.selectOption('#map-view', 'side');
  await drawn(page);
  check('the side view differs', await picture(map) !== before);
  await page.selectOption('#map-view', 'top');
  if (!await page.locator('#map-legend .dots').count()) return;
  await findTip(page, map, run);
}

/** The numbers of a column of the page's data: see data.ts. */
export function numbers(column) {
  const planes = inflateSync(Buffer.from(column.slice(4), 'base64'));
  const size = column.startsWith('f64:') ? 8 : 4, count = planes.length / size;
  const { buffer } = Uint8Array.from(planes, (_, i) => planes[(i % size) * count + Math.floor(i / size)]);
  if (column.startsWith('i32:')) return new Int32Array(buffer);
  return size === 8 ? new Float64Array(buffer) : new Float32Array(buffer);
}

/** How far the landmark of that number has moved since its initialisation; NaN where this is not known. */
function distanceMoved({ landmarks }, id) {
  if (!landmarks.ix) return NaN;
  const row = numbers(landmarks.id).indexOf(id);
  return Math.hypot(...['x', 'y', 'z'].map((axis) =>
    numbers(landmarks[axis])[row] - numbers(landmarks[`i${axis}`])[row]));
}

/** Goes over the map until a landmark answers. */
async function findTip(page, map, run) {
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
  check('a landmark shows its numbers', await tip.isVisible() && /Landmark \d+/.test(text) &&
    text.includes('σ'), text);
  const description = /moved (.+) m since initialisation$/.exec(text)?.[1].replace(/\u202f/g, '')
    .replace('−', '-');
  const moved = distanceMoved(run, Number(/Landmark (\d+)x, y/.exec(text)?.[1]));
  // Two digits are shown.
  check('and how far it has moved where this is known', Number.isFinite(moved) ?
    Math.abs(Number(description) - moved) <= 0.06 * moved : description === undefined, `${text}: ${moved}`);
  const place = await tip.boundingBox();
  check('the numbers stay within the map', place && place.x >= box.x &&
    place.x + place.width <= box.x + box.width + 1);
}

/** Landmarks in view, retired and seen later differ at the cursor's time, and go one by one. */
export async function landmarkLives(page) {
  if (!await page.locator('#map-legend .dots').count()) return;
  const map = page.locator('#map'), start = await picture(map);
  await page.locator('#time').focus();
  await page.locator('#time').press('End');
  await until('landmarks age with the cursor', async () => await picture(map) !== start);
  await page.mouse.move(2, 2);
  await followed(page, map);
  for (const name of ['Landmarks in view', 'retired']) {
    const before = await picture(map);
    const box = page.locator('#map-legend label', { hasText: name }).locator('input');
    await box.click();
    await until(`${name}: the legend hides them`, async () => await picture(map) !== before);
    await box.click();
    await until(`${name}: and shows them again`, async () => await picture(map) === before);
  }
}

/** What a step of the cursor draws anew makes the picture that drawing all of it makes. */
async function followed(page, map) {
  for (const key of ['Home', 'PageUp', 'ArrowLeft', 'End']) {
    await page.locator('#time').press(key);
    await drawn(page);
    const stepped = await picture(map);
    await page.click('#map-fit');
    await drawn(page);
    check(`${key}: the map follows the cursor as if drawn anew`, await picture(map) === stepped);
    await page.locator('#time').focus();
  }
}

/** Where landmarks were initialised: a layer of the map, and columns of the csv, where this is known. */
export async function initialPositions(page, { run, folder }) {
  if (!await page.locator('#map-legend .dots').count()) return;
  const known = Boolean(run.landmarks.ix), map = page.locator('#map');
  const entry = page.locator('#map-legend label', { hasText: 'Initial positions' });
  check('the legend has initial positions where they are known', await entry.count() === Number(known));
  const { bytes } = await saved(page, folder, () => page.click('#map-csv'));
  const head = bytes.toString().split('\n')[0];
  check('and so has the csv', head.endsWith(',"initial_x_m","initial_y_m","initial_z_m"') === known, head);
  if (!known) return;
  const box = entry.locator('input');
  check('at first they are shown of a map along known poses',
    await box.isChecked() === (run.summary.mode === 'map'));
  await box.setChecked(true);
  await page.mouse.move(2, 2);
  await drawn(page);
  const shown = await picture(map);
  await box.click();
  await until('the legend hides the initial positions', async () => await picture(map) !== shown);
  await box.click();
  await until('the legend shows the initial positions', async () => await picture(map) === shown);
  await followed(page, map);
  await page.selectOption('#map-view', 'above');
  check('the scene has no initial positions', await entry.count() === 0);
  await page.selectOption('#map-view', 'top');
  check('back on the map they are as they were', await box.isChecked());
}
