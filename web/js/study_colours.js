// How a filter looks, the same in every figure, and which of them are drawn.

const HUES = 8;
const DASHES = [null, [7, 4], [2, 3], [10, 3, 2, 3]];
const SWATCHES = ['line', 'dashed', 'dotted', 'dashdot'];

const filterColour = (k) => `f-${1 + (k % HUES)}`;
const filterDash = (k) => DASHES[Math.floor(k / HUES) % DASHES.length];
const filterSwatch = (k) => swatch(SWATCHES[Math.floor(k / HUES) % SWATCHES.length], filterColour(k));

/** The indices of the filters that are drawn. */
const shownFilters = () => activeRun().filters.map((_, k) => k).filter((k) => activeRun().shown[k]);

/** The key of the lines, for pictures that leave the page. */
const filterKey = () => shownFilters().map((k) =>
  ({ text: activeRun().filters[k].label, colour: filterColour(k), dash: filterDash(k) }));

function filterName(k) {
  return make('span', { class: 'filter-name', dir: 'auto' }, filterSwatch(k),
    activeRun().filters[k].label);
}

function showFilterLegend() {
  const study = activeRun();
  byId('filters-legend').replaceChildren(...study.filters.map((_, k) => {
    const box = make('input', { type: 'checkbox' });
    box.checked = study.shown[k];
    box.addEventListener('change', () => { study.shown[k] = box.checked; notify('shown'); });
    return make('label', { class: 'key toggle' }, box, filterName(k));
  }));
}

function startFilterButtons() {
  for (const [id, shown] of [['all-filters', true], ['no-filters', false]]) {
    byId(id).addEventListener('click', () => {
      activeRun().shown.fill(shown);
      showFilterLegend();
      notify('shown');
    });
  }
}
