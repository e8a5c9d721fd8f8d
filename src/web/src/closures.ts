// The loop closures of a run, as summary.json lists them, and its search for a place in a saved map.
import { nearestIndex } from './data';
import { byId, fixed, grouped, isNumber, make, number } from './format';
import { placeTip } from './map_input';
import { activeRun, type Run } from './runs';

export interface Closure {
  /** The first state with it. */
  state: number;
  landmarks: number;
  /** By which it moved [m] and turned [°] the pose. */
  moved: number;
  turned: number;
  /** Of the innovations of its landmarks, and its degrees of freedom; NaN where it is not known. */
  chi2: number;
  dof: number;
  /** Later frames rejected most of its landmarks. */
  undone: boolean;
}

/** Those whose pose is finite. */
export function closuresOf(run: Run): Closure[] {
  const { summary: { closures }, states: { x, y, z } } = run;
  if (!Array.isArray(closures) || !run.count) return [];
  const known = closures.filter(({ seconds }) => typeof seconds === 'number');
  return known.map((entry: Record<string, unknown>) => ({
    state: nearestIndex(run.t, Number(entry.seconds)),
    landmarks: Number(entry.landmarks) || 0,
    moved: Number(entry.moved_m) || 0,
    turned: (180 / Math.PI) * (Number(entry.turned_rad) || 0),
    chi2: isNumber(entry.chi2) ? entry.chi2 : NaN,
    dof: isNumber(entry.chi2_dof) ? entry.chi2_dof : NaN,
    undone: entry.undone === true,
  })).filter(({ state: i }) => Number.isFinite(x[i] + y[i] + z[i]));
}

const timeText = (run: Run, { state, undone }: Closure): string =>
  `${fixed(run.t[state], 2)} s${undone ? ', later undone' : ''}`;

const chi2Text = ({ chi2, dof }: Closure): string =>
  (dof > 0 ? `${number(chi2)} of ${dof}` : '–');

/** What a closure did, beside its place on the screen. */
export function showClosureTip(run: Run, closure: Closure, x: number, y: number, width: number,
    height: number): void {
  const tip = byId('map-tip'), { landmarks, moved, turned } = closure;
  tip.replaceChildren(make('strong', {}, `Loop closed at ${timeText(run, closure)}`),
    make('div', {}, `${grouped(landmarks)} landmarks returned`),
    make('div', {}, `the pose moved ${number(moved)} m, turned ${number(turned)}°`),
    make('div', {}, `χ²  ${chi2Text(closure)} degrees of freedom`));
  placeTip(tip, x, y, width, height);
}

/** The table of the closures, folded up. */
export function showClosures(): void {
  const run = activeRun(), list = closuresOf(run), cell = (text: string) => make('td', {}, text);
  byId('closures-panel').hidden = list.length === 0;
  byId('closures-title').textContent =
    `${grouped(list.length)} loop closure${list.length === 1 ? '' : 's'}`;
  const heads = ['at', 'landmarks', 'moved', 'turned', 'χ² of its degrees of freedom'];
  byId('closures').replaceChildren(make('table', {},
    make('thead', {}, make('tr', {}, ...heads.map((h) => make('th', { scope: 'col' }, h)))),
    make('tbody', {}, ...list.map((closure) => make('tr', {},
      make('th', { scope: 'row' }, timeText(run, closure)),
      cell(grouped(closure.landmarks)), cell(`${number(closure.moved)} m`),
      cell(`${number(closure.turned)}°`), cell(chi2Text(closure)))))));
}

/** What a run says of its place in a map: a sentence; nothing of a run without one. */
export function placeText({ summary: { place_in_map: place } }: Run): string {
  if (!place || typeof place !== 'object') return '';
  const p = place as Record<string, unknown>, count = (key: string) => grouped(Number(p[key]) || 0);
  const found = isNumber(p.placed_seconds) ? `found after ${fixed(p.placed_seconds, 1)} s`
    : isNumber(p.placed_ns) ? 'found' : 'not found';
  return `${found}; searches: ${count('searches')}, places proposed: ${count('proposed')}, ` +
    `rejected: ${count('refused')}`;
}
