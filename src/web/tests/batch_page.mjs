// batch_page.mjs PAGE FOLDER: as run_page.mjs, with the page of a batch.
import { mkdirSync, readFileSync } from 'node:fs';
import { check, until, verdict, visit } from './checks.mjs';
import { DESKTOP, PHONE, findBrowser, launch } from './browser.mjs';

const [file, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const { recordings } = JSON.parse(/id="report-data">([^]*?)<\/script/.exec(readFileSync(file, 'utf8'))[1]);
const count = (verdicts) => recordings.filter((r) => verdicts.includes(r.verdict)).length;

async function use(page) {
  const rows = page.locator('table.batch tbody tr');
  const names = () => rows.locator('th').allTextContents();
  check('there is a row a recording', await rows.count() === recordings.length);
  const badges = await rows.locator('td:first-child').allTextContents();
  check('the worst come first', badges.join() === [...badges].sort((a, b) =>
    ['no', 'check', 'use'].indexOf(a) - ['no', 'check', 'use'].indexOf(b)).join(), badges.join());
  check('reasons are shown as text', (await rows.first().textContent()).includes('<img src=x'));
  check('a path is drawn', await rows.locator('svg.sketch polyline').count() === count(['use', 'check']));
  check('an image is shown', await page.locator('img.thumbnail').first().evaluate((image) =>
    image.complete && image.naturalWidth > 0));

  await page.locator('#verdicts input').first().uncheck();
  await until('a verdict can be left out', async () => await rows.count() === count(['use', 'check']));
  await page.locator('#verdicts input').first().check();
  await page.selectOption('#reason', 'uncertain');
  await until('the recordings of a reason can be chosen', async () =>
    await rows.count() === recordings.filter((r) => r.reasons.some((one) => one.reason === 'uncertain')).length);
  await page.selectOption('#reason', '');
  await page.fill('#search', 'WALK-1');
  await until('names are searched', async () =>
    await rows.count() === recordings.filter((r) => r.name.includes('walk-1')).length);
  await page.fill('#search', '');

  await page.locator('button.sort', { hasText: 'Recording' }).click();
  await until('a heading sorts', async () => {
    const now = await names();
    return now.join() === [...now].sort((a, b) => a.localeCompare(b)).join();
  });
  const rising = await names();
  await page.locator('button.sort', { hasText: 'Recording' }).click();
  await until('and turns the order', async () => (await names()).join() === rising.reverse().join());
  check('what changed is shown', (await page.textContent('#difference')).includes('1 worse, 1 better'));
}

const browser = await launch();
await visit(browser, file, folder, { label: 'desktop', title: 'Batch', plots: 0, ...DESKTOP, use });
await visit(browser, file, folder, { label: 'phone', title: 'Batch', plots: 0, colorScheme: 'dark', ...PHONE });
await browser.close();
process.exit(verdict());
