// The plots over time, the cursor and the figures of a page of runs, used as a person does.
import { drawn } from './browser.mjs';
import { check, picture, saved, until } from './checks.mjs';

const cursor = (page) => page.inputValue('#time').then(Number);
const plot = (page, k = 0) => page.locator('.plot .u-over').nth(k);

export async function timeCursor(page) {
  await plot(page).scrollIntoViewIfNeeded();
  const box = await plot(page).boundingBox();
  const last = Number(await page.getAttribute('#time', 'max'));
  let nudge = 0;
  await until('a plot moves the cursor', async () => {
    await page.mouse.move(box.x + 0.4 * box.width + (nudge++ % 2), box.y + 30);
    return Math.abs(await cursor(page) - 0.4 * last) < 4;
  });
  const lines = page.locator('.plot-host .time-cursor');
  const shown = (line) => line.evaluate((e) => e.offsetParent && Math.abs(parseFloat(e.style.left) - 40) < 1);
  check('there are several plots', await lines.count() > 3);
  for (const line of await lines.all()) {
    await line.evaluate((e) => e.closest('.plot-host').scrollIntoView({ block: 'center' }));
    await until('all plots show the cursor at one time', () => shown(line));
  }
  await plot(page).scrollIntoViewIfNeeded();
  const before = await cursor(page);
  await page.locator('.plot-stack').first().press('ArrowLeft');
  await drawn(page);
  check('the left arrow goes back a frame', await cursor(page) === before - 1);
  await page.locator('#time').focus();
  await page.locator('#time').press('Home');
  await until('the slider scrubs', async () => await cursor(page) === 0);
  await until('the time is shown', async () => await page.textContent('#time-text') === '0.00 s');
}

export async function play(page) {
  await page.selectOption('#speed', '20');
  await page.click('#play');
  await until('play moves the cursor', async () => await cursor(page) > 5);
  // In one go: the run may end at any time, and the button then starts it again.
  await page.evaluate(() => {
    const button = document.getElementById('play');
    if (button.getAttribute('aria-label') === 'Pause') button.click();
  });
  await drawn(page);
  const stopped = await cursor(page);
  await drawn(page);
  check('pause stops it', await cursor(page) === stopped);
}

export async function timeSpan(page) {
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

/** What else was estimated: by what unit, in whose axes. */
const KNOWN = {
  velocity: ['Velocity', 'm/s', 'the world'],
  linear_velocity: ['Linear velocity', 'm/s', 'the IMU'],
  gyro_bias: ['Gyro bias', 'rad/s', 'the IMU'],
  gyroscope_bias: ['Gyroscope bias', 'rad/s', 'the IMU'],
};

/** Velocities and biases have their units, and say whose axes theirs are. */
export async function axes(page, { run }) {
  for (const [family, [title, unit, whose]] of Object.entries(KNOWN)) {
    if (!run.extra_names.includes(`${family}_x`)) continue;
    const figure = page.locator('figure.plot', { has: page.getByText(title, { exact: true }) });
    check(`${family}: a plot of its own`, await figure.count() === 1);
    check(`${family}: whose axes`,
      (await figure.locator('figcaption').textContent()).includes(`in the axes of ${whose}`));
    const labels = await figure.locator('.plot-label > span:first-child').allTextContents();
    check(`${family}: its axes and unit`, labels.join() === ['x', 'y', 'z'].map((a) => `${a} [${unit}]`).join(),
      labels.join());
  }
}

/** What is written at the ticks of a time axis is where they are. */
export async function timeTicks(page) {
  const stack = page.locator('.plot-stack').first();
  await stack.scrollIntoViewIfNeeded();
  await page.evaluate(() => {
    const { prototype } = CanvasRenderingContext2D, { fillText } = prototype;
    window.written = [];
    prototype.fillText = function write(text, x, y) {
      if (this.canvas.closest('.plot-stack')) window.written.push([y, x, text]);
      fillText.call(this, text, x, y);
    };
    window.stopWriting = () => { prototype.fillText = fillText; };
  });
  for (const key of ['+', '+', '+', '0']) {
    await page.evaluate(() => { window.written.length = 0; });
    await stack.press(key);
    await drawn(page);
    const written = await page.evaluate(() => window.written);
    const last = written.find(([, , text]) => / s$/.test(text));
    const ticks = written.filter(([y, x]) => last && y === last[0] && x >= 54)  // right of the other axis
     
      .map(([, x, text]) => [x, Number(text.replace(/ s$/, '').replace(/\u202f/g, ''))]).slice(0, 40);
    const [[x0, t0], [x1, t1]] = [ticks[0], ticks.reduce((a, b) => (b[1] > a[1] ? b : a))];
    check(`${key}: the time axis shows true times`, ticks.length > 1 && ticks.every(([x, t]) =>
      Math.abs(x0 + (t - t0) * (x1 - x0) / (t1 - t0) - x) < 2), JSON.stringify(ticks));
  }
  await page.evaluate(() => window.stopWriting());
}

export async function toggles(page) {
  const figure = page.locator('figure.plot', { has: page.locator('.toggle') }).first();
  const canvas = figure.locator('canvas').first(), box = figure.locator('.toggle input').last();
  await figure.scrollIntoViewIfNeeded();
  await page.mouse.move(2, 2);
  await drawn(page);
  const before = await picture(canvas);
  await box.click();
  await until('a legend hides a series', async () => await picture(canvas) !== before);
  await box.click();
  await until('a legend shows the series again', async () => await picture(canvas) === before);
}

export async function exports(page, { folder }) {
  const figure = page.locator('figure.plot').first();
  const files = {};
  for (const kind of ['PNG', 'SVG', 'CSV']) {
    files[kind] = await saved(page, folder, () => figure.getByRole('button', { name: kind }).click());
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

export async function exactNumbers(page, { run }) {
  const { nees_pose: value } = run.summary;
  if (typeof value !== 'number') return;
  const card = page.locator('.card-value[data-exact^="nees_pose:"]');
  await card.scrollIntoViewIfNeeded();
  await drawn(page);
  await card.hover();
  await until('a figure shows the number of summary.json under the pointer', async () =>
    await page.textContent('.exact-tip') === `nees_pose: ${value}` && page.isVisible('.exact-tip'));
  await page.mouse.move(2, 2);
}

/** What a frame took, by stages. */
export async function stages(page, { run, folder }) {
  const figure = page.locator('figure.plot', { hasText: run.stages.length ? 'Time per stage' :
    'Time per frame' });
  await figure.scrollIntoViewIfNeeded();
  check('there is a plot of times', await figure.count() === 1);
  for (const name of run.stage_names) {
    check(`${name}: is in the legend`,
      await figure.locator('.legend', { hasText: name.replace('_', ' ') }).count() === 1);
  }
  if (run.stages.length) {
    const { bytes } = await saved(page, folder, () => figure.getByRole('button', { name: 'CSV' }).click());
    const head = bytes.toString().split('\n')[0];
    check('the csv has a column a stage', head.split(',').length ===
      run.stages.length + 2 && head.includes('front end'), head);
  }
}
