// Starts the page of a study: reads the data, builds the parts, keeps them together.

/** A study as the page uses it: what the plots need of a run, and the filters. */
function decodeStudy(raw) {
  const summary = raw.summary || {};
  const seconds = column(raw.seconds);
  const name = typeof summary.name === 'string' && summary.name ? summary.name : raw.folder;
  return {
    name, folder: raw.folder, summary, single: raw.single_run, bands: raw.bands, origin: raw.origin,
    count: seconds.length,
    states: { t: seconds, health: new Int32Array(seconds.length) }, healthNames: ['ok'],
    filters: raw.filters.map((f, k) => decodeFilter(f, summary.filters[k], k)),
    shown: raw.filters.map(() => true),
    trials: decodeColumns(raw.trials),
    truth: raw.truth ? decodeColumns(raw.truth) : null,
    landmarks: raw.landmarks ? decodeColumns(raw.landmarks) : { x: [], y: [], z: [] },
  };
}

function decodeFilter({ name, estimate, ...columns }, figures, k) {
  const label = name.length > 60 ? `${k + 1}: ${name.slice(0, 56)}…` : name;
  return { label, figures, estimate: decodeColumns(estimate), ...decodeColumns(columns) };
}

function showStudyLine(study) {
  const s = study.summary, t = study.states.t;
  const parts = [study.single ? 'one run' : `${grouped(s.runs)} runs`,
    `${grouped(study.filters.length)} filter${study.filters.length === 1 ? '' : 's'}`,
    isNumber(s.seed) && `seed ${s.seed}`, t.length > 1 && `${number(t[t.length - 1])} s`,
    study.folder];
  byId('run-line').textContent = parts.filter(Boolean).join('  ·  ');
  byId('run-name').textContent = study.name;
  byId('run-name').title = study.name;
  document.title = `${study.label} – Chasles`;
  byId('version').textContent = `Chasles${isScalar(s.version) && s.version ? ' ' + s.version : ''}.`;
  byId('plots-help').hidden = t.length < 2;
}

function showDiverged(study) {
  const badge = byId('health-badge');
  const count = study.filters.reduce((n, f) => n + (f.figures.diverged > 0 ? f.figures.diverged : 0), 0);
  badge.textContent = count ? `⚠ ${grouped(count)} diverged` : '✓ none diverged';
  badge.className = 'badge ' + (count ? 'degraded' : 'ok');
}

function labelStudies(studies) {
  studies.forEach((study, k) => {
    const short = study.name.length > 40 ? study.name.slice(0, 39) + '…' : study.name;
    study.label = studies.length > 1 ? `${k + 1}: ${short}` : short;
  });
}

function startStudyPicker() {
  const select = byId('run-select');
  select.replaceChildren(...app.runs.map((study, k) => make('option', { value: k }, study.label)));
  byId('run-picker').hidden = app.runs.length < 2;
  select.addEventListener('change', () => setRun(Number(select.value)));
}

function start() {
  app.runs = JSON.parse(byId('report-data').textContent).studies.map(decodeStudy);
  labelStudies(app.runs);
  startTheme();
  startStudyPicker();
  startFilterButtons();
  new StudyMap();
  listen('run', () => {
    const study = activeRun();
    for (const show of [showStudyLine, showDiverged, showStudyCards, showStudyTables, showStudyPlots,
      showBoxes, showOutliers, showScene, showFilterSettings, showStudyRemarks]) show(study);
    showFilterLegend();
  });
  listen('shown', () => {
    refreshPlots();
    for (const plot of app.boxes) plot.draw();
  });
  for (const kind of ['cursor', 'span', 'theme']) {
    listen(kind, () => (app.plots || []).forEach((plot) => plot.draw()));
  }
  listen('theme', () => (app.boxes || []).forEach((plot) => plot.draw()));
  listen('print', () => [...app.plots, ...app.boxes].forEach((plot) => plot.drawNow()));
  listen('span', () => {
    byId('zoom-reset').hidden = app.span[0] <= app.fullSpan[0] && app.span[1] >= app.fullSpan[1];
  });
  byId('zoom-reset').addEventListener('click', () => setSpan(...app.fullSpan));
  setRun(0);
}

start();
