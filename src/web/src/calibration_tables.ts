// The parameters of a calibration, their correlations, and the lenses that were compared.
import type { CalibratedCamera, CamerasJson, Parameter } from './calibration_data';
import { strong, table } from './calibration_panels';
import { chart } from './chart';
import { clamp } from './data';
import { type Child, fixed, make, number, swatch } from './format';
import { faded } from './theme';

/** So many digits that the last one is about a tenth of sigma. */
const digitsOf = (sigma: number): number =>
  (sigma > 0 ? clamp(1 - Math.floor(Math.log10(sigma)), 0, 9) : 6);

const UNITLESS = '1';

/** Halves that differ by more standard deviations have errors that sigma does not cover. */
export const DIFFERENT = 3;

/** The difference of the halves in standard deviations; NaN where there are no halves. */
export const halvesRatio = ({ halves_difference: difference = NaN, halves_sigma: sigma = NaN }: Parameter): number =>
  (sigma > 0 ? difference / sigma : NaN);

function halvesCell(parameter: Parameter): Child {
  const ratio = halvesRatio(parameter);
  if (!Number.isFinite(ratio)) return '–';
  const text = `${fixed(ratio, 1)} σ`;
  return Math.abs(ratio) > DIFFERENT ? make('span', { class: 'badge degraded' }, text) : strong(text);
}

export function parameterTable(parameters: Parameter[]): HTMLElement {
  const hasHalves = parameters.some((p) => Number.isFinite(halvesRatio(p)));
  const head = ['Parameter', 'Value', 'σ', 'Unit', ...(hasHalves ? ['Halves differ by'] : [])];
  return table('Parameters', head, parameters.map((p) => [
    p.name,
    strong(fixed(p.value, digitsOf(p.sigma))),
    number(p.sigma, 2),
    p.unit === UNITLESS ? '' : p.unit,
    ...(hasHalves ? [halvesCell(p)] : []),
  ]));
}

/** Correlations as an image, and the strongest ones in words. */
export function correlationFigure({ parameters, covariance }: CamerasJson): HTMLElement {
  const n = parameters.length, names = parameters.map(({ name }) => name);
  const r = (i: number, j: number) => covariance[i][j] / Math.sqrt(covariance[i][i] * covariance[j][j]);
  const pairs = names.flatMap((_, i) => names.slice(0, i).map((__, j) => ({ i, j, value: r(i, j) })))
    .filter(({ value }) => Number.isFinite(value))
    .sort((a, b) => Math.abs(b.value) - Math.abs(a.value)).slice(0, 5);
  const figure = chart({
    label: `correlations of ${n} parameters`,
    x: { label: '', low: -0.5, high: n - 0.5, names },
    y: { label: '', low: n - 0.5, high: -0.5, names },
    aspect: 1,
    draw: (g, { x, y, width, height }) => {
      for (let i = 0; i < n; i++) {
        for (let j = 0; j < n; j++) {
          const value = r(i, j);
          if (!Number.isFinite(value)) continue;
          g.fillStyle = faded(value > 0 ? 'estimate' : 'dead', Math.abs(value));
          g.fillRect(x(j - 0.5), y(i - 0.5), width / n - 0.6, height / n - 0.6);
        }
      }
    },
    tip: (x, y) => {
      const [i, j] = [clamp(Math.round(y), 0, n - 1), clamp(Math.round(x), 0, n - 1)];
      return `${names[i]} and ${names[j]}: ${fixed(r(i, j), 3)}`;
    },
  });
  return make('div', { class: 'correlations' }, figure, make('div', {},
    make('p', { class: 'legend' }, make('span', { class: 'key' }, swatch('area', 'estimate'), 'together'),
      make('span', { class: 'key' }, swatch('area', 'dead'), 'against each other')),
    make('h3', {}, 'The strongest'),
    make('ul', { class: 'small' }, ...pairs.map(({ i, j, value }) =>
      make('li', {}, `${names[j]} and ${names[i]}: ${fixed(value, 3)}`)))));
}

/** The lenses that were compared for a camera. */
export function lensTable(name: string, { lens, lenses }: CalibratedCamera): HTMLElement {
  return table(`Lenses of ${name}`, [`Lens of ${name}`, 'Held-out error [px]', ''], (lenses ?? []).map((trial) => [
    trial.lens,
    trial.held_out_rms_px === null ? '–' : strong(fixed(trial.held_out_rms_px, 4)),
    trial.lens === lens ? make('span', { class: 'badge ok' }, 'chosen') :
      make('span', { class: 'wrapped' }, trial.fault),
  ]));
}
