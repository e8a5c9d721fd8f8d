// Cards, Kleinert & Stilla's tables, settings: all that is words and single numbers.
import { asNumber, byId, fixed, flattened, grouped, isNumber, make, number, percent } from './format';
import { activeStudy, type Figures, figuresOf, paperPlace, type Study } from './studies';
import { filterName } from './study_colours';
import { keyTable, remarksIn, showRemarkList } from './tables';

export const DEGREES_OF_POSE = 6;
const DEGREES_OF_STATE = 15;

/** Index of the filter whose value is least; −1 where none has one. */
function leastOf(study: Study, value: (f: Figures) => number): number {
  let best = -1;
  figuresOf(study).forEach((f, k) => {
    const v = value(f);
    if (Number.isFinite(v) && !(best >= 0 && value(figuresOf(study)[best]) <= v)) best = k;
  });
  return best;
}

const distanceFromConsistent = (f: Figures) =>
  isNumber(f.nees_pose_per_dof) ? Math.abs(Math.log(f.nees_pose_per_dof)) : NaN;
const positionError = (f: Figures) => asNumber(f.position_error_m);

function card(label: string, value: string, unit: string, meaning: string): HTMLElement {
  return make('div', { class: 'card' }, make('div', { class: 'card-label' }, label),
    make('div', { class: 'card-value' }, value, make('span', { class: 'unit' }, unit)),
    make('div', { class: 'muted small', dir: 'auto' }, meaning));
}

export function showStudyCards(): void {
  const study = activeStudy();
  const figures = figuresOf(study);
  const sum = (key: string) =>
    figures.reduce((a, f) => a + (isNumber(f[key]) ? f[key] as number : 0), 0);
  const cards = [study.single
    ? card('Frames', grouped(study.count), '', `run ${number(study.summary.run)} of the noise`)
    : card('Runs', grouped(asNumber(study.summary.runs)), '', 'of each filter, on the same noise')];
  const consistent = leastOf(study, distanceFromConsistent), precise = leastOf(study, positionError);
  if (consistent >= 0) {
    cards.push(card('Nearest to consistent', number(figures[consistent].nees_pose_per_dof), '',
      `pose NEES per degree of freedom, filter ${study.filters[consistent].label}`));
  }
  if (precise >= 0) {
    cards.push(card('Smallest position error', number(figures[precise].position_error_m), 'm',
      `mean, filter ${study.filters[precise].label}`));
  }
  cards.push(card('Diverged', grouped(sum('diverged')), '', `of ${grouped(sum('runs'))} trials`));
  byId('cards').replaceChildren(...cards);
}

/** A column of a table: heading, text of a filter's figures, and what its cell looks like. */
interface TableColumn { heading: string; text: (f: Figures) => string; classOf: (f: Figures) => string }

const textColumn = (heading: string, text: TableColumn['text'], classOf: TableColumn['classOf'] = () => ''):
    TableColumn => ({ heading, text, classOf });
const numberColumn = (heading: string, value: (f: Figures) => number | undefined, digits: number,
    classOf?: TableColumn['classOf']) =>
  textColumn(heading, (f) => fixed(asNumber(value(f)), digits), classOf);

const isInside = (f: Figures) => Array.isArray(f.band) && isNumber(f.nees_pose_per_dof) &&
  f.nees_pose_per_dof >= f.band[0] && f.nees_pose_per_dof <= f.band[1];

function neesStyle(f: Figures): string {
  if (!isNumber(f.nees_pose_per_dof) || !Array.isArray(f.band)) return '';
  return isInside(f) ? 'inside' : f.nees_pose_per_dof > f.band[1] ? 'outside' : '';
}

const any = (study: Study, key: string) => figuresOf(study).some((f) => isNumber(f[key]));
const medianOf = (f: Figures, key: string) => (f.median ? f.median[key] : NaN);
const onlyIf = (condition: boolean, ...columns: TableColumn[]) => (condition ? columns : []);

/** Those of the paper's tables I and II. A filter with its settings may lose its way in single runs,
 *  which draw the mean away: over several runs the medians are beside it. */
function paperColumns(study: Study): TableColumn[] {
  const best = leastOf(study, positionError);
  const classOf = (f: Figures) => (best >= 0 && f === figuresOf(study)[best] ? 'best' : '');
  return [
    numberColumn('avg. NEES position', (f) => f.nees_position, 2),
    numberColumn('avg. NEES attitude', (f) => f.nees_attitude, 2),
    numberColumn('avg. error position [m]', (f) => f.position_error_m, 4, classOf),
    numberColumn('avg. error attitude [°]', (f) => f.attitude_error_deg, 4),
    ...onlyIf(!study.single,
      numberColumn('median NEES position', (f) => medianOf(f, 'nees_position'), 2),
      numberColumn('median NEES attitude', (f) => medianOf(f, 'nees_attitude'), 2),
      numberColumn('median error position [m]', (f) => medianOf(f, 'position_error_m'), 4),
      numberColumn('median error attitude [°]', (f) => medianOf(f, 'attitude_error_deg'), 4)),
  ];
}

function moreColumns(study: Study): TableColumn[] {
  return [
    textColumn('pose NEES / dof', (f) => (isNumber(f.nees_pose_per_dof)
      ? fixed(f.nees_pose_per_dof, 3) + (isInside(f) ? ' ✓' : '') : '–'), neesStyle),
    textColumn('95 % band', (f) => (Array.isArray(f.band)
      ? `${fixed(f.band[0], 3)} … ${fixed(f.band[1], 3)}` : '–')),
    ...onlyIf(!study.single,
      numberColumn('median pose / dof', (f) => medianOf(f, 'nees_pose') / DEGREES_OF_POSE, 3),
      textColumn('seconds inside', (f) => percent(f.seconds_inside_band ?? NaN))),
    ...onlyIf(any(study, 'nees_state'),
      numberColumn('state NEES / dof', (f) => asNumber(f.nees_state) / DEGREES_OF_STATE, 3)),
    numberColumn('NIS / dof', (f) => asNumber(f.nis_per_dof), 3),
    ...onlyIf(any(study, 'innovation_correlation'),
      numberColumn('innovation correlation', (f) => f.innovation_correlation, 3)),
    numberColumn('position rms [m]', (f) => f.position_rms_m, 4),
    ...onlyIf(any(study, 'ate_posyaw_m'),
      numberColumn('ATE, yaw aligned [m]', (f) => f.ate_posyaw_m, 4)),
    numberColumn('landmarks', (f) => f.landmarks, 0),
    ...onlyIf(!study.single, textColumn('runs', (f) => grouped(asNumber(f.runs))),
      textColumn('diverged', (f) => grouped(asNumber(f.diverged)),
        (f) => (asNumber(f.diverged) > 0 ? 'outside' : ''))),
    ...onlyIf(study.single, textColumn('health', (f) => (asNumber(f.diverged) > 0 ? 'diverged' : 'ok'),
      (f) => (asNumber(f.diverged) > 0 ? 'outside' : ''))),
  ];
}

function filterTable(study: Study, columns: TableColumn[]): HTMLElement {
  const head = make('tr', {}, make('th', { scope: 'col', style: 'text-align: left' }, 'filter'),
    ...columns.map((c) => make('th', { scope: 'col' }, c.heading)));
  const rows = study.filters.map(({ figures }, k) => make('tr', {},
    make('th', { scope: 'row' }, filterName(k)),
    ...columns.map((c) => make('td', { class: c.classOf(figures) }, c.text(figures)))));
  return make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows));
}

export function showStudyTables(): void {
  const study = activeStudy(), place = paperPlace(study);
  byId('results-title').textContent = place ? `Table ${place.table}: ${place.scene}` : 'NEES and errors';
  byId('results-table').replaceChildren(filterTable(study, paperColumns(study)));
  byId('more-table').replaceChildren(filterTable(study, moreColumns(study)));
  const over = study.single ? 'the run’s frames' : 'the frames and the runs that did not diverge';
  byId('results-caption').textContent = `Averages over ${over}` + (study.single ? '. '
    : '; the medians are those of the runs’ averages. ') +
    'NEES is the squared error over the covariance that the filter reports, in the coordinates of its ' +
    'chart: 3 for position and attitude when the filter is consistent. Nothing is aligned: the filter ' +
    'begins at the true pose.' + (place ? ' The columns are those of Kleinert & Stilla’s ' +
      `table ${place.table}${study.single ? '' : ', with the medians added'}.` : '');
  byId('more-caption').textContent = 'Per degree of freedom the NEES is 1 when the filter is consistent; ' +
    'a pose NEES of 4 per degree of freedom means that the covariance is 4 times too small. ' +
    (study.single
      ? 'The band holds the value of a single frame with 95 % probability; ✓ is inside.'
      : 'The band holds the mean over the runs at one instant with 95 % probability; ✓ is inside.') +
    (any(study, 'ate_posyaw_m') ? ' The ATE alone is that of an aligned trajectory.' : '');
}

const textCell = (text: string) => make('td', { dir: 'auto' }, text);

export function showScene(): void {
  const entries = Object.entries(flattened(activeStudy().summary.scene));
  byId('scene-settings').replaceChildren(keyTable(entries.map(([key, value]) => [key, textCell(value)])));
  byId('scene-panel').hidden = entries.length === 0;
}

/** What differs among the filters, a row each; below it what they have in common. */
export function showFilterSettings(): void {
  const study = activeStudy();
  const all = figuresOf(study).map((f) => flattened(f.settings));
  const keys = [...new Set(all.flatMap((s) => Object.keys(s)))];
  const text = (s: Record<string, string>, key: string) => (s[key] === undefined ? '–' : s[key]);
  const same = (key: string) => all.every((s) => text(s, key) === text(all[0], key));
  const different = keys.filter((key) => !same(key));
  const common = keys.filter(same);
  const head = make('tr', {}, make('th', { scope: 'col' }, 'filter'),
    ...different.map((key) => make('th', { scope: 'col', dir: 'auto' }, key)));
  const rows = all.map((s, k) => make('tr', {}, make('th', { scope: 'row' }, filterName(k)),
    ...different.map((key) => textCell(text(s, key)))));
  byId('settings').replaceChildren(different.length
    ? make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows)) : '');
  byId('common').replaceChildren(keyTable(common.map((key) => [key, textCell(text(all[0], key))])));
  byId('common-title').textContent = study.filters.length > 1 ? 'All filters alike' : '';
  byId('settings-panel').hidden = keys.length === 0;
}

export const showStudyRemarks = (): void => showRemarkList(remarksIn(activeStudy().summary));
