// _cols.mjs IN.png OUT_PREFIX COLS HEIGHT : slices a tall picture into columns
import { readFileSync, writeFileSync } from 'node:fs';
import { launch } from './browser.mjs';
const b = await launch(); const page = await (await b.newContext()).newPage();
const [cols, height, ...files] = process.argv.slice(2);
for (const f of files) {
  const urls = await page.evaluate(async ([u, cols, height]) => {
    const i = new Image(); i.src = u; await i.decode(); const out = [];
    for (let y = 0; y < i.height;) {
      const k = document.createElement('canvas'); k.width = cols * (i.width + 12); k.height = height; const g = k.getContext('2d'); g.fillStyle = '#f0f'; g.fillRect(0, 0, k.width, k.height);
      for (let c = 0; c < cols && y < i.height; c++, y += height) g.drawImage(i, 0, y, i.width, height, c * (i.width + 12), 0, i.width, height);
      out.push(k.toDataURL());
    } return out; }, ['data:image/png;base64,' + readFileSync(f).toString('base64'), +cols, +height]);
  urls.forEach((u, k) => writeFileSync(f.replace('.png', `_${k}.png`), Buffer.from(u.split(',')[1], 'base64')));
}
await b.close();
