// The value axis of a panel: its limits over the visible time span, its ticks and their texts.
import { grouped } from './format';
import { tickText, ticksOf } from './canvas';
import { at, quantile } from './data';
import type { Panel, Series } from './plot_spec';
import { activeSubject, app } from './store';

type Limits = [number, number];

function* visibleValues(series: Series[]): Generator<number> {
  const { t } = activeSubject();
  const [from, to] = app.span;
  for (const { values, low, high } of series) {
    for (const column of [values, low, high]) {
      if (column === undefined) continue;
      if (typeof column === 'number') { yield column; continue; }
      for (let i = 0; i < t.length; i++) if (t[i] >= from && t[i] <= to) yield column[i];
    }
  }
}

/** The limits of the panel's axis for those of its series that are drawn. */
export function panelLimits(panel: Panel, drawn: Series[]): Limits {
  return panel.log ? logLimits(panel, drawn) : linearLimits(panel, drawn);
}

function linearLimits(panel: Panel, drawn: Series[]): Limits {
  let low = Infinity, high = -Infinity;
  for (const v of visibleValues(drawn)) {
    if (!Number.isFinite(v)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (low > high) return [0, 1];
  if (panel.clip) high = clippedHigh(drawn, high);
  if (panel.zero) low = Math.min(0, low);
  // Below this a constant is drawn as a line in the middle, not as magnified rounding.
  const least = Math.max(1e-9, 1e-6 * Math.max(Math.abs(low), Math.abs(high)));
  const room = high - low < least ? Math.max(least, Math.abs(high) * 0.1) : 0.06 * (high - low);
  return [panel.zero && low === 0 ? 0 : low - room, high + room];
}

/** Cuts off single spikes, so that the rest stays readable. */
function clippedHigh(drawn: Series[], high: number): number {
  const usual = quantile([...visibleValues(drawn)], 0.99);
  return high > 3 * usual ? 2 * usual : high;
}

function logLimits(panel: Panel, drawn: Series[]): Limits {
  let low = Infinity, high = 0;
  for (const v of visibleValues(drawn)) {
    if (!(v > 0) || !Number.isFinite(v)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (!(high > 0)) return [0.1, 10];
  return [Math.max(low, high / 1e6, panel.floor ?? 0) / 1.4, high * 1.6];
}

/** Ticks of a value axis, three or more: one alone gives no scale; powers of ten on a logarithmic one,
 *  every second or third where there are many. */
export function valueTicks([low, high]: Limits, log = false): number[] {
  if (!log) {
    const ticks = ticksOf(low, high, 4);
    return ticks.length > 2 ? ticks : ticksOf(low, high, 8);
  }
  const first = Math.ceil(Math.log10(low)), last = Math.floor(Math.log10(high));
  const step = Math.ceil((last - first + 1) / 6);
  const ticks = [];
  for (let k = first; k <= last; k += step) ticks.push(10 ** k);
  return ticks;
}

export function tickTexts(ticks: number[], log = false): string[] {
  if (log) return ticks.map(powerText);
  const step = ticks.length > 1 ? ticks[1] - ticks[0] : 1;
  return ticks.map((v) => tickText(v, step));
}

/** A power of ten. */
function powerText(v: number): string {
  const exponent = Math.round(Math.log10(v));
  return exponent >= -4 && exponent < 5 ? grouped(v, Math.max(0, -exponent))
    : v.toExponential(0).replace('-', '−').replace('+', '');
}

/** The stretches of time in which the filter did not call itself well: [from, to, name]. */
export function unwell(): [number, number, string][] {
  const { t, health, healthNames, count } = activeSubject();
  const pieces: [number, number, string][] = [];
  for (let i = 0; i < count; i++) {
    const first = i;
    while (i + 1 < count && health[i + 1] === health[first]) i++;
    const name = healthNames[health[first]];
    if (name !== 'ok') pieces.push([t[first], t[Math.min(i + 1, count - 1)], name]);
  }
  return pieces;
}

/** Whether a row of the column can be drawn. */
export const isKnown = (column: Series['values'], i: number): boolean =>
  column !== undefined && Number.isFinite(at(column, i));
