// The figures of the runs of one scene side by side, and their errors over time.
import { nearestIndex } from './data';
import { asNumber, byId, fixed, flattened, make, swatch } from './format';
import type { PlotSpec, Series } from './plot_spec';
import { leavesBandFar } from './plots';
import { activeRun, chartOf, type Run, type Summary } from './runs';
import { type Scene, sceneOf, type SceneRun } from './scenes';
import { app } from './store';
import { table } from './tables';

const perDegree = (v: number | undefined, dof: number) => asNumber(v) / dof;

// [heading, value of a run's summary, its entry of the scene and the run, decimals]

const OVERVIEW_COLUMNS: [string, (s: Summary, entry: SceneRun, run: Run) => unknown, number][] = [
  ['ATE [m]', (s, _, { level }) => s[level ? 'ate_posyaw_m' : 'ate_m'], 3],
  ['attitude [°]', (s, _, { level }) => s[level ? 'attitude_posyaw_deg' : 'attitude_deg'], 3],
  ['NEES position', (_, { against }) => perDegree(against?.meanNees.position, 3), 2],
  ['NEES attitude', (_, { against }) => perDegree(against?.meanNees.attitude, 3), 2],
  ['NEES pose', (_, { against }) => perDegree(against?.meanNees.pose, 6), 2],
  ['walked [m]', (s) => s.path_m, 1], ['resets', (s) => s.resets, 0],
];

/** The settings of a run that are not those of all others, but for the chart. */
function differences(runs: Run[]): string[] {
  const all = runs.map((run) => flattened(run.summary.settings));
  const keys = [...new Set(all.flatMap((s) => Object.keys(s)))].filter((key) =>
    key !== 'chart' && all.some((s) => s[key] !== all[0][key]));
  return all.map((s) => keys.map((key) => `${key} ${s[key] === undefined ? '–' : s[key]}`).join(', '));
}

export const runAt = (index: number): Run => app.subjects[index] as Run;

export const runSwatch = (index: number): HTMLElement => {
  const { colour, dash } = runAt(index);
  return swatch(dash.length ? 'dashed' : 'line', colour);
};

export function showOverviewTable(scene: Scene): void {
  const runs = scene.runs.map(({ index }) => runAt(index));
  const values = OVERVIEW_COLUMNS.map(([, value]) =>
    scene.runs.map((entry, k) => asNumber(value(runs[k].summary, entry, runs[k]))));
  const known = OVERVIEW_COLUMNS.map((_, c) => c).filter((c) => values[c].some(Number.isFinite));
  const differing = differences(runs), differ = differing.some(Boolean);
  const rows = scene.runs.map(({ index }, k): (HTMLElement | string)[] => [
    make('span', { class: 'run-name', dir: 'auto' }, runSwatch(index), runs[k].label),
    make('td', { dir: 'auto' }, chartOf(runs[k]) || '–'),
    ...known.map((c) =>
      make('td', { class: 'figure' }, fixed(values[c][k], OVERVIEW_COLUMNS[c][2]))),
    ...(differ ? [make('td', { class: 'small', dir: 'auto' }, differing[k])] : []),
  ]);
  byId('overview-table').replaceChildren(table(['', 'chart',
    ...known.map((c) => OVERVIEW_COLUMNS[c][0]), ...(differ ? ['settings'] : [])], rows));
}


/** Values at the times of the active run, from the nearest row. */
function atActiveTimes(times: ArrayLike<number>, values: ArrayLike<number>, start: number):
    Float32Array {
  return Float32Array.from(activeRun().t, (t) => {
    const i = nearestIndex(times, t + start);
    return Math.abs(times[i] - t - start) < 1 ? values[i] : NaN;
  });
}

/** Errors and NEES of all runs of the scene; nothing for a run that is alone, or without a truth. */
export function overviewPlots(): PlotSpec[] {
  const scene = sceneOf(app.active);
  if (!scene?.truth || scene.runs.length < 2) return [];
  // The active run's first row is its first state that could be compared, nearly always the first.
  const start = scene.runs.find((r) => r.index === app.active)?.t[0] ?? 0;
  const lines = (column: 'distance' | 'nees') => scene.runs.map((entry): Series => {
    const { label, colour, dash } = runAt(entry.index);
    return { label, name: label, style: 'line', colour, dash,
      values: atActiveTimes(entry.t, entry.against?.[column] ?? [], start) };
  });
  const { chi2_6_low: low, chi2_6_high: high } = activeRun().bounds, nees = lines('nees');
  return [{
    title: 'Position error of all runs',
    caption: 'Distance from the true position, each run fitted to the truth as above.',
    panels: [{ label: '', unit: 'm', zero: true, series: lines('distance') }],
  }, {
    title: 'NEES of the pose of all runs',
    caption: 'Each in the coordinates of its chart; 6 on average where a filter is consistent.',
    panels: [{ label: '', zero: true, floor: 0.06, clip: true,
      log: nees.some((s) => typeof s.values === 'object' && leavesBandFar(s.values, high)),
      series: [{ label: '95 % band', style: 'band', low, high, colour: 'good' }, ...nees] }],
  }];
}
