// study_page.mjs PAGE FOLDER: as run_page.mjs, with a page of studies.
import { mkdirSync, readFileSync } from 'node:fs';
import { check, picture, until, verdict, visit } from './checks.mjs';
import { DESKTOP, findBrowser, launch, PHONE, drawn } from './browser.mjs';

const [file, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const { studies } = JSON.parse(
  /id="report-data">([^]*?)<\/script/.exec(readFileSync(file, 'utf8'))[1]);
const titleOf = (study) => study.summary.name || study.folder;

/** What the paper calls its scenes, and how it shows them. */
const PLACES = {
  hallway: { table: 'Table I: hallway', figure: 'Figure 2: hallway', view: 'top', map: '(a) Top view' },
  turntable: { table: 'Table II: cube', figure: 'Figure 3: cube', view: 'slanted', map: '(a) Slanted view' },
};
const ELSEWHERE = { table: 'NEES and errors', figure: 'Errors and NEES over time', view: 'top',
  map: 'Top view' };

async function isAsInThePaper(page, study) {
  const place = PLACES[study.summary.scene?.geometry] ?? ELSEWHERE;
  for (const [id, text] of [['results-title', place.table], ['figure-title', place.figure],
    ...(study.truth ? [['map-title', place.map]] : [])]) {
    const title = await page.textContent(`#${id}`);
    check(`#${id} is that of the scene`, title.split(',')[0] === text, title);
  }
  if (!study.truth) return;
  check('the map opens with the view of the scene', await page.inputValue('#map-view') === place.view);
  check('estimated landmarks can be switched where there are any',
    await page.locator('#map-legend', { hasText: 'Estimated landmarks' }).count() ===
    Number(study.filters.some((filter) => filter.landmarks)));
}

async function isDrawnRight(page, study) {
  await isAsInThePaper(page, study);
  for (const table of ['results-table', 'more-table']) {
    check(`${table} has a row a filter`,
      await page.locator(`#${table} tbody tr`).count() === study.filters.length);
  }
  check('the map is there with the truth',
    await page.isVisible('#map') === Boolean(study.truth));
  const several = !study.single_run;
  check('distributions are there with several runs', await page.isVisible('#boxes') === several);
  if (!several) return;
  check('the outlier is listed',
    (await page.locator('#outliers td').allTextContents()).includes('3'));
  const commands = page.locator('#outliers details');
  await commands.first().locator('summary').click();
  const code = commands.first().locator('code');
  check('the command of an outlier is shown', await code.isVisible());
  check('and takes a part of the screen, however long it is', (await code.boundingBox()).height < 200);
  await code.click();
  check('a click takes all of it', await page.evaluate(() => String(getSelection()).trim()) ===
    (await code.textContent()).trim());
  const texts = await commands.locator('code').allTextContents();
  check('and names its run', texts.some((text) => /^chasles compare .* --run 3 /.test(text)), texts[0]);
}

async function timeCursor(page) {
  const plot = page.locator('#plots .u-over').first(), readout = page.locator('#plots .readout').first();
  await plot.scrollIntoViewIfNeeded();
  const box = await plot.boundingBox(), before = await readout.textContent();
  let nudge = 0;
  await until('a plot moves the cursor', async () => {
    await page.mouse.move(box.x + 0.4 * box.width + (nudge++ % 2), box.y + 40);
    return await readout.textContent() !== before;
  });
  await page.mouse.move(box.x + 60, box.y + 40);
  await page.mouse.down();
  await page.mouse.move(box.x + 160, box.y + 40, { steps: 4 });
  await page.mouse.up();
  await until('dragging zooms in time', () => page.isVisible('#zoom-reset'));
  await page.click('#zoom-reset');
  await until('all times again', async () => !await page.isVisible('#zoom-reset'));
}

async function choices(page) {
  await page.evaluate(() => scrollTo(0, 0));
  const canvases = await page.locator('#map:visible, #boxes canvas').all();
  const before = await Promise.all(canvases.map(picture));
  await page.locator('#filters-legend input').first().click();
  for (const [k, canvas] of canvases.entries()) {
    await until(`a filter is taken out of figure ${k}`,
      async () => await picture(canvas) !== before[k]);
  }
  await page.click('#no-filters');
  await page.click('#all-filters');
  await until('and comes back', async () => await picture(canvases[0]) === before[0]);
  const theme = await page.getAttribute('html', 'data-theme');
  await page.click('#theme-button');
  check('the theme changes', await page.getAttribute('html', 'data-theme') !== theme);
  await until('and the figures with it', async () => await picture(canvases[0]) !== before[0]);
  await page.click('#theme-button');
}

async function mapMoves(page) {
  const map = page.locator('#map');
  await map.scrollIntoViewIfNeeded();
  await drawn(page);
  const before = await picture(map);
  await page.click('#map-in');
  await until('zooming changes the map', async () => await picture(map) !== before);
  await page.click('#map-fit');
  await until('and shows everything again', async () => await picture(map) === before);
  const opened = await page.inputValue('#map-view'), seen = new Set([before]);
  for (const view of ['top', 'side', 'front', 'slanted'].filter((name) => name !== opened)) {
    await page.selectOption('#map-view', view);
    await until(`the ${view} view is another`, async () => !seen.has(await picture(map)));
    seen.add(await picture(map));
    check('the title names the view', (await page.textContent('#map-title')).toLowerCase()
      .includes(`${view} view`));
  }
  await page.selectOption('#map-view', opened);
  await until('the first view comes back', async () => await picture(map) === before);
  const layers = await page.locator('#map-legend input').all();
  for (const [k, layer] of layers.entries()) {
    await layer.uncheck();
    await until(`layer ${k} of the map can be hidden`, async () => await picture(map) !== before);
    await layer.check();
    await until('and shown again', async () => await picture(map) === before);
  }
}

async function dots(page) {
  const text = await page.locator('#boxes canvas').first().evaluate((canvas) => {
    const readout = canvas.parentElement.querySelector('.readout');
    const frame = canvas.getBoundingClientRect();
    for (let y = 8; y < frame.height && !readout.textContent; y += 4) {
      for (let x = 4; x < frame.width && !readout.textContent; x += 8) {
        canvas.dispatchEvent(new PointerEvent('pointermove',
          { clientX: frame.left + x, clientY: frame.top + y }));
      }
    }
    return readout.textContent;
  });
  check('a dot shows its run', /run \d+/.test(text), text);
}

async function use(page) {
  const [study] = studies;
  await isDrawnRight(page, study);
  if (study.summary.scene) {
    await timeCursor(page);
    await choices(page);
  }
  if (study.truth) await mapMoves(page);
  if (!study.single_run) await dots(page);
  if (studies.length < 2) return;
  await page.selectOption('#run-select', '1');
  await until('another study is shown', async () =>
    await page.textContent('#run-name') === titleOf(studies[1]));
  await isDrawnRight(page, studies[1]);
}

const browser = await launch();
const title = titleOf(studies[0]);
await visit(browser, file, folder, { label: 'desktop', title, colorScheme: 'light', ...DESKTOP,
  use: (page) => use(page).catch((error) => check('use', false, String(error))) });
await visit(browser, file, folder, { label: 'phone', title, colorScheme: 'dark', ...PHONE });
await browser.close();
process.exit(verdict());
