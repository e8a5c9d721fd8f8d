// Kleinert & Stilla's figure 3: errors and NEES over time, a line a filter.

const PAPER_LINE = 14;

// There are fewer plots than on a run's page, with more lines in each.
panelHeight = 150;

/** A line for each filter that is drawn. */
function filterSeries(column) {
  return shownFilters().map((k) => ({
    label: activeRun().filters[k].label, name: activeRun().filters[k].label, legend: false,
    style: 'line', values: activeRun().filters[k][column], colour: filterColour(k),
    dash: filterDash(k),
  }));
}

function studyErrorPanel(column, unit) {
  return { label: '', unit, zero: true, series: filterSeries(column) };
}

/** NEES with its band; logarithmic where a filter leaves the band by far. */
function studyNeesPanel(column, dof, line) {
  const { bands } = activeRun();
  const low = bands[`chi2_${dof}_low`], high = bands[`chi2_${dof}_high`];
  const lines = filterSeries(column);
  const band = { label: '95 % band', style: 'band', low, high, colour: 'good' };
  const level = { label: `${PAPER_LINE}: the paper’s line`, style: 'level', values: PAPER_LINE,
    colour: 'bad' };
  return {
    label: '', zero: true, floor: dof / 100, clip: true,
    log: lines.some((s) => leavesFar(s.values, Math.max(high, line ? PAPER_LINE : 0))),
    summary: `expected ${dof}, 95 % within ${number(low)} … ${number(high)}`,
    series: [band, ...lines, ...(line ? [level] : [])],
  };
}

const leavesFar = (values, high) => quantile(values, 0.98) > 4 * high;

function bandCaption() {
  const { runs } = activeRun().bands;
  return runs === 1 ? 'The band holds 95 % of the frames of a consistent filter.'
    : `The band is that of the mean over ${grouped(runs)} runs at one instant.`;
}

/** At the start the covariance is nearly singular and the NEES means little. */
function clipCaption(column) {
  const spiky = activeRun().filters.some((f) => quantile(f[column], 1) > 3 * quantile(f[column], 0.99));
  return spiky ? ' Single spikes, as at the start, may be cut off.' : '';
}

const LINE_CAPTION = ` The dashed line is that of Kleinert & Stilla’s figure 3: ${PAPER_LINE}, which a ` +
  'consistent filter’s single run passes in 3 frames of 1000 (7.8: in 50).';

const STUDY_PLOTS = [
  { title: 'Position error', panels: () => [studyErrorPanel('position_error', 'm')],
    caption: () => 'Distance from the true position.' },
  { title: 'Attitude error', panels: () => [studyErrorPanel('attitude_error', '°')],
    caption: () => 'Angle of the rotation from the true attitude.' },
  { title: 'NEES of the position', panels: () => [studyNeesPanel('nees_position', 3, true)],
    caption: () => bandCaption() + LINE_CAPTION },
  { title: 'NEES of the attitude', panels: () => [studyNeesPanel('nees_attitude', 3, true)],
    caption: () => bandCaption() + LINE_CAPTION },
  { title: 'NEES of the pose', panels: () => [studyNeesPanel('nees_pose', 6, false)],
    caption: () => `Position and attitude together. ${bandCaption()}${clipCaption('nees_pose')}` },
  { title: 'NEES of the state', column: 'nees_state',
    panels: () => [studyNeesPanel('nees_state', 15, false)],
    caption: () => `Pose, velocity and biases together. ${bandCaption()}${clipCaption('nees_state')}` },
];

function plotsOfStudy(study) {
  const known = ({ column }) => !column || study.filters.some((f) => f[column].some(Number.isFinite));
  return STUDY_PLOTS.filter(known).map((make_) => {
    const plot = new TimePlot({ title: make_.title, caption: make_.caption(), panels: make_.panels(),
      key: filterKey() });
    plot.panelsNow = make_.panels;
    return plot;
  });
}

function showStudyPlots(study) {
  app.plots = plotsOfStudy(study);
  byId('plots').replaceChildren(...app.plots.map((plot) => plot.element));
}

/** After another choice of filters. */
function refreshPlots() {
  for (const plot of app.plots || []) {
    plot.spec.panels = plot.panelsNow();
    plot.spec.key = filterKey();
    plot.draw();
  }
}
