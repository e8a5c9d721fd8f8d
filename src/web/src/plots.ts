// Which plots a run gets, and what is in them.
import { AXES, type Column, extremes, mean, quantile, shareInside, type Values } from './data';
import { grouped, number, percent, titleCase } from './format';
import type { Panel, PlotSpec, Series } from './plot_spec';
import type { Run } from './runs';
import { timingPlot } from './timing_plot';

/** What is known of the numbers that runs estimate besides the pose: units, and whose axes theirs are. */
const FAMILIES: [name: RegExp, unit: string, axes: string][] = [
  [/^velocity$/, 'm/s', 'the world'],
  [/^linear_velocity$/, 'm/s', 'the IMU'],
  [/^accelerometer_bias$/, 'm/s²', 'the IMU'],
  [/^(angular_velocity|gyroscope_bias|gyro_bias)$/, 'rad/s', 'the IMU'],
  [/^(tilt|velocity_heading)$/, 'rad', ''],
  [/^imu_T_cam\d+_turned$/, 'rad', 'the IMU'],
  [/^imu_T_cam\d+$/, 'm', 'the IMU'],
  [/^cam\d+_[fc][xy]$/, 'px', ''],
  [/^(cam\d+_readout_time|time_offset)$/, 's', ''],
  [/^cam\d+_/, '1', ''],
  [/^(accelerometer|gyroscope)_scale$/, '1', 'the IMU'],
  [/^(accelerometer|gyroscope)_misalignment_[xyz]$/, 'rad', ''],
  [/^g_sensitivity_[xyz]$/, 'rad/s/(m/s²)', ''],
];

export function plotSpecs(run: Run): PlotSpec[] {
  return [
    positionPlot(run), attitudePlot(run), nisPlot(run), neesPlot(run),
    observationPlot(run), landmarkPlot(run), timingPlot(run), ...extraPlots(run),
  ].filter((spec) => spec !== null);
}

/** Error (or, without truth, nothing but the band) of one axis with ±3σ. */
function errorPanel(label: string, unit: string, error: Column | undefined, sigma: Column): Panel {
  const high = sigma.map((s) => 3 * s), low = sigma.map((s) => -3 * s);
  const series: Series[] = [{ label: '±3σ', style: 'band', low, high, colour: 'band' }];
  let summary = `last 3σ ${number(high[high.length - 1], 2)} ${unit}`;
  if (error) {
    series.push({ label: 'error', style: 'line', values: error, colour: 'estimate', sigma });
    const rms = Math.sqrt(mean(error.map((e) => e * e)));
    summary = `rms ${number(rms, 2)} ${unit}, ${percent(shareInside(error, low, high))} inside`;
  }
  return { label, unit, series, summary };
}

function errorCaption(run: Run, what: string): string {
  if (run.errors) {
    return `Truth minus estimate along the world axes, ${what}. Truth is placed by the first ` +
      'common pose, nothing else is fitted. A consistent filter stays inside ±3σ ' +
      '99.7 % of the time.';
  }
  return 'Three times the standard deviation that the filter reports. No truth is available, so no ' +
    'error can be shown.';
}

function positionPlot(run: Run): PlotSpec {
  const s = run.states, e = run.errors;
  return {
    title: run.errors ? 'Position error' : 'Position uncertainty',
    caption: errorCaption(run, 'in metres'),
    panels: AXES.map((axis) => errorPanel(axis, 'm', e?.['position_' + axis],
      s['sigma_p' + axis])),
  };
}

function attitudePlot(run: Run): PlotSpec {
  const s = run.states, e = run.errors;
  return {
    title: run.errors ? 'Attitude error' : 'Attitude uncertainty',
    caption: errorCaption(run, 'as a rotation vector in degrees'),
    panels: AXES.map((axis) => errorPanel('about ' + axis, '°', e?.['attitude_' + axis],
      s['sigma_r' + axis])),
  };
}

/** A panel of a normalised square with its 95 % band; `floor` is where a logarithmic axis ends. */
function consistencyPanel(label: string, values: ArrayLike<number>, low: Values, high: Values,
    average: number, expected: number): Panel {
  const share = shareInside(values, low, high);
  return {
    label, zero: true, floor: expected / 100,
    summary: `mean ${number(average)} (expected ${expected}), ${percent(share)} in the band`,
    series: [
      { label: '95 % band', style: 'band', low, high, colour: 'good' },
      { label: label || 'value', style: 'line', values, colour: 'estimate', legend: false },
    ],
  };
}

/** Far above the band a linear axis shows nothing of it. */
export function leavesBandFar(values: ArrayLike<number>, high: Values): boolean {
  return quantile(values, 0.98) > 12 * mean(typeof high === 'number' ? [high] : high);
}

function nisPlot(run: Run): PlotSpec | null {
  const s = run.states;
  const perDof = Float32Array.from(s.nis, (v, i) => (s.nis_dof[i] > 0 ? v / s.nis_dof[i] : NaN));
  if (!perDof.some(Number.isFinite)) return null;
  const sum = (values: Column) => {
    let total = 0;
    values.forEach((v, i) => { if (s.nis_dof[i] > 0) total += v; });
    return total;
  };
  const panel = consistencyPanel('NIS / dof', perDof, s.nis_low, s.nis_high,
    sum(s.nis) / sum(s.nis_dof), 1);
  panel.log = leavesBandFar(perDof, s.nis_high);
  return {
    title: 'NIS per degree of freedom',
    caption: 'Squared innovations over what the filter expected of them, each frame: 1 on ' +
      'average when the measurement noise is right. The band holds 95 % of the frames then; it narrows ' +
      'with the number of observations.',
    panels: [panel],
  };
}

const COORDINATES: Record<string, string> = {
  standard: 'standard (rotation and position, world axes)',
  'body-twist': 'body twist, Log(X̂⁻¹ X)',
  'world-twist': 'world twist, Log(X X̂⁻¹)',
};

function neesPlot(run: Run): PlotSpec | null {
  const e = run.errors;
  if (!e) return null;
  const parts = ([['position', 3], ['attitude', 3], ['pose', 6]] as const).map(([name, axes]) => ({
    name, axes, values: e['nees_' + name],
    low: run.bounds[`chi2_${axes}_low`], high: run.bounds[`chi2_${axes}_high`],
  }));
  const log = parts.some((p) => leavesBandFar(p.values, p.high));
  return {
    title: 'NEES',
    caption: 'Squared error against truth over the covariance that the filter reports: equal to ' +
      'the number of axes on average when the filter is consistent; far above, it trusts itself too ' +
      `much. Coordinates of the error: ${COORDINATES[run.neesCoordinates]}, those of the chart.`,
    panels: parts.map((p) => ({
      ...consistencyPanel(p.name, p.values, p.low, p.high, mean(p.values), p.axes), log,
    })),
  };
}

function observationPlot(run: Run): PlotSpec {
  const s = run.states;
  const sum = (values: Column) => {
    let total = 0;
    for (const v of values) total += v;
    return total;
  };
  return {
    title: 'Observations',
    caption: 'Landmark observations of each frame: offered by the recording, used in the update, ' +
      'rejected by the χ² gate. The others initialised a landmark or were not usable.',
    panels: [{
      label: '', zero: true,
      summary: `${grouped(sum(s.used))} used, ${grouped(sum(s.rejected))} rejected`,
      series: [
        { label: 'offered', style: 'area', values: s.observations, colour: 'muted' },
        { label: 'used', style: 'area', values: s.used, colour: 'estimate' },
        { label: 'rejected', style: 'line', values: s.rejected, colour: 'dead' },
      ],
    }],
  };
}

function landmarkPlot(run: Run): PlotSpec {
  const s = run.states;
  const panel = (label: string, values: Column, colour: string): Panel => ({
    label, zero: true, summary: `most ${grouped(Math.max(0, extremes(values)[1]))}`,
    series: [{ label, style: 'area', values, colour, legend: false }],
  });
  return {
    title: 'Landmarks',
    caption: 'Landmarks that a frame’s update could touch, and those of the whole map.',
    panels: [panel('in the state', s.in_state, 'good'),
      panel('in the map', s.landmarks, 'landmark')],
  };
}

/** Velocities, biases and whatever else the filter estimated: a plot for each x, y, z family. */
function extraPlots(run: Run): PlotSpec[] {
  const families = new Map<string, Panel[]>();
  run.extraNames.forEach((name, k) => {
    const [, family, axis = ''] = /^([^]*?)(?:_([xyz]))?$/.exec(name) as RegExpExecArray;
    const panels = families.get(family) ?? [];
    panels.push(extraPanel(axis, knownOf(family)?.[1] ?? '', run.extra[k]));
    families.set(family, panels);
  });
  return [...families].map(([family, panels]) => ({
    title: titleCase(family), caption: extraCaption(knownOf(family)?.[2]), panels,
  }));
}

const knownOf = (family: string) => FAMILIES.find(([name]) => name.test(family));

const extraCaption = (axes: string | undefined): string =>
  `What the filter estimates, with ±3σ${axes ? `; in the axes of ${axes}` : ''}.`;

function extraPanel(label: string, unit: string, { value, sigma }: Run['extra'][number]): Panel {
  const low = value.map((v, i) => v - 3 * sigma[i]), high = value.map((v, i) => v + 3 * sigma[i]);
  const last = value.length - 1;
  return {
    label, unit,
    summary: `last ${number(value[last])} ± ${number(3 * sigma[last], 2)}`,
    series: [{ label: '±3σ', style: 'band', low, high, colour: 'band' },
      { label: 'estimate', style: 'line', values: value, colour: 'estimate', sigma }],
  };
}
