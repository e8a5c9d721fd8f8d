// The frame at which the page of a run opens.
import { type Columns } from './data';

/** Distance to the row before over the time between [m/s], 0 for the first row. */
function speeds({ t, x, y, z }: Columns): number[] {
  return Array.from(t, (time, i) => (i === 0 ? 0 :
    Math.hypot(x[i] - x[i - 1], y[i] - y[i - 1], z[i] - z[i - 1]) / (time - t[i - 1])));
}

/** The last row at which the body moves and observations are used, for at a standstill the image shows none
 *  of that; else the last row. The map is nearly whole there. It moves at half the speed that a quarter of
 *  the rows exceed. */
export function openingRow(states: Columns): number {
  const { used } = states, speed = speeds(states), last = speed.length - 1;
  const sorted = speed.filter(Number.isFinite).sort((a, b) => a - b);
  const moving = 0.5 * (sorted[Math.floor(0.75 * sorted.length)] ?? 0);
  for (let i = last; i >= 0; i--) if (used[i] > 0 && speed[i] >= moving) return i;
  return Math.max(0, last);
}
