// Starts the page: reads the data, builds the parts, keeps them together.

function showRunLine(run) {
  const s = run.summary;
  const t = run.states.t, length = pathLength(run.states);
  const chart = chartOf(run), settings = s.settings || {};
  const mode = [settings.mode, s.mode].find((v) => typeof v === 'string');
  const parts = [mode, chart && `chart ${chart}`, `${grouped(run.count)} frames`,
    t.length > 1 && `${number(t[t.length - 1])} s`, `${number(length)} m`,
    `${grouped(run.landmarks.id.length)} landmarks`];
  byId('run-line').textContent = parts.filter(Boolean).join('  ·  ');
  byId('run-name').textContent = run.name || 'Chasles';
  byId('run-name').title = run.name;
  document.title = `${run.label} – Chasles`;
  const version = isScalar(s.version) && s.version ? ` ${s.version}` : '';
  byId('version').textContent = `Chasles${version}.`;
}

function pathLength({ x, y, z }) {
  let sum = 0;
  for (let i = 1; i < x.length; i++) {
    const step = Math.hypot(x[i] - x[i - 1], y[i] - y[i - 1], z[i] - z[i - 1]);
    if (Number.isFinite(step)) sum += step;
  }
  return sum;
}

function showPlots(run) {
  app.plots = [...overviewPlots(), ...plotSpecs(run)].map((spec) => new TimePlot(spec));
  byId('plots').replaceChildren(...inColumns(app.plots));
  byId('health-key').hidden = !run.states.health.some((h) => run.healthNames[h] !== 'ok');
}

/** Two columns of about the same height; on a narrow screen `order` makes one of them again. */
function inColumns(plots) {
  const columns = [0, 1].map(() => ({ height: 0, element: make('div', { class: 'column' }) }));
  plots.forEach((plot, k) => {
    const shorter = columns[1].height < columns[0].height ? columns[1] : columns[0];
    // Heading, legend and caption take about as much as a panel and a half.
    shorter.height += plot.spec.panels.length + 1.5;
    plot.element.style.order = k;
    shorter.element.append(plot.element);
  });
  return columns.map((column) => column.element);
}

/** The numbers at the time cursor, beside the map. */
function showAtTime() {
  const run = activeRun(), i = app.cursor, s = run.states;
  const slider = byId('time');
  slider.max = Math.max(0, run.count - 1);
  slider.value = i;
  if (!run.count) return;
  slider.setAttribute('aria-valuetext', `${fixed(s.t[i], 2)} seconds`);
  byId('time-text').textContent = `${fixed(s.t[i], 2)} s`;
  const rows = atTimeRows(run, i).flatMap(([label, text]) =>
    [make('dt', {}, label), make('dd', {}, text)]);
  byId('at-time').replaceChildren(...rows);
}

function atTimeRows(run, i) {
  const s = run.states, e = run.errors, { yaw, pitch, roll } = run.euler;
  const triple = (values, decimals) => values.map((v) => fixed(v, decimals)).join(', ');
  const rows = [
    ['Time', `${fixed(s.t[i], 2)} s, frame ${i + 1} of ${run.count}`],
    ['Position', `${triple(AXES.map((a, k) => s[a][i] + run.origin[k]), 2)} m`],
    ['±3σ', `${triple(AXES.map((a) => 3 * s['sigma_p' + a][i]), 2)} m`],
    ['Yaw, pitch, roll', `${triple([yaw[i], pitch[i], roll[i]], 1)}°`],
  ];
  if (e && Number.isFinite(e.position_x[i])) {
    rows.push(['Position error', `${triple(AXES.map((a) => e['position_' + a][i]), 2)} m`]);
    rows.push(['NEES of the pose', number(e.nees_pose[i])]);
  }
  const dof = s.nis_dof[i];
  rows.push(['NIS / dof', dof > 0 ? `${number(s.nis[i] / dof)} (${dof} dof)` : '–'],
    ['Observations', `${s.used[i]} used, ${s.rejected[i]} refused of ${s.observations[i]}`],
    ['Landmarks', `${s.in_state[i]} in the state, ${grouped(s.landmarks[i])} in all`],
    ['Health', run.healthNames[s.health[i]] || '–']);
  if (s.milliseconds[i] > 0) rows.push(['Time taken', `${number(s.milliseconds[i])} ms`]);
  return rows;
}

function startPlayer() {
  const button = byId('play');
  let timer = null;
  const stop = () => {
    clearInterval(timer);
    timer = null;
    button.textContent = '▶';
    button.setAttribute('aria-label', 'Play');
  };
  const start = () => {
    if (app.cursor >= activeRun().count - 1) setCursor(0);
    button.textContent = '❚❚';
    button.setAttribute('aria-label', 'Pause');
    // The whole run in about 20 seconds.
    const stride = Math.max(1, Math.round(activeRun().count / 600));
    timer = setInterval(() => {
      setCursor(app.cursor + stride);
      if (app.cursor >= activeRun().count - 1) stop();
    }, 33);
  };
  button.addEventListener('click', () => (timer ? stop() : start()));
  byId('time').addEventListener('input', (e) => setCursor(Number(e.target.value)));
}

function startRunPicker() {
  const select = byId('run-select');
  select.replaceChildren(...app.runs.map((run, k) => make('option', { value: k }, run.label)));
  byId('run-picker').hidden = app.runs.length < 2;
  select.addEventListener('change', () => setRun(Number(select.value)));
}

function readData() {
  const data = JSON.parse(byId('report-data').textContent);
  app.runs = data.runs.map(decodeRun);
  for (const run of app.runs) run.bounds = data.bounds;
  app.scenes = (data.scenes || []).map(decodeScene);
  labelRuns(app.runs);
  colourRuns(app.runs);
}

function start() {
  readData();
  startTheme();
  startRunPicker();
  startPlayer();
  new Overview();
  new MapPanel();
  showFigures();
  showSettings();
  listen('run', () => {
    const run = activeRun();
    for (const show of [showRunLine, showCards, showRemarks, showHealth, showPlots]) show(run);
  });
  listen('cursor', throttled(showAtTime));
  for (const kind of ['cursor', 'span', 'theme']) {
    listen(kind, () => (app.plots || []).forEach((plot) => plot.draw()));
  }
  listen('print', () => app.plots.forEach((plot) => plot.drawNow()));
  listen('span', () => {
    byId('zoom-reset').hidden = app.span[0] <= app.fullSpan[0] && app.span[1] >= app.fullSpan[1];
  });
  byId('zoom-reset').addEventListener('click', () => setSpan(...app.fullSpan));
  setRun(0);
}

start();
