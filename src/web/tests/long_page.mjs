// long_page.mjs PAGE FOLDER: a page of a run of 100,000 states and 20,000 landmarks in Chromium. What is
// drawn of it in motion is bounded: a measurement of how smooth that is is frame_rate.mjs. Exit 1:
// something failed; 77: no Chromium.
import { mkdirSync } from 'node:fs';
import { findBrowser, launch, open, drawn } from './browser.mjs';
import { check, until, verdict } from './checks.mjs';
import { motion } from './run_world.mjs';

const [file, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });
const browser = await launch();
const { page, words } = await open(browser, file, { viewport: { width: 1280, height: 720 } });
await drawn(page);
const detail = () => page.getAttribute('#scene', 'data-detail');
const dots = async () => Number(/^coarse: (\d+) of 20000 dots$/.exec(await detail())?.[1]);

const most = await motion(page);
check('a third of the dots is enough for all of the run', most < 20000 / 3, String(most));
for (const view of ['orbit', 'follow']) {
  await page.selectOption('#map-view', view);
  await page.selectOption('#speed', '0');
  await page.click('#play');
  await until(`${view}: it plays coarsely`, async () => await dots() > 0, 10);
  check(`${view}: with few dots`, await dots() < 20000 / 3, await detail());
  await page.evaluate(() => {
    const button = document.getElementById('play');
    if (button.getAttribute('aria-label') === 'Pause') button.click();
  });
  await until(`${view}: once it stops it is drawn in full`, async () => await detail() === 'full', 10);
  await page.screenshot({ path: `${folder}/${view}.png` });
}
check('the console is silent and nothing is loaded', words.length === 0, words.join(' | '));
await browser.close();
process.exit(verdict());
