// How a filter looks, the same in every figure, and which of them are drawn.
import type { KeyEntry } from './canvas';
import { byId, make, swatch, toggle } from './format';
import { notify } from './store';
import { activeStudy } from './studies';

const HUES = 8;
const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3]];
const SWATCHES = ['line', 'dashed', 'dotted', 'dashdot'];

export const filterColour = (k: number): string => `f-${1 + (k % HUES)}`;
export const filterDash = (k: number): number[] => DASHES[Math.floor(k / HUES) % DASHES.length];
const filterSwatch = (k: number) =>
  swatch(SWATCHES[Math.floor(k / HUES) % SWATCHES.length], filterColour(k));

/** The indices of the filters that are drawn. */
export const shownFilters = (): number[] =>
  activeStudy().filters.map((_, k) => k).filter((k) => activeStudy().shown[k]);

/** The key of the lines, for pictures that leave the page. */
export const filterKey = (): KeyEntry[] => shownFilters().map((k) =>
  ({ text: activeStudy().filters[k].label, colour: filterColour(k), dash: filterDash(k) }));

export function filterName(k: number): HTMLElement {
  return make('span', { class: 'filter-name', dir: 'auto' }, filterSwatch(k),
    activeStudy().filters[k].label);
}

export function showFilterLegend(): void {
  const study = activeStudy();
  byId('filters-legend').replaceChildren(...study.filters.map(({ label }, k) =>
    toggle(filterSwatch(k), make('span', { class: 'filter-name', dir: 'auto' }, label),
      study.shown[k], (on) => { study.shown[k] = on; notify('shown'); })));
}

export function startFilterButtons(): void {
  for (const [id, shown] of [['all-filters', true], ['no-filters', false]] as const) {
    byId(id).addEventListener('click', () => {
      activeStudy().shown.fill(shown);
      showFilterLegend();
      notify('shown');
    });
  }
}
