// frame_rate.mjs PAGE: how smoothly a page of runs moves in Chromium with software rendering at
// 1280×720: frames per second, and the processor time that all of the browser's processes take for a
// frame, which depends less on what else the machine does. A measurement, not a test.
import { readdirSync, readFileSync } from 'node:fs';
import { launch, open, drawn } from './browser.mjs';

/** Processor time of this process's descendants [ms]: Linux, at 100 ticks a second. */
function processorTime() {
  const parent = new Map(), ticks = new Map();
  for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    try {
      const stat = readFileSync(`/proc/${pid}/stat`, 'utf8');
      const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
      parent.set(pid, fields[1]);
      ticks.set(pid, Number(fields[11]) + Number(fields[12]));
    } catch { /* it has just ended */ }
  }
  const ours = (pid) => pid !== undefined && (pid === String(process.pid) || ours(parent.get(pid)));
  return 10 * [...ticks].filter(([pid]) => ours(parent.get(pid))).reduce((sum, [, t]) => sum + t, 0);
}

const browser = await launch();
const started = performance.now();
const { page, words } = await open(browser, process.argv[2], { viewport: { width: 1280, height: 720 } });
await drawn(page);
console.log(`opened and drawn in ${((performance.now() - started) / 1000).toFixed(1)} s`);

/** Measures over 3 s, with that key pressed in the scene before each frame. */
async function measure(what, key) {
  const before = processorTime();
  const [frames, seconds] = await page.evaluate(async (name) => {
    const scene = document.getElementById('scene'), from = performance.now();
    let count = 0;
    while (performance.now() - from < 3000) {
      if (name) scene.dispatchEvent(new KeyboardEvent('keydown', { key: name }));
      await new Promise((done) => requestAnimationFrame(done));
      count++;
    }
    return [count, (performance.now() - from) / 1000];
  }, key);
  console.log(`${what}: ${(frames / seconds).toFixed(0)} /s, ${
    ((processorTime() - before) / frames).toFixed(0)} ms of processor time a frame`);
}

await measure('turning', 'ArrowRight');
for (const view of ['orbit', 'follow', 'top']) {
  await page.selectOption('#map-view', view);
  await drawn(page);
  await page.selectOption('#speed', '0');
  await page.click('#play');
  await measure(`playing, ${view}`, '');
  if (await page.getAttribute('#play', 'aria-label') === 'Pause') await page.click('#play');
}
if (words.length) console.log(words.join('\n'));
await browser.close();
