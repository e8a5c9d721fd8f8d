import { mkdirSync } from 'node:fs';
import { DESKTOP, launch, open, PHONE, settle } from './browser.mjs';
const [out, ...files] = process.argv.slice(2); mkdirSync(out, { recursive: true });
const b = await launch();
for (const file of files) {
  const name = file.split('/').pop().replace('.html', '');
  for (const [kind, size, colorScheme] of [['desk-l', DESKTOP, 'light'], ['desk-d', DESKTOP, 'dark'], ['phone-d', PHONE, 'dark'], ['phone-l', PHONE, 'light']]) {
    const { page, words, context } = await open(b, file, { colorScheme, ...size, ...(kind.startsWith('phone') ? { deviceScaleFactor: 1 } : {}) });
    await settle(page);
    const h = await page.evaluate(() => document.documentElement.scrollHeight);
    for (let y = 0; y < h; y += 700) { await page.evaluate((t) => scrollTo(0, t), y); await page.waitForTimeout(60); }
    await page.evaluate(() => scrollTo(0, 0)); await page.waitForTimeout(500);
    await page.screenshot({ path: `${out}/${name}-${kind}.png`, fullPage: true });
    console.log(name, kind, h, words.join('|'));
    await context.close();
  }
}
await b.close();
