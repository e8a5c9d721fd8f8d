// The line below the name, and the numbers at the time cursor.
import { AXES, type Columns } from './data';
import { byId, fixed, grouped, isScalar, make, number, setText } from './format';
import { activeRun, chartOf, type Run } from './runs';
import { app, setActive } from './store';

export function showRunLine(): void {
  const run = activeRun(), s = run.summary, { t } = run;
  const chart = chartOf(run), settings = (s.settings ?? {}) as Record<string, unknown>;
  const mode = [settings.mode, s.mode].find((v) => typeof v === 'string');
  const parts = [mode, chart && `chart ${chart}`, `${grouped(run.count)} frames`,
    t.length > 1 && `${number(t[t.length - 1])} s`, `${number(pathLength(run.states))} m`,
    `${grouped(run.landmarks.id.length)} landmarks${run.savedMap ? ' beside those of the map' : ''}`];
  byId('run-line').textContent = parts.filter(Boolean).join('  ·  ');
  byId('run-name').textContent = run.name || 'Chasles';
  byId('run-name').title = run.name;
  document.title = `${run.label} – Chasles`;
  const version = isScalar(s.version) && s.version ? ` ${s.version}` : '';
  byId('version').textContent = `Chasles${version}.`;
}

function pathLength({ x, y, z }: Columns): number {
  let sum = 0;
  for (let i = 1; i < x.length; i++) {
    const step = Math.hypot(x[i] - x[i - 1], y[i] - y[i - 1], z[i] - z[i - 1]);
    if (Number.isFinite(step)) sum += step;
  }
  return sum;
}

export function showAtTime(): void {
  const run = activeRun(), i = app.cursor, { t } = run;
  const slider = byId<HTMLInputElement>('time');
  slider.max = String(Math.max(0, run.count - 1));
  slider.value = String(i);
  if (!run.count) return;
  slider.setAttribute('aria-valuetext', `${fixed(t[i], 2)} seconds`);
  byId('time-text').textContent = `${fixed(t[i], 2)} s`;
  show(byId('at-time'), atTimeRows(run, i));
}

/** Puts rows of a label and a text into a list; as long as the labels stay only texts change. */
function show(list: HTMLElement, rows: [string, string][]): void {
  const held = [...list.children];
  if (held.length !== 2 * rows.length || rows.some(([label], k) => held[2 * k].textContent !== label)) {
    list.replaceChildren(...rows.flatMap(([label, text]) =>
      [make('dt', {}, label), make('dd', {}, text)]));
    return;
  }
  rows.forEach(([, text], k) => setText(held[2 * k + 1], text));
}

function atTimeRows(run: Run, i: number): [string, string][] {
  const s = run.states, e = run.errors, { yaw, pitch, roll } = run.euler;
  const triple = (values: number[], decimals: number) =>
    values.map((v) => fixed(v, decimals)).join(', ');
  // What is a few millimetres, or less, is shown more exactly.
  const metres = (values: number[]) =>
    `${triple(values, Math.max(...values.map(Math.abs)) < 0.1 ? 4 : 2)} m`;
  const rows: [string, string][] = [
    ['Time', `${fixed(s.t[i], 2)} s, frame ${i + 1} of ${run.count}`],
    ['Position', `${triple(AXES.map((a, k) => s[a][i] + run.origin[k]), 2)} m`],
    ['±3σ', metres(AXES.map((a) => 3 * s['sigma_p' + a][i]))],
    ['Yaw, pitch, roll', `${triple([yaw[i], pitch[i], roll[i]], 1)}°`],
  ];
  if (e && Number.isFinite(e.position_x[i])) {
    rows.push(['Position error', metres(AXES.map((a) => e['position_' + a][i]))]);
    rows.push(['NEES of the pose', number(e.nees_pose[i])]);
  }
  const dof = s.nis_dof[i];
  rows.push(['NIS / dof', dof > 0 ? `${number(s.nis[i] / dof)} (${dof} dof)` : '–'],
    ['Observations', `${s.used[i]} used, ${s.rejected[i]} rejected of ${s.observations[i]}`],
    ['Landmarks', `${s.in_state[i]} in the state, ${grouped(s.landmarks[i])} in all`],
    ['Health', run.healthNames[s.health[i]] || '–']);
  if (s.milliseconds[i] > 0) rows.push(['Time taken', `${number(s.milliseconds[i])} ms`]);
  return rows;
}

/** The choice among several runs or studies. */
export function showPicker(): void {
  byId('run-select').replaceChildren(
    ...app.subjects.map(({ label }, k) => make('option', { value: k }, label)));
  byId('run-picker').hidden = app.subjects.length < 2;
}

export function startPicker(): void {
  const select = byId<HTMLSelectElement>('run-select');
  showPicker();
  select.addEventListener('change', () => setActive(Number(select.value)));
}
