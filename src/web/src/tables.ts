// Key figures, tables, settings and remarks: all that is words and single numbers.
import { type Closure, closuresOf, placeText } from './closures';
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
  ['within_3_sigma_rx', 'Within 3σ, rotation x', '', 4, 'share of the poses; 0.9973 is consistent'],
  ['within_3_sigma_ry', 'Within 3σ, rotation y', '', 4, ''],
  ['within_3_sigma_rz', 'Within 3σ, rotation z', '', 4, ''],
  ['within_3_sigma_x', 'Within 3σ, x', '', 4, ''],
  ['within_3_sigma_y', 'Within 3σ, y', '', 4, ''],
  ['within_3_sigma_z', 'Within 3σ, z', '', 4, ''],
  ['truth_tilt_deg', 'Tilt of the truth', '°', 3, 'of its world; removed before the comparison'],
  ['nees_state', 'NEES, whole state', '', 3, 'pose, velocity and biases: 15 is consistent'],
  ['nis_per_dof', 'NIS per degree of freedom', '', 3, '1 is consistent'],
  ['innovation_correlation', 'Correlation of innovations', '', 3, 'of a pixel’s, with the frame before; 0 if white'],
  ['path_m', 'Path', 'm', 4, 'of the truth'],
  ['duration_s', 'Duration', 's', 4, ''],
  ['recorded_seconds', 'Recorded', 's', 4, 'from the first frame to the last'],
  ['start_seconds', 'First estimate', 's', 3, 'after the first frame'],
  ['frames', 'Frames', '', 0, ''],
  ['frames_not_ok', 'Frames not ok', '', 0, 'by the filter’s own health'],
  ['zupt_frames', 'Zero-velocity updates', '', 0, ''],
  ['dropped_frames', 'Frames dropped', '', 0, 'late, there twice, or without samples near'],
  ['resets', 'Resets', '', 0, 'how often the filter restarted'],
  ['observations', 'Observations', '', 0, 'that the recording offered'],
  ['used', 'Observations used', '', 0, ''],
  ['rejected', 'Observations rejected', '', 0, 'by the χ² gate'],
  ['matched', 'Compared with truth', '', 0, 'stamps'],
  ['landmarks', 'Landmarks', '', 0, 'of the whole map'],
  ['landmarks_matched', 'Landmarks compared', '', 0, 'with true ones'],
  ['landmarks_rmse_m', 'Landmark error', 'm', 3, 'rms'],
  ['landmarks_rmse_aligned_m', 'Landmark error, best fit', 'm', 3, 'rms'],
  ['frontend_ms_per_frame', 'Front end', 'ms', 3, 'a frame'],
  ['filter_ms_per_frame', 'Filter', 'ms', 3, 'a frame'],
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
// What a good value of these is.
const EXPLAINED: Record<string, string> = {
  nees_pose: 'The squared error over the covariance that the filter reports. Good is about 6, one for each degree ' +
    'of freedom. More: the filter is overconfident. Less: it is cautious.',
  nis_per_dof: 'The squared distance of observations from their prediction, over what the filter expects. Good is ' +
    'about 1. More: the noise is larger than it expects. Less: it is smaller.',
};

const allRuns = () => app.subjects as Run[];

function scalarText(v: unknown, digits = 4): string {
  if (v === null || v === undefined) return '–';
  return typeof v === 'number' ? number(v, digits || 9) : String(v);
}

export function showCards(): void {
  const { summary } = activeRun();
  const known = CARDS.filter(([key]) => isNumber(summary[key]));
  const open = new Set([...byId('cards').querySelectorAll<HTMLElement>('details[open]')].map((e) => e.dataset.key));
  byId('cards').replaceChildren(...known.map(([key, label, unit, meaning]) =>
    make('div', { class: 'card' },
      make('div', { class: 'card-label' }, label),
      make('div', { class: 'card-value', tabindex: 0, role: 'note', ...exact(key, summary[key]) },
        scalarText(summary[key], 3), make('span', { class: 'unit' }, unit)),
      meaningOf(key, label, meaning, open.has(key)))));
  byId('cards').hidden = known.length === 0;
}

/** The line below a figure; where there is more to say, it opens by click, touch or key. */
function meaningOf(key: string, label: string, meaning: string, open: boolean): HTMLElement {
  if (!EXPLAINED[key]) return make('div', { class: 'muted small' }, meaning);
  return make('details', { class: 'card-more small', 'data-key': key, ...(open ? { open: '' } : {}) },
    make('summary', { class: 'muted', 'aria-label': `${label}: ${meaning}. What it means` }, meaning),
    make('p', {}, EXPLAINED[key]));
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
    'settings', 'remarks', 'place_in_map'));
  for (const [key, label, unit, digits, meaning] of FIGURES) {
    const values = allRuns().map((r) => r.summary[key]);
    if (values.every((v) => v === undefined || v === null || !isScalar(v))) continue;
    rows.push([label, ...values.map((v) => figureCell(key, v, digits, unit)),
      make('td', { class: 'muted small meaning' }, meaning)]);
  }
  const closures = allRuns().map(closuresOf);
  if (closures.some((list) => list.length)) {
    const figures: [string, (list: Closure[]) => string, string][] = [
      ['Loop closures', (list) => grouped(list.length), 'times at which past landmarks returned'],
      ['Largest jump at a closure', (list) => `${number(Math.max(0, ...list.map((c) => c.moved)), 3)} m`,
        'of the pose']];
    for (const [label, text, meaning] of figures) {
      rows.push([label, ...closures.map((list) => make('td', { class: 'figure' }, text(list))),
        make('td', { class: 'muted small meaning' }, meaning)]);
    }
  }
  const places = allRuns().map(placeText);
  if (places.some(Boolean)) {
    rows.push(['Place in the map', ...places.map((text) => make('td', {}, text || '–')),
      make('td', { class: 'muted small meaning' },
        'rejected: landmarks there were not jointly compatible')]);
  }
  const [alike, others] = [allRuns().length === 1, otherFigures(known)];
  if (!alike) rows.push(...others.map(([label, cells]) => [label, ...cells, make('td', {})]));
  byId('figures').replaceChildren(table(headings(['']), rows),
    alike ? keyTable(others.map(([label, [cell]]) => [label, cell])) : '');
  byId('figures-panel').hidden = rows.length + others.length === 0;
}

/** What else the summaries have, by its name: a cell a run. */
function otherFigures(known: ReadonlySet<string>): [string, HTMLElement[]][] {
  const all = allRuns().map(({ summary }) => leaves(summary, known));
  const keys = [...new Set(all.flatMap((of) => [...of.keys()]))].filter((key) =>
    all.some((of) => (of.get(key) ?? null) !== null));
  return keys.map((key) => [titleCase(key.replaceAll('.', ', ')).replace(/^Imu\b/, 'IMU'),
    all.map((of) => figureCell(key, of.get(key), 5, ''))]);
}

function figureCell(key: string, value: unknown, digits: number, unit: string): HTMLElement {
  const text = scalarText(value, digits);
  return make('td', { class: 'figure', ...exact(key, value) },
    text === '–' || !unit ? text : `${text} ${unit}`);
}

/** {a: {b: 1}} → 'a.b': 1, without the entries of those names. Lists are left out. */
function leaves(value: object, without: ReadonlySet<string>, prefix = ''): Map<string, unknown> {
  const out = new Map<string, unknown>();
  for (const [key, v] of Object.entries(value)) {
    if (without.has(prefix + key) || Array.isArray(v)) continue;
    if (isScalar(v)) out.set(prefix + key, v);
    else for (const [path, leaf] of leaves(v as object, without, `${prefix}${key}.`)) out.set(path, leaf);
  }
  return out;
}

export function showSettings(): void {
  const all = allRuns().map((run) => flattened(run.summary.settings));
  const keys = [...new Set(all.flatMap((s) => Object.keys(s)))];
  const cell = (value: string | undefined) => make('td', { dir: 'auto' }, value ?? '–');
  const same = (key: string) => all.every((s) => s[key] === all[0][key]);
  const rows = keys.filter((key) => !same(key)).map((key) => [key, ...all.map((s) => cell(s[key]))]);
  byId('settings').replaceChildren(rows.length ? table(headings(), rows) : '',
    rows.length ? make('h3', { class: 'alike' }, 'All runs alike') : '',
    keyTable(keys.filter(same).map((key) => [key, cell(all[0][key])])));
  byId('settings-panel').hidden = keys.length === 0;
}

/** Keys and the cells of their values in as many columns as there is room for. */
export function keyTable(entries: [string, HTMLElement][]): HTMLElement {
  return make('table', { class: 'key-table' }, make('tbody', {}, ...entries.map(([key, cell]) =>
    make('tr', {}, make('th', { scope: 'row', dir: 'auto' }, key), cell))));
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
  const stated = isScalar(run.summary.health) && run.summary.health;
  const overall = String(stated || (bad.length ? bad[0][0] : 'ok'));
  badge.textContent = overall === 'ok' ? '✓ healthy' : `⚠ ${overall}`;
  badge.className = 'badge ' + (overall === 'ok' ? 'ok' : overall === 'lost' ? 'lost' : 'degraded');
  badge.title = bad.map(([name, part]) => `${name}: ${percent(part)} of the frames`).join(', ');
}
