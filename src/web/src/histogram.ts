// How many landmarks of each session have values in which range: bars of the page's own elements.
import { quantile } from './data';
import { grouped, make, number } from './format';
import { sessionColour } from './saved_map';

/** The borders of the bins, rising, one more than there are bins. */
export type Bins = number[];

export const evenBins = (low: number, high: number, count: number): Bins =>
  Array.from({ length: count + 1 }, (_, k) => low + (k * (high - low)) / count);

/** Bins whose borders have the same ratio: for values that span decades. */
export function logBins(values: ArrayLike<number>, count: number): Bins {
  const low = Math.max(quantile(values, 0.001), 1e-9), high = Math.max(quantile(values, 1), low * 1.01);
  return evenBins(Math.log(low), Math.log(high), count).map(Math.exp);
}

/** The numbers of values by bin and session; those beyond the borders count with the outermost bins. */
export function countBins(values: ArrayLike<number>, sessions: ArrayLike<number>, bins: Bins): number[][] {
  const counts: number[][] = bins.slice(1).map(() => []);
  for (let i = 0; i < values.length; i++) {
    if (!Number.isFinite(values[i])) continue;
    const beyond = bins.findIndex((border, k) => k > 0 && values[i] < border);
    const bin = counts[beyond < 0 ? counts.length - 1 : beyond - 1], k = sessions[i];
    bin[k] = (bin[k] ?? 0) + 1;
  }
  return counts;
}

export function histogram(title: string, label: string, values: ArrayLike<number>, bins: Bins,
    sessions: ArrayLike<number>): HTMLElement {
  const counts = countBins(values, sessions, bins);
  const totals = counts.map((bin) => bin.reduce((sum, n) => sum + (n ?? 0), 0));
  const most = Math.max(1, ...totals);
  const bars = counts.map((bin, k) => {
    // Whole numbers have a bin each.
    const whole = (bins[k] + bins[k + 1]) / 2, range = bins[1] - bins[0] === 1 && Number.isInteger(whole)
      ? number(whole) : `${number(bins[k])} to ${number(bins[k + 1])}`;
    return make('div', { class: 'bar', title: `${range}: ${grouped(totals[k])}` },
      ...bin.map((n, session) => (n ? make('i', {
        style: `height: ${(100 * n) / most}%; background: var(--${sessionColour(session)})` }) : null)));
  });
  const ends = bins[1] - bins[0] === 1 ? [bins[0] + 0.5, bins[bins.length - 1] - 0.5]
    : [bins[0], bins[bins.length - 1]];
  return make('figure', { class: 'panel', role: 'img', 'aria-label': `${title}: ${label}, from ` +
    `${number(ends[0])} to ${number(ends[1])}, median ${number(quantile(values, 0.5))}` },
    make('h3', {}, title), make('p', { class: 'muted small' }, label),
    make('div', { class: 'bars' }, ...bars),
    make('div', { class: 'bar-ends muted small' }, make('span', {}, number(ends[0])),
      make('span', {}, `median ${number(quantile(values, 0.5))}`), make('span', {}, number(ends[1]))));
}
