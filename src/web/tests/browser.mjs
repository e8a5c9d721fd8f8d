// Headless Chromium for the tests of the pages, and what every page must keep to.
import { spawnSync } from 'node:child_process';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

/** Debian's Chromium or another that is on the path, without the windows of a desktop where there is one:
 *  it starts in half the time; undefined where there is none. */
export function findBrowser() {
  for (const name of ['chromium-headless-shell', 'chromium', 'chromium-browser', 'google-chrome']) {
    const { stdout, status } = spawnSync('which', [name], { encoding: 'utf8' });
    if (status === 0) return stdout.trim();
  }
  return undefined;
}

// Software rendering, the same on every machine; WebGL is SwiftShader's.
const ARGUMENTS = ['--no-sandbox', '--disable-quic', '--disable-gpu', '--enable-unsafe-swiftshader',
  '--hide-scrollbars'];

export const launch = (extra = []) =>
  chromium.launch({ executablePath: findBrowser(), headless: true, args: [...ARGUMENTS, ...extra] });

export const DESKTOP = { viewport: { width: 1280, height: 800 } };
export const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true,
  hasTouch: true };

/** For pages under test: `pixelsOf` a canvas, one number each. */
function pixelsInPage() {
  window.pixelsOf = (canvas) => {
    const { width, height } = canvas;
    if (!width || !height) return new Uint32Array();
    const pen = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    pen.drawImage(canvas, 0, 0);
    return new Uint32Array(pen.getImageData(0, 0, width, height).data.buffer);
  };
}

/** Opens the file or URL; `words` fills with what the console says and the requests that leave the page. */
export async function open(browser, file, options = {}) {
  const context = await browser.newContext({ acceptDownloads: true, ...DESKTOP, ...options });
  await context.addInitScript(pixelsInPage);
  const page = await context.newPage();
  const words = [];
  page.on('console', (message) => {
    // What Chromium says of a test that reads the picture of a scene.
    if (message.text().includes('GPU stall due to ReadPixels')) return;
    words.push(`${message.type()}: ${message.text()}`);
  });
  page.on('pageerror', (error) => words.push(`error: ${error.stack ?? error}`));
  page.on('request', (request) => {
    if (!/^(data|blob):/.test(request.url()) && request.url() !== page.url() &&
      !request.isNavigationRequest()) words.push(`request: ${request.url()}`);
  });
  // A machine with other work has been seen to take half a minute.
  await page.goto(/^http:/.test(file) ? file : pathToFileURL(file).href, { timeout: 120_000 });
  return { page, words, context };
}

/** Two frames of the screen pass. */
export const frames = (page) => page.evaluate(() => new Promise((done) => {
  requestAnimationFrame(() => requestAnimationFrame(done));
}));

/** Three frames of the screen: what came near in the first is drawn in the second, and shown. */
export const drawn = (page) => page.evaluate(() => new Promise((done) => {
  const wait = (left) => (left ? requestAnimationFrame(() => wait(left - 1)) : setTimeout(done));
  wait(3);
}));
