// Key figures, tables, settings and remarks: all that is words and single numbers.
import { exact } from './exact';
import { byId, type Child, flattened, grouped, isNumber, isScalar, make, number, percent, plainText,
  titleCase } from './format';
import { activeRun, type Run } from './runs';
import { app } from './store';

// [key of summary.json, label, unit, digits, what it means]
const FIGURES: [string, string, string, number, string][] = [
  ['ate_m', 'ATE, best fit', 'm', 3, 'position error, rms, after the best rigid fit to the truth'],
  ['ate_posyaw_m', 'ATE, position and yaw fitted', 'm', 3, 'the same, the vertical kept'],
  ['ate_first_pose_m', 'ATE, first pose aligned', 'm', 3, 'nothing fitted but the first pose'],
  ['attitude_deg', 'Attitude error', '°', 3, 'rms angle, best rigid fit'],
  ['attitude_posyaw_deg', 'Attitude error, yaw fitted', '°', 3, ''],
  ['attitude_first_pose_deg', 'Attitude error, first pose aligned', '°', 3, ''],
  ['rpe_100m_percent', 'Relative error over 100 m', '%', 3, 'drift over pieces of 100 m'],
  ['rpe_100m_deg_per_m', 'Relative rotation over 100 m', '°/m', 3, ''],
  ['rpe_1s_m', 'Relative error over 1 s', 'm', 3, ''],
  ['rpe_1s_deg', 'Relative rotation over 1 s', '°', 3, ''],
  ['nees_pose', 'NEES, pose', '', 3, 'mean; 6 is consistent'],
  ['nees_position', 'NEES, position', '', 3, 'mean; 3 is consistent'],
  ['nees_attitude', 'NEES, attitude', '', 3, 'mean; 3 is consistent'],
  ['nis_per_dof', 'NIS per degree of freedom', '', 3, '1 is consistent'],
  ['path_m', 'Path', 'm', 4, 'of the truth'],
  ['duration_s', 'Duration', 's', 4, ''],
  ['frames', 'Frames', '', 0, ''],
  ['matched', 'Compared with truth', '', 0, 'stamps'],
  ['landmarks', 'Landmarks', '', 0, 'of the whole map'],
  ['seconds_wall', 'Wall time', 's', 3, 'the whole run with reading'],
  ['seconds_cpu', 'Processor time', 's', 3, ''],
  ['realtime_factor', 'Times real time', '×', 3, 'duration of the recording over wall time'],
  ['health', 'Health', '', 0, ''],
];
// [key, label, unit, meaning] of the figures at the top.
const CARDS: [string, string, string, string][] = [
  ['ate_m', 'ATE', 'm', 'rms position, best fit'],
  ['rpe_100m_percent', 'Drift', '%', 'over 100 m'],
  ['attitude_deg', 'Attitude', '°', 'rms angle, best fit'],
  ['nees_pose', 'Pose NEES', '', '6 is consistent'],
  ['nis_per_dof', 'NIS / dof', '', '1 is consistent'],
  ['landmarks', 'Landmarks', '', 'of the whole map'],
  ['frames', 'Frames', '', 'estimated'],
  ['realtime_factor', 'Speed', '×', 'real time'],
];

const allRuns = () => app.subjects as Run[];

function scalarText(v: unknown, digits = 4): string {
  if (v === null || v === undefined) return '–';
  return typeof v === 'number' ? number(v, digits || 9) : String(v);
}

export function showCards(): void {
  const { summary } = activeRun();
  const known = CARDS.filter(([key]) => isNumber(summary[key]));
  byId('cards').replaceChildren(...known.map(([key, label, unit, meaning]) =>
    make('div', { class: 'card' },
      make('div', { class: 'card-label' }, label),
      make('div', { class: 'card-value', tabindex: 0, role: 'note', ...exact(key, summary[key]) },
        scalarText(summary[key], 3), make('span', { class: 'unit' }, unit)),
      make('div', { class: 'muted small' }, meaning))));
  byId('cards').hidden = known.length === 0;
}

export function table(heads: string[] | null, rows: Child[][]): HTMLElement {
  return make('table', {},
    heads ? make('thead', {}, make('tr', {}, ...heads.map((h, k) =>
      make(k ? 'th' : 'td', k ? { scope: 'col', dir: 'auto' } : {}, h)))) : null,
    make('tbody', {}, ...rows.map(([name, ...cells]) =>
      make('tr', {}, make('th', { scope: 'row', dir: 'auto' }, name), ...cells))));
}

function headings(extra: string[] = []): string[] | null {
  return app.subjects.length > 1 ? ['', ...app.subjects.map((r) => r.label), ...extra] : null;
}

export function showFigures(): void {
  const rows: Child[][] = [];
  const known = new Set(FIGURES.map((f) => f[0]).concat('version', 'name', 'mode', 'chart',
    'settings', 'remarks'));
  for (const [key, label, unit, digits, meaning] of FIGURES) {
    const values = allRuns().map((r) => r.summary[key]);
    if (values.every((v) => v === undefined || !isScalar(v))) continue;
    rows.push([label, ...values.map((v) => figureCell(key, v, digits, unit)),
      make('td', { class: 'muted small meaning' }, meaning)]);
  }
  for (const key of keysOf((r) => r.summary)) {
    const values = allRuns().map((r) => r.summary[key]);
    if (known.has(key) || values.some((v) => v !== undefined && !isScalar(v))) continue;
    rows.push([titleCase(key), ...values.map((v) => figureCell(key, v, 5, '')),
      make('td', {})]);
  }
  byId('figures').replaceChildren(table(headings(['']), rows));
  byId('figures-panel').hidden = rows.length === 0;
}

function figureCell(key: string, value: unknown, digits: number, unit: string): HTMLElement {
  const text = scalarText(value, digits);
  return make('td', { class: 'figure', ...exact(key, value) },
    text === '–' || !unit ? text : `${text} ${unit}`);
}

/** The keys of all runs' objects, each once, in their order. */
function keysOf(pick: (run: Run) => object): string[] {
  return [...new Set(allRuns().flatMap((r) => Object.keys(pick(r))))];
}

/** Settings, and any other object that the summary holds. */
function settingsOf(run: Run): Record<string, string> {
  const others = Object.entries(run.summary).filter(([key, v]) =>
    !['settings', 'remarks', 'cameras'].includes(key) && !isScalar(v));
  return { ...flattened(run.summary.settings), ...flattened(Object.fromEntries(others)) };
}

export function showSettings(): void {
  const all = allRuns().map(settingsOf);
  const keys = [...new Set(all.flatMap((s) => Object.keys(s)))];
  const rows = keys.map((key) => {
    const values = all.map((s) => s[key] === undefined ? '–' : s[key]);
    const same = values.every((v) => v === values[0]);
    const look = { class: same ? '' : 'differs', dir: 'auto' };
    return [key, ...values.map((v) => make('td', look, v))];
  });
  byId('settings').replaceChildren(table(headings(), rows));
  byId('settings-panel').hidden = rows.length === 0;
}

function remarksOf(run: Run): string[] {
  const remarks = remarksIn(run.summary);
  if (run.truthProblem) remarks.push(`The truth could not be compared: ${run.truthProblem}`);
  if (run.landmarksLeftOut) {
    remarks.push(`${grouped(run.landmarksLeftOut)} landmarks are not finite and not drawn.`);
  }
  return remarks;
}

/** The sentences of a summary. */
export const remarksIn = ({ remarks }: Record<string, unknown>): string[] =>
  (Array.isArray(remarks) ? remarks : remarks ? [remarks] : []).map(plainText);

export function showRemarkList(remarks: string[]): void {
  byId('remarks').replaceChildren(make('ul', {},
    ...remarks.map((r) => make('li', { dir: 'auto' }, r))));
  byId('remarks-panel').hidden = remarks.length === 0;
}

export function showRemarks(): void {
  showRemarkList(remarksOf(activeRun()));
}

/** ok, or how long the filter was not. */
export function showHealth(): void {
  const run = activeRun();
  const share = run.healthNames.map((name, k): [string, number] => {
    let frames = 0;
    for (const h of run.states.health) if (h === k) frames++;
    return [name, frames / Math.max(1, run.count)];
  });
  const bad = share.filter(([name, part]) => name !== 'ok' && part > 0);
  const badge = byId('health-badge');
  const told = isScalar(run.summary.health) && run.summary.health;
  const overall = String(told || (bad.length ? bad[0][0] : 'ok'));
  badge.textContent = overall === 'ok' ? '✓ healthy' : `⚠ ${overall}`;
  badge.className = 'badge ' + (overall === 'ok' ? 'ok' : overall === 'lost' ? 'lost' : 'degraded');
  badge.title = bad.map(([name, part]) => `${name}: ${percent(part)} of the frames`).join(', ');
}
