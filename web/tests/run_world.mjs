// The scene and the map of a page of runs, used as a person does.
import { settle } from './browser.mjs';
import { check, picture, saved, until } from './checks.mjs';

/** The scene is drawn by WebGL, which keeps no picture: a screenshot of it. */
const sceneShot = async (page) => (await page.locator('#scene').screenshot()).toString('base64');

export async function scene(page, { run, folder }) {
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
  const { bytes } = await saved(page, folder, () => page.click('#map-png'));
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

export async function mapMoves(page) {
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
export async function landmarkLives(page) {
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
