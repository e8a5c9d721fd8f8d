// Cards, tables I and II, outliers, settings: all that is words and single numbers.

const DEGREES_OF_POSE = 6, DEGREES_OF_STATE = 15;
const isNumber = (v) => typeof v === 'number' && Number.isFinite(v);
const isScalar = (v) => v === null || ['number', 'string', 'boolean'].includes(typeof v);

/** The figures of the study's filters as summary.json has them. */
const figuresOf = (study) => study.filters.map((f) => f.figures);

/** Index of the filter whose value is least; −1 where none has one. */
function leastOf(study, value) {
  let best = -1;
  figuresOf(study).forEach((f, k) => {
    const v = value(f);
    if (Number.isFinite(v) && !(best >= 0 && value(figuresOf(study)[best]) <= v)) best = k;
  });
  return best;
}

const distanceFromConsistent = (f) =>
  isNumber(f.nees_pose_per_dof) ? Math.abs(Math.log(f.nees_pose_per_dof)) : NaN;
const positionError = (f) => (isNumber(f.position_error_m) ? f.position_error_m : NaN);

function card(label, value, unit, meaning) {
  return make('div', { class: 'card' }, make('div', { class: 'card-label' }, label),
    make('div', { class: 'card-value' }, value, make('span', { class: 'unit' }, unit)),
    make('div', { class: 'muted small', dir: 'auto' }, meaning));
}

function showStudyCards(study) {
  const figures = figuresOf(study);
  const sum = (key) => figures.reduce((a, f) => a + (isNumber(f[key]) ? f[key] : 0), 0);
  const cards = [study.single
    ? card('Frames', grouped(study.count), '', `run ${number(study.summary.run)} of the noise`)
    : card('Runs', grouped(study.summary.runs), '', 'of each filter, on the same noise')];
  const consistent = leastOf(study, distanceFromConsistent), precise = leastOf(study, positionError);
  if (consistent >= 0) {
    cards.push(card('Nearest to consistent', number(figures[consistent].nees_pose_per_dof), '',
      `pose NEES per degree of freedom of ${study.filters[consistent].label}`));
  }
  if (precise >= 0) {
    cards.push(card('Smallest position error', number(figures[precise].position_error_m), 'm',
      `mean of ${study.filters[precise].label}`));
  }
  cards.push(card('Diverged', grouped(sum('diverged')), '', `of ${grouped(sum('runs'))} trials`));
  byId('cards').replaceChildren(...cards);
}

/** A column of a table: heading, text of a filter's figures, and what its cell looks like. */
const textColumn = (heading, text, look = () => '') => ({ heading, text, look });
const numberColumn = (heading, value, digits, look) =>
  textColumn(heading, (f) => (isNumber(value(f)) ? fixed(value(f), digits) : '–'), look);

const isInside = (f) => Array.isArray(f.band) && f.nees_pose_per_dof >= f.band[0] &&
  f.nees_pose_per_dof <= f.band[1];

function neesLook(f) {
  if (!isNumber(f.nees_pose_per_dof) || !Array.isArray(f.band)) return '';
  return isInside(f) ? 'inside' : f.nees_pose_per_dof > f.band[1] ? 'outside' : '';
}

const any = (study, key) => figuresOf(study).some((f) => isNumber(f[key]));
const medianOf = (f, key) => (f.median ? f.median[key] : NaN);
const onlyIf = (condition, ...columns) => (condition ? columns : []);

function neesColumns(study) {
  return [
    numberColumn('position', (f) => f.nees_position, 2),
    numberColumn('attitude', (f) => f.nees_attitude, 2),
    textColumn('pose / dof', (f) => (isNumber(f.nees_pose_per_dof)
      ? fixed(f.nees_pose_per_dof, 3) + (isInside(f) ? ' ✓' : '') : '–'), neesLook),
    textColumn('95 % band', (f) => (Array.isArray(f.band)
      ? `${fixed(f.band[0], 3)} … ${fixed(f.band[1], 3)}` : '–')),
    ...onlyIf(!study.single,
      numberColumn('median', (f) => medianOf(f, 'nees_pose') / DEGREES_OF_POSE, 3),
      textColumn('seconds inside', (f) => percent(f.seconds_inside_band ?? NaN))),
    ...onlyIf(any(study, 'nees_state'),
      numberColumn('state / dof', (f) => f.nees_state / DEGREES_OF_STATE, 3)),
    numberColumn('NIS / dof', (f) => f.nis_per_dof, 3),
    ...onlyIf(any(study, 'innovation_correlation'),
      numberColumn('innovation correlation', (f) => f.innovation_correlation, 3)),
    ...onlyIf(!study.single, textColumn('runs', (f) => grouped(f.runs)),
      textColumn('diverged', (f) => grouped(f.diverged), (f) => (f.diverged > 0 ? 'outside' : ''))),
    ...onlyIf(study.single, textColumn('health', (f) => (f.diverged > 0 ? 'diverged' : 'ok'),
      (f) => (f.diverged > 0 ? 'outside' : ''))),
  ];
}

function errorColumns(study) {
  const best = leastOf(study, positionError);
  const look = (f) => (best >= 0 && f === figuresOf(study)[best] ? 'best' : '');
  return [
    numberColumn('position [m]', (f) => f.position_error_m, 4, look),
    numberColumn('attitude [°]', (f) => f.attitude_error_deg, 3),
    ...onlyIf(!study.single, numberColumn('median [m]', (f) => medianOf(f, 'position_error_m'), 4),
      numberColumn('median [°]', (f) => medianOf(f, 'attitude_error_deg'), 3)),
    numberColumn('position rms [m]', (f) => f.position_rms_m, 4),
    ...onlyIf(any(study, 'ate_posyaw_m'),
      numberColumn('ATE, yaw aligned [m]', (f) => f.ate_posyaw_m, 4)),
    numberColumn('landmarks', (f) => f.landmarks, 0),
  ];
}

function filterTable(study, columns) {
  const head = make('tr', {}, make('th', { scope: 'col', style: 'text-align: left' }, 'filter'),
    ...columns.map((c) => make('th', { scope: 'col' }, c.heading)));
  const rows = study.filters.map(({ figures }, k) => make('tr', {},
    make('th', { scope: 'row' }, filterName(k)),
    ...columns.map((c) => make('td', { class: c.look(figures) }, c.text(figures)))));
  return make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows));
}

function showStudyTables(study) {
  byId('nees-table').replaceChildren(filterTable(study, neesColumns(study)));
  byId('error-table').replaceChildren(filterTable(study, errorColumns(study)));
  const over = study.single ? 'its frames' : 'the frames and the runs that did not diverge';
  byId('nees-caption').textContent = 'Squared error over the covariance that the filter reports, ' +
    `averaged over ${over}, in the coordinates of the filter’s chart: 3 for position and attitude and ` +
    '1 per degree of freedom when it is consistent; a pose NEES of 4 per degree of freedom says ' +
    'that the covariance is 4 times too small. ' + (study.single
      ? 'The band holds the value of a single frame with 95 % probability; ✓ is inside.'
      : 'The band holds the mean of so many runs at one instant with 95 % probability; ✓ is inside.');
  byId('error-caption').textContent = `Means over ${over}. Nothing is aligned: the filter begins at ` +
    'the true pose.';
}

function showScene(study) {
  const entries = Object.entries(flattened(study.summary.scene || {}));
  byId('scene').replaceChildren(keyTable(entries));
  byId('scene-panel').hidden = entries.length === 0;
}

/** What differs among the filters, a row each; below it what they have in common. */
function showFilterSettings(study) {
  const all = figuresOf(study).map((f) => flattened(f.settings));
  const keys = [...new Set(all.flatMap((s) => Object.keys(s)))];
  const text = (s, key) => (s[key] === undefined ? '–' : s[key]);
  const same = (key) => all.every((s) => text(s, key) === text(all[0], key));
  const different = keys.filter((key) => !same(key)), common = keys.filter(same);
  const head = make('tr', {}, make('th', { scope: 'col' }, 'filter'),
    ...different.map((key) => make('th', { scope: 'col', dir: 'auto' }, key)));
  const rows = all.map((s, k) => make('tr', {}, make('th', { scope: 'row' }, filterName(k)),
    ...different.map((key) => make('td', { dir: 'auto' }, text(s, key)))));
  byId('settings').replaceChildren(different.length
    ? make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows)) : '');
  byId('common').replaceChildren(keyTable(common.map((key) => [key, text(all[0], key)])));
  byId('common-title').textContent = study.filters.length > 1 ? 'All filters alike' : '';
  byId('settings-panel').hidden = keys.length === 0;
}

function keyTable(entries) {
  return make('table', { class: 'key-table' }, make('tbody', {}, ...entries.map(([key, value]) =>
    make('tr', {}, make('th', { scope: 'row', dir: 'auto' }, key), make('td', { dir: 'auto' }, value)))));
}

function showStudyRemarks(study) {
  const remarks = [].concat(study.summary.remarks || []).map(plainText);
  byId('remarks').replaceChildren(make('ul', {}, ...remarks.map((r) => make('li', { dir: 'auto' }, r))));
  byId('remarks-panel').hidden = remarks.length === 0;
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
