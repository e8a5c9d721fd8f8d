// Key figures, tables, settings and remarks: all that is words and single numbers.

// [key of summary.json, label, unit, digits, what it means]
const FIGURES = [
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
const CARDS = [
  ['ate_m', 'ATE', 'm', 'rms position, best fit'],
  ['rpe_100m_percent', 'Drift', '%', 'over 100 m'],
  ['attitude_deg', 'Attitude', '°', 'rms angle, best fit'],
  ['nees_pose', 'Pose NEES', '', '6 is consistent'],
  ['nis_per_dof', 'NIS / dof', '', '1 is consistent'],
  ['landmarks', 'Landmarks', '', 'of the whole map'],
  ['frames', 'Frames', '', 'estimated'],
  ['realtime_factor', 'Speed', '×', 'real time'],
];

const isScalar = (v) => v === null || ['number', 'string', 'boolean'].includes(typeof v);

function scalarText(v, digits = 4) {
  if (v === null || v === undefined) return '–';
  return typeof v === 'number' ? number(v, digits || 9) : String(v);
}

function showCards(run) {
  const known = CARDS.filter(([key]) => Number.isFinite(run.summary[key]));
  byId('cards').replaceChildren(...known.map(([key, label, unit, meaning]) =>
    make('div', { class: 'card' },
      make('div', { class: 'card-label' }, label),
      make('div', { class: 'card-value' }, scalarText(run.summary[key], 3),
        make('span', { class: 'unit' }, unit)),
      make('div', { class: 'muted small' }, meaning))));
  byId('cards').hidden = known.length === 0;
}

function table(headings, rows) {
  return make('table', {},
    headings ? make('thead', {}, make('tr', {}, ...headings.map((h, k) =>
      make(k ? 'th' : 'td', k ? { scope: 'col', dir: 'auto' } : {}, h)))) : null,
    make('tbody', {}, ...rows.map(([name, ...cells]) =>
      make('tr', {}, make('th', { scope: 'row', dir: 'auto' }, name), ...cells))));
}

function headings(extra = []) {
  return app.runs.length > 1 ? ['', ...app.runs.map((r) => r.label), ...extra] : null;
}

function showFigures() {
  const rows = [];
  const known = new Set(FIGURES.map((f) => f[0]).concat('version', 'name', 'mode', 'chart', 'settings', 'remarks'));
  for (const [key, label, unit, digits, meaning] of FIGURES) {
    const values = app.runs.map((r) => r.summary[key]);
    if (values.every((v) => v === undefined || !isScalar(v))) continue;
    rows.push([label, ...values.map((v) => figureCell(v, digits, unit)),
      make('td', { class: 'muted small meaning' }, meaning)]);
  }
  for (const key of keysOf((r) => r.summary)) {
    const values = app.runs.map((r) => r.summary[key]);
    if (known.has(key) || values.some((v) => v !== undefined && !isScalar(v))) continue;
    rows.push([titleCase(key), ...values.map((v) => figureCell(v, 5, '')),
      make('td', {})]);
  }
  byId('figures').replaceChildren(table(headings(['']), rows));
  byId('figures-panel').hidden = rows.length === 0;
}

function figureCell(value, digits, unit) {
  const text = scalarText(value, digits);
  return make('td', { class: 'figure' }, text === '–' || !unit ? text : `${text} ${unit}`);
}

/** The keys of all runs' objects, each once, in their order. */
function keysOf(pick) {
  return [...new Set(app.runs.flatMap((r) => Object.keys(pick(r) || {})))];
}

/** {a: {b: 1}} → {'a.b': '1'}; lists become text. */
function flattened(value, prefix = '', out = {}) {
  for (const [key, v] of Object.entries(value || {})) {
    const path = prefix ? prefix + '.' + key : key;
    if (v && typeof v === 'object' && !Array.isArray(v)) flattened(v, path, out);
    else out[path] = Array.isArray(v) ? v.map(plainText).join(', ') : plainText(v);
  }
  return out;
}

/** A setting as it was given: no rounding, no grouping. */
function plainText(v) {
  if (v === null || v === undefined) return '–';
  return typeof v === 'object' ? JSON.stringify(v) : String(v);
}

/** Settings, and any other object that the summary holds. */
function settingsOf(run) {
  const others = Object.entries(run.summary).filter(([key, v]) =>
    key !== 'settings' && key !== 'remarks' && !isScalar(v));
  return { ...flattened(run.summary.settings), ...flattened(Object.fromEntries(others)) };
}

function showSettings() {
  const all = app.runs.map(settingsOf);
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

function remarksOf(run) {
  const remarks = [].concat(run.summary.remarks || []).map(plainText);
  if (run.truthProblem) remarks.push(`The truth could not be compared: ${run.truthProblem}`);
  if (run.landmarksLeftOut) {
    remarks.push(`${grouped(run.landmarksLeftOut)} landmarks are not finite and not drawn.`);
  }
  return remarks;
}

function showRemarks(run) {
  const remarks = remarksOf(run);
  byId('remarks').replaceChildren(make('ul', {},
    ...remarks.map((r) => make('li', { dir: 'auto' }, r))));
  byId('remarks-panel').hidden = remarks.length === 0;
}

/** ok, or how long the filter was not. */
function showHealth(run) {
  const share = run.healthNames.map((name, k) => [name,
    run.states.health.reduce((n, h) => n + (h === k ? 1 : 0), 0) / Math.max(1, run.count)]);
  const bad = share.filter(([name, part]) => name !== 'ok' && part > 0);
  const badge = byId('health-badge');
  const told = isScalar(run.summary.health) && run.summary.health;
  const overall = String(told || (bad.length ? bad[0][0] : 'ok'));
  badge.textContent = overall === 'ok' ? '✓ healthy' : `⚠ ${overall}`;
  badge.className = 'badge ' + (overall === 'ok' ? 'ok' : overall === 'lost' ? 'lost' : 'degraded');
  badge.title = bad.map(([name, part]) => `${name}: ${percent(part)} of the frames`).join(', ');
}
