// The panel of what the cameras saw, used as a person does.
import { drawn } from './browser.mjs';
import { check, coloursOf, picture, until } from './checks.mjs';

const cursor = (page) => page.inputValue('#time').then(Number);

/** What the cameras saw, where the run has kept it. */
export async function camera(page, { run }) {
  const images = run.images ?? [];
  check('the camera panel is shown where images were kept',
    await page.isVisible('#camera-panel') === images.length > 0);
  if (!images.length) return;
  const view = page.locator('#camera'), text = () => page.textContent('#camera-text');
  await view.scrollIntoViewIfNeeded();
  await page.locator('#time').focus();
  await page.locator('#time').press('Home');
  await until('the picture is that of the cursor', async () => (await text()).startsWith('0.00 s'));
  check('the picture has a description', (await view.getAttribute('aria-label')).startsWith('cam0: 0.00 s') &&
    /\d+ used · \d+ rejected/.test(await text()), await text());
  const first = await picture(view), [colours] = await coloursOf(view);
  check('the picture is a photograph and not an empty ground', colours > 60, String(colours));
  await view.focus();
  await view.press('ArrowRight');
  await until('the right arrow goes to the next kept frame', async () =>
    !(await text()).startsWith('0.00 s') && await picture(view) !== first);
  check('the cursor goes with it', await cursor(page) > 0);
  await view.press('Home');
  await until('Home goes back', async () => await picture(view) === first);
  // The first frame has no way behind it.
  await view.press('ArrowRight');
  await until('the next frame is another', async () => await picture(view) !== first);
  await drawn(page);
  const next = await picture(view);
  for (const box of await page.locator('#camera-legend input').all()) {
    await box.click();
    await until('the legend hides a kind of mark', async () => await picture(view) !== next);
    await box.click();
    await until('the legend of the camera shows them again', async () => await picture(view) === next);
  }
  await page.selectOption('#camera-enlarged', '1');
  await until('ellipses can be drawn to scale', async () => await picture(view) !== next);
  await page.selectOption('#camera-enlarged', '10');
  await until('and larger', async () => await picture(view) === next);
  await pointTip(page, view);
  check('a choice of cameras is there with several',
    await page.isVisible('#camera-field') === images.length > 1);
  if (images.length < 2) return;
  await page.selectOption('#camera-select', { index: 1 });
  await until('another camera is shown', async () => await picture(view) !== next &&
    (await view.getAttribute('aria-label')).startsWith('cam1'));
  await page.selectOption('#camera-select', { index: 0 });
  await until('and the first again', async () => await picture(view) === next);
}

/** Goes over the picture until a point answers. */
async function pointTip(page, view) {
  await view.evaluate((canvas) => {
    const frame = canvas.getBoundingClientRect(), tip = document.getElementById('camera-tip');
    for (let y = 4; y < frame.height && tip.hidden; y += 6) {
      for (let x = 4; x < frame.width && tip.hidden; x += 6) {
        canvas.dispatchEvent(new PointerEvent('pointermove', { pointerType: 'mouse', pointerId: 1,
          clientX: frame.left + x, clientY: frame.top + y }));
      }
    }
  });
  const text = await page.textContent('#camera-tip');
  check('a point shows its numbers', /Point \d+: .*seen \d+ times/.test(text), text);
  await view.dispatchEvent('pointerleave');
}
