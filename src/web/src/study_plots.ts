// Kleinert & Stilla's figures 2 and 3, (b) and (c): errors and NEES over time, a line a filter.
import { extremes, quantile } from './data';
import { grouped, number } from './format';
import type { TimePlot } from './plot';
import { showPlots, timePlots } from './plot_list';
import type { Panel, PlotSpec, Series } from './plot_spec';
import { activeStudy, partTitle } from './studies';
import { filterColour, filterDash, filterKey, shownFilters } from './study_colours';

const PAPER_LINE = 14;

// There are fewer plots than on a run's page, with more lines in each.
const PANEL_HEIGHT = 150;

/** A line for each filter that is drawn; `part` distinguishes the panels of a plot. */
function filterSeries(column: string, part: string): Series[] {
  return shownFilters().map((k) => {
    const { label, curves } = activeStudy().filters[k];
    return { label, name: part ? `${label}, ${part}:` : label, legend: false, style: 'line',
      values: curves[column], colour: filterColour(k), dash: filterDash(k) };
  });
}

function studyErrorPanel(column: string, part: string, unit: string): Panel {
  return { label: part, unit, zero: true, series: filterSeries(column, part) };
}

/** NEES with its band; logarithmic where a filter leaves the band by far. */
function studyNeesPanel(column: string, dof: number, part = ''): Panel {
  const { bands } = activeStudy();
  const low = bands[`chi2_${dof}_low`], high = bands[`chi2_${dof}_high`];
  const lines = filterSeries(column, part), line = part !== '';
  const band: Series = { label: '95 % band', style: 'band', low, high, colour: 'good' };
  const level: Series = { label: `${PAPER_LINE}: the paper’s threshold`, style: 'level', values: PAPER_LINE,
    colour: 'ink' };
  return {
    label: part, zero: true, floor: dof / 100, clip: true,
    log: lines.some((s) => typeof s.values === 'object' &&
      leavesFar(s.values, Math.max(high, line ? PAPER_LINE : 0))),
    summary: `expected ${dof}, 95 % within ${number(low)} … ${number(high)}`,
    series: [band, ...lines, ...(line ? [level] : [])],
  };
}

const leavesFar = (values: ArrayLike<number>, high: number) => quantile(values, 0.98) > 4 * high;

function bandCaption(): string {
  const { runs } = activeStudy().bands;
  return runs === 1 ? 'The band holds 95 % of the frames of a consistent filter.'
    : `The band is that of the mean over ${grouped(runs)} runs at one instant.`;
}

/** At the start the covariance is nearly singular and the NEES means little. */
function clipCaption(column: string): string {
  const spiky = activeStudy().filters.some(({ curves }) =>
    extremes(curves[column])[1] > 3 * quantile(curves[column], 0.99));
  return spiky ? ' Single spikes, as at the start, may be cut off.' : '';
}

const LINE_CAPTION = ` The dashed line is the paper’s threshold of ${PAPER_LINE}, which a ` +
  'consistent filter’s single run passes in 3 frames of 1000 (7.8: in 50).';

interface StudyPlot { title: () => string; column?: string; panels: () => Panel[]; caption: () => string }

// The attitude is above the position, as in the paper.
const STUDY_PLOTS: StudyPlot[] = [
  { title: () => partTitle(activeStudy(), 'b', 'Attitude and position error'),
    panels: () => [studyErrorPanel('attitude_error', 'attitude', '°'),
      studyErrorPanel('position_error', 'position', 'm')],
    caption: () => 'Angle of the rotation from the true attitude; distance from the true position.' },
  { title: () => partTitle(activeStudy(), 'c', 'NEES of attitude and position'),
    panels: () => [studyNeesPanel('nees_attitude', 3, 'attitude'),
      studyNeesPanel('nees_position', 3, 'position')],
    caption: () => bandCaption() + LINE_CAPTION },
  { title: () => 'NEES of the pose', panels: () => [studyNeesPanel('nees_pose', 6)],
    caption: () => `Position and attitude together. ${bandCaption()}${clipCaption('nees_pose')}` },
  { title: () => 'NEES of the state', column: 'nees_state', panels: () => [studyNeesPanel('nees_state', 15)],
    caption: () => `Pose, velocity and biases together. ${bandCaption()}${clipCaption('nees_state')}` },
];

const knownPlots = (): StudyPlot[] => STUDY_PLOTS.filter(({ column }) => !column ||
  activeStudy().filters.some(({ curves }) => curves[column].some(Number.isFinite)));

export function showStudyPlots(): void {
  const specs = knownPlots().map(({ title, caption, panels }): PlotSpec =>
    ({ title: title(), caption: caption(), panels: panels(), key: filterKey(), height: PANEL_HEIGHT }));
  showPlots(specs, (plots) => plots.map((plot) => plot.element));
}

/** After another choice of filters. */
export function refreshPlots(): void {
  const known = knownPlots();
  timePlots().forEach((plot: TimePlot, k) => {
    plot.spec.key = filterKey();
    plot.setPanels(known[k].panels());
  });
}
