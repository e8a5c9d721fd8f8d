// How a filter looks, the same in every figure, and which of them are drawn.
import type { KeyEntry } from './canvas';
import { byId, make, swatch, toggle } from './format';
import { notify } from './store';
import { activeStudy, type Filter, type Study } from './studies';

const HUES = ['f-1', 'f-2', 'f-3', 'f-4', 'f-5', 'f-6', 'f-7', 'f-8'];
const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3]];
const SWATCHES = ['line', 'dashed', 'dotted', 'dashdot'];

/** Kleinert & Stilla's figures 2 and 3, (b) and (c): standard blue, left-invariant red, right-invariant
 *  green. The blue and the green are those of the charts on every page. On the map of their figure 2 (a)
 *  the standard filter is green instead; here a filter has one colour in all figures. */
const PAPER_COLOURS: Record<string, string> =
  { standard: 'f-1', 'left-se3': 'left-invariant', 'right-se3': 'f-3' };
/** Too near to the red. */
const WARM = ['f-2', 'f-6'];

function paperColour({ label, figures: { chart } }: Filter): string | undefined {
  return label.startsWith('paper-') && typeof chart === 'string' ? PAPER_COLOURS[chart] : undefined;
}

/** The paper's filters have its colours, all others the hues that are left; where there are more filters
 *  than hues, their lines are broken. */
export function colourFilters({ filters }: Study): void {
  const taken = new Set<string>(), others: Filter[] = [];
  for (const filter of filters) {
    const own = paperColour(filter);
    if (own === undefined || taken.has(own)) {
      others.push(filter);
      continue;
    }
    filter.colour = own;
    taken.add(own);
  }
  const warm = taken.has('left-invariant') ? WARM : [];
  const spare = HUES.filter((hue) => !taken.has(hue) && !warm.includes(hue));
  others.forEach((filter, k) => {
    filter.colour = spare[k % spare.length];
    filter.line = Math.floor(k / spare.length) % DASHES.length;
  });
}

export const filterColour = (k: number): string => activeStudy().filters[k].colour;
export const filterDash = (k: number): number[] => DASHES[activeStudy().filters[k].line];
const filterSwatch = (k: number) => swatch(SWATCHES[activeStudy().filters[k].line], filterColour(k));

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
