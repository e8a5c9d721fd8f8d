// What a page of runs shows before anybody touches it, and what its key figures mean.
import { check, until } from './checks.mjs';
import { numbers } from './run_world.mjs';

/** The page opens at the last moving row that used observations, not at a standstill behind it. */
export async function opening(page, { run }) {
  const { used, x, y, z } = Object.fromEntries(
    ['used', 'x', 'y', 'z'].map((name) => [name, numbers(run.states[name])]));
  const moves = (i) => i > 0 && Math.hypot(x[i] - x[i - 1], y[i] - y[i - 1], z[i] - z[i - 1]) > 1e-6;
  const row = Number(await page.inputValue('#time'));
  const last = used.findLastIndex((count, i) => count > 0 && moves(i));
  check('the page opens where observations are used and the body moves',
    last < 0 || (used[row] > 0 && moves(row)), `row ${row}`);
  check('near the end of that', last < 0 || row > 0.9 * last, `row ${row} of ${last}`);
}

/** The tiles of NEES and NIS say what a good value is, by key and by touch. */
export async function explanations(page, { run }) {
  const asked = ['nees_pose', 'nis_per_dof'].filter((key) => typeof run.summary[key] === 'number');
  for (const key of asked) {
    const more = page.locator(`.card-more[data-key="${key}"]`), text = more.locator('p');
    check(`${key}: the explanation is closed at first`, !await text.isVisible());
    await more.locator('summary').focus();
    await page.keyboard.press('Enter');
    await until(`${key}: Enter opens the explanation`, () => text.isVisible());
    check(`${key}: it says what is good`, /Good is about/.test(await text.textContent()));
    await more.locator('summary').click();
    await until(`${key}: a click closes it`, async () => !await text.isVisible());
  }
}
