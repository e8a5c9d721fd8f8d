// What a plot over time shows: stacked panels with one common time axis.
import type { KeyEntry } from './canvas';
import type { Values } from './data';
import type { CsvColumn } from './files';
import { number } from './format';
import { activeSubject } from './store';

/** 'band' lies between low and high, 'area' reaches from zero, 'level' is a thin dashed line; 'stack'
 *  is a band that has values: its thickness. */
export type Style = 'line' | 'band' | 'area' | 'level' | 'stack';

/** Whether it lies between low and high. */
export const isBand = (s: Series): boolean => s.style === 'band' || s.style === 'stack';

export interface Series {
  /** Names it in the legend; series of one label are switched together. */
  label: string;
  /** Names it among the values at the cursor, where the panel's label does not. */
  name?: string;
  style: Style;
  values?: Values;
  low?: Values;
  high?: Values;
  sigma?: ArrayLike<number>;
  colour: string;
  dash?: number[];
  legend?: boolean;
}

export interface Panel {
  label: string;
  unit?: string;
  series: Series[];
  /** What it comes to, in words. */
  summary?: string;
  log?: boolean;
  /** Where a logarithmic axis ends. */
  floor?: number;
  /** The axis reaches down to zero. */
  zero?: boolean;
  /** Single spikes are cut off. */
  clip?: boolean;
}

export interface PlotSpec {
  title: string;
  caption?: string;
  panels: Panel[];
  /** Height of a panel [css px]. */
  height?: number;
  /** What a picture's key says where the legend is elsewhere. */
  key?: KeyEntry[];
}

export const panelTitle = (panel: Panel): string =>
  [panel.label, panel.unit ? `[${panel.unit}]` : ''].filter(Boolean).join(' ');

/** The distinct entries of a plot's legend. */
export function legendSeries(spec: PlotSpec): Series[] {
  const seen = new Map<string, Series>();
  for (const panel of spec.panels) {
    for (const s of panel.series) if (s.legend !== false && !seen.has(s.label)) seen.set(s.label, s);
  }
  return [...seen.values()];
}

export function valueText(panel: Panel, series: Series, i: number): string {
  const name = series.name || panel.label || series.label;
  const value = typeof series.values === 'object' ? series.values[i] : NaN;
  if (!Number.isFinite(value)) return `${name} –`;
  const sigma = series.sigma ? ` ± ${number(3 * series.sigma[i], 2)}` : '';
  return `${name} ${number(value)}${sigma}${panel.unit ? ' ' + panel.unit : ''}`;
}

export function plotDescription(spec: PlotSpec): string {
  return `${spec.title}. ${spec.caption ?? ''} Arrow keys move the time cursor; the CSV button ` +
    'gives the numbers.';
}

/** The columns of a plot's csv file: time, then what each panel draws. */
export function plotColumns(spec: PlotSpec): CsvColumn[] {
  const columns: CsvColumn[] = [{ label: 'time_s', values: activeSubject().t }];
  for (const panel of spec.panels) {
    for (const series of panel.series) {
      for (const [suffix, values] of [['', series.values], [' low', series.low],
        [' high', series.high]] as const) {
        if (typeof values !== 'object' || (series.style === 'stack' && suffix)) continue;
        const label = [panel.label, series.label].filter(Boolean).join(' ') + suffix;
        columns.push({ label, values });
      }
    }
  }
  return columns;
}
