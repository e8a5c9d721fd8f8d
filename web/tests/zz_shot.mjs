import { launch, open, settle, DESKTOP, PHONE } from './browser.mjs';
const [file, out] = process.argv.slice(2);
const b = await launch();
for (const [label, o] of [['desktop', { colorScheme: 'light', viewport: { width: 1280, height: 900 } }], ['phone', { colorScheme: 'dark', ...PHONE }]]) {
  const { page, words, context } = await open(b, file, o);
  await settle(page);
  await page.evaluate(() => { const t = document.getElementById('time'); t.value = Math.round(t.max * 0.55); t.dispatchEvent(new Event('input')); });
  await new Promise((r) => setTimeout(r, 1500));
  await page.locator(label === 'phone' ? '#camera-panel' : '#map-layout').scrollIntoViewIfNeeded().catch(() => {});
  if (label === 'phone') await page.evaluate(() => document.getElementById('camera-panel').scrollIntoView());
  else await page.evaluate(() => document.getElementById('map-layout').scrollIntoView());
  await settle(page);
  await page.screenshot({ path: `${out}_${label}.png` });
  console.log(label, words);
  await context.close();
}
await b.close();
