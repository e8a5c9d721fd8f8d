// The page of a calibration of an IMU's noise.
import { polyline } from './canvas';
import { type Card, type PageContent, panel, sentences, strong, table } from './calibration_panels';
import { chart } from './chart';
import { type Columns, decodeColumns, extremes } from './data';
import { type Child, fixed, grouped, make, number, swatch } from './format';
import { faded, palette } from './theme';

interface Term { value: number | null; sigma: number | null; limit: number }
interface Taken { value: number; is_limit: boolean }

interface NoiseAxis {
  axis: string;
  noise_density?: Term;
  bias_instability?: Term;
  random_walk?: Term;
  motion?: { density: number; sigma: number; quietest: number };
}

interface Sensor { unit: string; noise_density: Taken; random_walk: Taken | null; axes: NoiseAxis[] }

export interface NoiseData {
  kind: 'noise';
  noise: {
    recording: string;
    samples: number;
    rate_hz: number;
    seconds: number;
    standstill: { seconds: number } | null;
    accelerometer: Sensor;
    gyroscope: Sensor;
    remarks: string[];
  };
  curves: { sensor: string; axis: string; points: Record<string, string> }[];
}

type SensorName = 'accelerometer' | 'gyroscope';
const SENSORS: readonly SensorName[] = ['accelerometer', 'gyroscope'];
const AXIS_COLOURS: Record<string, string> = { x: 'f-1', y: 'f-2', z: 'f-3' };

interface Curve { axis: string; points: Columns }

function allanFigure(name: SensorName, unit: string, curves: Curve[]): HTMLElement {
  const taus = curves.flatMap(({ points }) => Array.from(points.seconds));
  const bounds = curves.flatMap(({ points }) => [...points.lowest, ...points.highest]).filter((v) => v > 0);
  const [first, last] = extremes(taus), [low, high] = extremes(bounds);
  return chart({
    label: `Allan deviations of the ${name}`,
    x: { label: 'averaging time [s]', log: true, low: first * 0.9, high: last * 1.1 },
    y: { label: `Allan deviation [${unit}]`, log: true, low: low * 0.8, high: high * 1.25 },
    height: 300,
    draw: (g, { x, y }) => {
      for (const { axis, points: { seconds, deviation, lowest, highest, of_fit: fit } } of curves) {
        g.strokeStyle = faded(AXIS_COLOURS[axis], 0.45);
        g.lineWidth = 1;
        for (let i = 0; i < seconds.length; i++) {
          g.beginPath();
          g.moveTo(x(seconds[i]), y(Math.max(lowest[i], low)));
          g.lineTo(x(seconds[i]), y(highest[i]));
          g.stroke();
        }
        g.fillStyle = palette[AXIS_COLOURS[axis]];
        for (let i = 0; i < seconds.length; i++) {
          g.fillRect(x(seconds[i]) - 1.7, y(deviation[i]) - 1.7, 3.4, 3.4);
        }
        g.strokeStyle = palette[AXIS_COLOURS[axis]];
        g.lineWidth = 1.6;
        polyline(g, seconds.length, (i) => x(seconds[i]), (i) => y(fit[i]));
      }
    },
    tip: (tau, deviation, { x, y }) => {
      let text: string | null = null, least = 14;
      for (const { axis, points } of curves) {
        for (let i = 0; i < points.seconds.length; i++) {
          const distance = Math.hypot(x(points.seconds[i]) - x(tau), y(points.deviation[i]) - y(deviation));
          if (distance >= least) continue;
          least = distance;
          text = `${axis}, ${number(points.seconds[i])} s: ${number(points.deviation[i])} ` +
            `(95 %: ${number(points.lowest[i])} to ${number(points.highest[i])}), ` +
            `fit ${number(points.of_fit[i])} ${unit}`;
        }
      }
      return text;
    },
  });
}

function termCell(term: Term | undefined): Child {
  if (!term) return '–';
  if (term.value === null || term.sigma === null) return `≤ ${number(term.limit, 2)}`;
  return make('span', {}, strong(number(term.value)), ` ± ${fixed(100 * term.sigma / term.value, 1)} %`);
}

function sensorPanel(name: SensorName, sensor: Sensor, curves: Curve[]): HTMLElement {
  const { axes, noise_density: density, random_walk: walk } = sensor, unit = sensor.unit.replace('^2', '²');
  const title = name === 'gyroscope' ? 'Gyroscope' : 'Accelerometer';
  const taken = (one: Taken | null) => (one ? strong(`${one.is_limit ? '≤\u00a0' : ''}${number(one.value)}`) : '–');
  const figure = curves.length ? [
    make('div', { class: 'legend' }, ...curves.map(({ axis }) =>
      make('span', { class: 'key' }, swatch('dots lined', AXIS_COLOURS[axis]), axis))),
    allanFigure(name, unit, curves),
    make('p', { class: 'muted small' }, 'Squares: overlapping Allan deviation with its 95 % interval. Lines: ' +
      'of the fit of noise density, bias instability and random walk.'),
  ] : [];
  return panel(title, ...figure, table(title, ['', ...axes.map(({ axis }) => axis), 'a filter takes'], [
    [`Noise density [${unit}/√Hz]`, ...axes.map((axis) => termCell(axis.noise_density)), taken(density)],
    [`Bias instability [${unit}]`, ...axes.map((axis) => termCell(axis.bias_instability)), ''],
    [`Random walk [${unit}/s/√Hz]`, ...axes.map((axis) => termCell(axis.random_walk)), taken(walk)],
    ...(axes.some(({ motion }) => motion) ? [[`Density in motion [${unit}/√Hz]`,
      ...axes.map(({ motion }) => (motion ? number(motion.density) : '–')), '']] : []),
  ]));
}

const takenCard = (label: string, taken: Taken | null, unit: string): Card => ({
  label, unit: taken ? unit : '', value: taken ? (taken.is_limit ? '≤\u00a0' : '') + number(taken.value) : '–',
  meaning: taken ? 'root mean square of the axes' : 'a motion does not show it',
});

export function noiseContent({ noise, curves }: NoiseData): PageContent {
  const { accelerometer, gyroscope, remarks, standstill } = noise;
  return {
    title: 'Noise of an IMU',
    line: `${noise.recording} · ${grouped(noise.samples)} samples · ${number(noise.rate_hz, 4)} Hz`,
    cards: [
      takenCard('Noise of specific force', accelerometer.noise_density, 'm/s²/√Hz'),
      takenCard('Its random walk', accelerometer.random_walk, 'm/s³/√Hz'),
      takenCard('Noise of angular rate', gyroscope.noise_density, 'rad/s/√Hz'),
      takenCard('Its random walk', gyroscope.random_walk, 'rad/s²/√Hz'),
      { label: 'Standstill', value: number(standstill?.seconds ?? 0), unit: 's',
        meaning: `of ${number(noise.seconds)} s` },
    ],
    panels: [
      ...(remarks.length ? [panel('What to know', sentences('remarks', '', remarks))] : []),
      ...SENSORS.map((name) => sensorPanel(name, noise[name], curves.filter(({ sensor }) => sensor === name)
        .map(({ axis, points }) => ({ axis, points: decodeColumns(points) })))),
    ],
  };
}
