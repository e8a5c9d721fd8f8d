// live_page.mjs CHASLES RECORDING FOLDER: runs CHASLES over a recording with an IMU and looks on in
// Chromium, as a desktop and as a phone would; kills it, serves a finished run in its place, stops a
// run. Pictures and run folders stay in FOLDER. Exit 1: something failed; 77: no Chromium.
import { spawn } from 'node:child_process';
import { mkdirSync, readFileSync } from 'node:fs';
import { check, until, verdict, visit } from './checks.mjs';
import { DESKTOP, findBrowser, launch, open, PHONE, drawn } from './browser.mjs';

const [chasles, recording, folder] = process.argv.slice(2);
if (!findBrowser()) process.exit(77);
mkdirSync(folder, { recursive: true });

/** Starts the command; `url` is what it prints, `ended` its exit code or signal. */
async function start(...words) {
  const child = spawn(chasles, words, { stdio: ['ignore', 'pipe', 'pipe'] });
  let text = '';
  for (const stream of [child.stdout, child.stderr]) stream.on('data', (data) => { text += data; });
  const ended = new Promise((done) => { child.on('exit', (code, signal) => done(signal ?? code)); });
  const url = await new Promise((done) => {
    const timer = setInterval(() => {
      const found = /http:\/\/\S+/.exec(text);
      if (found || child.exitCode !== null) { clearInterval(timer); done(found?.[0]); }
    }, 20);
  });
  check(`${words[0]} prints a URL`, url !== undefined, text);
  return { child, url, ended };
}

const startRun = (name, port = 0) => start('run', recording, '-o', `${folder}/${name}`, '--quiet',
  '--realtime-speed', '0.25', '--live', String(port));
const state = (page) => page.textContent('#live-state');
const shownFrames = async (page) =>
  Number(/([\d\u202f]+) frames/.exec(await page.textContent('#run-line'))?.[1].replace('\u202f', '') ?? 0);

/** The run is there, and grows. */
async function running(page) {
  await until('the run arrives', async () => await page.isVisible('#main') && await shownFrames(page) > 20, 20);
  check('the state is running', await state(page) === 'Running', await state(page));
}

async function grows(page) {
  const frames = await shownFrames(page), numbers = await page.textContent('#live-numbers');
  check('progress and speed are shown', /\d of [\d\u202f]+ frames · .* × real time/.test(numbers.replace(/\s+/g, ' ')),
    numbers);
  await until('frames arrive', async () => await shownFrames(page) > frames + 5, 10);
  const last = Number(await page.getAttribute('#time', 'max'));
  const announced = () => page.locator('#figures [data-exact^="frames:"]').getAttribute('data-exact');
  check('the table of figures goes with the run', Number((await announced()).split(' ')[1]) >= frames, await announced());
  check('the cursor goes with the run', Number(await page.inputValue('#time')) >= last - 2);
  await page.locator('#time').focus();
  await page.locator('#time').press('Home');
  const there = await shownFrames(page);
  await until('and more arrive', async () => await shownFrames(page) > there + 5, 10);
  check('a cursor that was moved stays', await page.inputValue('#time') === '0');
  await page.locator('#time').press('End');
  await until('landmarks are in view', async () => /, [1-9]\d* of them in view/.test(
    await page.getAttribute('#scene', 'aria-label')), 10);
  const box = page.locator('figure.plot .toggle input').first();
  await box.click();
  const before = await shownFrames(page);
  await until('still they arrive', async () => await shownFrames(page) > before + 5, 10);
  check('a legend stays as it was set', !await box.isChecked());
  await box.click();
  await page.selectOption('#map-view', 'top');
  await drawn(page);
  await page.screenshot({ path: `${folder}/map.png` });
  await page.selectOption('#map-view', 'follow');
  await drawn(page);
}

/** What Chromium says by itself of a server that is gone. */
const notOfTheServer = (words) => words.filter((word) => !/WebSocket connection to .* failed/.test(word));

const browser = await launch();

// A run that goes on, seen by two at once.
const first = await startRun('killed');
const title = recording.split('/').pop();
await visit(browser, first.url, folder, { label: 'live-desktop', title, colorScheme: 'light', ...DESKTOP,
  ready: running, use: grows });
const phone = await open(browser, first.url, { colorScheme: 'dark', ...PHONE });
await running(phone.page);
await drawn(phone.page);
await phone.page.screenshot({ path: `${folder}/live-phone.png` });
check('on a phone nothing sticks out to the side', await phone.page.evaluate(() =>
  document.documentElement.scrollWidth <= document.documentElement.clientWidth));
await phone.context.close();

// It is killed; a finished run is served in its place; that server ends.
const { page, words, context } = await open(browser, first.url);
await running(page);
first.child.kill('SIGKILL');
await until('a lost connection is reported', async () => /Connection lost, trying again/.test(await state(page)));
await page.screenshot({ path: `${folder}/live-lost.png` });
check('what was there is still there', await shownFrames(page) > 20 && await page.isVisible('#plots'));
const { port } = new URL(first.url);

const stopped = await startRun('stopped', port);
check('the port is the one asked for', new URL(stopped.url).port === port);
await until('it connects again, and the run is another', async () => await state(page) === 'Running', 30);
await page.click('#live-stop');
check('the stop button asks first', await page.textContent('#live-stop') === 'Really stop?');
await page.click('#live-stop');
check('a stopped run ends as an interrupted one', await stopped.ended === 130);
await until('and the state is stopped', async () => (await state(page)).startsWith('Stopped before its end'), 10);
const summary = JSON.parse(readFileSync(`${folder}/stopped/summary.json`, 'utf8'));
check('its folder is complete', summary.remarks.some((r) => r.startsWith('interrupted after ')));
check('the page has all frames', await shownFrames(page) === summary.frames,
  `${await shownFrames(page)} of ${summary.frames}`);
await until('the server has ended with it', async () => /server has ended/.test(await state(page)));
await drawn(page);
await page.screenshot({ path: `${folder}/live-stopped.png` });
check('the console is silent', notOfTheServer(words).length === 0, words.join(' | '));
await context.close();

const served = await start('view', `${folder}/stopped`, '--port', port);
await visit(browser, served.url, folder, { label: 'view', title, colorScheme: 'dark', ...PHONE,
  ready: (viewed) => until('a finished run is served', () => viewed.isVisible('#main'), 10),
  use: async (viewed) => {
    check('the state is finished', await state(viewed) === 'Finished', await state(viewed));
    check('there is nothing to stop', !await viewed.isVisible('#live-stop'));
    served.child.kill('SIGINT');
    check('Ctrl-C ends the server', await served.ended === 0);
    await until('the end of the server is reported', async () => /server has ended/.test(await state(viewed)));
  } });
await browser.close();
process.exit(verdict());
