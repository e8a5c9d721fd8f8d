// The plots over time of a page.
import { byId, make } from './format';
import { TimePlot } from './plot';
import type { PlotSpec } from './plot_spec';
import { app, listen, showAllTimes } from './store';

let plots: TimePlot[] = [];

export const timePlots = (): readonly TimePlot[] => plots;

/** Replaces the plots; `arrange` makes of them what stands on the page. */
export function showPlots(specs: PlotSpec[], arrange: (plots: TimePlot[]) => HTMLElement[]): void {
  for (const plot of plots) plot.destroy();
  plots = specs.map((spec) => new TimePlot(spec));
  byId('plots').replaceChildren(...arrange(plots));
}

/** The same plots with other numbers; where they are others, as showPlots(). */
export function updatePlots(specs: PlotSpec[], arrange: (plots: TimePlot[]) => HTMLElement[]): void {
  const same = specs.length === plots.length && specs.every((spec, k) => plots[k].fits(spec));
  if (same) specs.forEach((spec, k) => plots[k].update(spec));
  else showPlots(specs, arrange);
}

/** Two columns of about the same height; on a narrow screen `order` makes one of them again. */
export function plotsInColumns(list: TimePlot[]): HTMLElement[] {
  const columns = [0, 1].map(() => ({ height: 0, element: make('div', { class: 'column' }) }));
  list.forEach((plot, k) => {
    const shorter = columns[1].height < columns[0].height ? columns[1] : columns[0];
    // Heading, legend and caption take about as much as a panel and a half.
    shorter.height += plot.spec.panels.length + 1.5;
    plot.element.style.order = String(k);
    shorter.element.append(plot.element);
  });
  return columns.map((column) => column.element);
}

/** Keeps the plots with the page's cursor, time span and theme. */
export function followStore(): void {
  listen('cursor', () => { for (const plot of plots) plot.moveCursor(); });
  for (const kind of ['span', 'theme'] as const) {
    listen(kind, () => { for (const plot of plots) plot.draw(); });
  }
  listen('print', () => { for (const plot of plots) plot.print(); });
  listen('span', () => {
    byId('zoom-reset').hidden = app.span[0] <= app.fullSpan[0] && app.span[1] >= app.fullSpan[1];
  });
  byId('zoom-reset').addEventListener('click', showAllTimes);
}
