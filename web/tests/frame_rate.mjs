// frame_rate.mjs PAGE: frames per second of a page of runs in Chromium with software rendering at
// 1280×720, while the scene turns and while the run plays. A measurement, not a test: it depends on
// what else the machine does.
import { launch, open, settle } from './browser.mjs';

const browser = await launch();
const started = performance.now();
const { page, words } = await open(browser, process.argv[2], { viewport: { width: 1280, height: 720 } });
await settle(page);
console.log(`opened and drawn in ${((performance.now() - started) / 1000).toFixed(1)} s`);

/** Frames per second over 5 s, with that key pressed in the scene before each. */
const rate = (key) => page.evaluate(async (name) => {
  const scene = document.getElementById('scene'), from = performance.now();
  let frames = 0;
  while (performance.now() - from < 3000) {
    if (name) scene.dispatchEvent(new KeyboardEvent('keydown', { key: name }));
    await new Promise((done) => requestAnimationFrame(done));
    frames++;
  }
  return (frames / (performance.now() - from) * 1000).toFixed(0);
}, key);

for (const view of ['orbit', 'follow']) {
  await page.selectOption('#map-view', view);
  await settle(page);
  if (view === 'orbit') console.log(`turning: ${await rate('ArrowRight')} /s`);
  await page.selectOption('#speed', '0');
  await page.click('#play');
  console.log(`playing, ${view}: ${await rate('')} /s`);
  if (await page.getAttribute('#play', 'aria-label') === 'Pause') await page.click('#play');
}
if (words.length) console.log(words.join('\n'));
await browser.close();
