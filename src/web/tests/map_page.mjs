// map_page.mjs PAGE FOLDER: as run_page.mjs, with the page of a saved map.
import { mkdirSync, readFileSync } from 'node:fs';
import { check, picture, saved, screenshot, until, verdict, visit } from './checks.mjs';
import { DESKTOP, findBrowser, launch, drawn } from './browser.mjs';

const [file, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const { runs: [{ name, map }] } = JSON.parse(
  /id="report-data">([^]*?)<\/script/.exec(readFileSync(file, 'utf8'))[1]);

async function use(page) {
  check('there is a row a session', await page.locator('#sessions tbody tr').count() ===
    map.sessions.length);
  const row = await page.locator('#sessions tbody tr').last().textContent();
  check('which shows when it began', row.includes('2011-09-30 12:08:26 UTC'), row);
  check('there are the distributions', await page.locator('#histograms figure').count() === 4);
  const total = await page.locator('#histograms figure').nth(3).locator('.bar').evaluateAll((bars) =>
    bars.reduce((sum, bar) => sum + Number(/: (\d+)$/.exec(bar.title)[1]), 0));
  check('whose bars hold all landmarks', total === 400, String(total));

  const canvas = page.locator('#map'), all = await picture(canvas);
  const boxes = page.locator('#map-legend input');
  check('there is a layer a session', await boxes.count() === map.sessions.length);
  await boxes.first().uncheck();
  await until('the legend hides a session', async () => await picture(canvas) !== all);
  await boxes.first().check();
  await until('and shows it again', async () => await picture(canvas) === all);
  const box = await canvas.boundingBox();
  for (let y = 20; y < box.height && await page.isHidden('#map-tip'); y += 12) {
    for (let x = 10; x < box.width && await page.isHidden('#map-tip'); x += 12) {
      await canvas.evaluate((map, at) => map.dispatchEvent(new PointerEvent('pointermove',
        { clientX: map.getBoundingClientRect().left + at.x,
          clientY: map.getBoundingClientRect().top + at.y })), { x, y });
    }
  }
  const tip = await page.textContent('#map-tip');
  check('a landmark shows its numbers', /Landmark \d+ of the map(Mon|Tues)day.* shared/.test(tip), tip);
  const { bytes } = await saved(page, folder, () => page.click('#map-csv'));
  check('the landmarks are saved as a table', String(bytes).trim().split('\n').length === 401);

  await page.selectOption('#map-view', 'orbit');
  await drawn(page);
  const shot = () => screenshot(page, '#scene');
  const first = await shot();
  await boxes.first().uncheck();
  await until('the scene hides a session too', async () => await shot() !== first);
  await boxes.first().check();
  await page.screenshot({ path: `${folder}/scene.png` });
}

const browser = await launch();
await visit(browser, file, folder, { label: 'desktop', title: name, plots: 1, colorScheme: 'dark',
  ...DESKTOP, use });
await browser.close();
process.exit(verdict());
