// The page of a calibration of cameras: its key figures and its panels.
import { type CameraFigures, type CamerasData, type CamerasJson, type Parameter, figuresOf } from './calibration_data';
import { coverageFigure, errorFigure, scatterFigure, uncertaintyFigure } from './calibration_images';
import { type Card, type PageContent, panel, sentences } from './calibration_panels';
import { DIFFERENT, correlationFigure, halvesRatio, lensTable, parameterTable } from './calibration_tables';
import { type Place, chart } from './chart';
import { decodeColumns, extremes, quantile } from './data';
import { fixed, grouped, make, number, swatch } from './format';
import { faded, palette } from './theme';

const cameraColour = (c: number): string => `f-${c % 8 + 1}`;

/** What two halves of the views disagree on. */
function disagreement(parameters: Parameter[]): string[] {
  const list = parameters.map((p) => ({ name: p.name, ratio: halvesRatio(p) }))
    .filter(({ ratio }) => Math.abs(ratio) > DIFFERENT)
    .sort((a, b) => Math.abs(b.ratio) - Math.abs(a.ratio));
  return list.length ? [`Two halves of the views differ by more than ${DIFFERENT} σ in ${list.length} of ` +
    `${parameters.length} parameters, at most by ${fixed(Math.abs(list[0].ratio), 1)} σ in ${list[0].name}.`] : [];
}

function verdict({ suspicious, missing, remarks, parameters }: CamerasJson): HTMLElement {
  const parts = [sentences('suspicious', 'lost', suspicious), sentences('missing', 'degraded', missing),
    sentences('halves', 'degraded', disagreement(parameters)), sentences('remarks', '', remarks)]
    .filter((part) => part !== null);
  return panel('What to know', ...(parts.length ? parts :
    [make('p', {}, make('span', { class: 'badge ok' }, 'ok'),
      ' No view contradicts the others, and no part of the image or tilt of the target is missing.')]));
}

function cards(json: CamerasJson): Card[] {
  const list = json.cameras.map((camera, c): Card => ({
    label: `Error of cam${c}`, value: fixed(camera.rms_px, 3), unit: 'px',
    meaning: camera.rms_before_px === null ? 'root mean square' : `before: ${fixed(camera.rms_before_px, 3)} px`,
  }));
  if (json.held_out_rms_px !== undefined) {
    list.push({ label: 'Held-out error', value: fixed(json.held_out_rms_px, 3), unit: 'px',
      meaning: 'of each half of the views by the other' });
  }
  const left = json.views_without_pose;
  return [...list,
    { label: 'Corner σ', value: fixed(json.pixel_sigma_px, 3), unit: 'px', meaning: 'of its u or v, robust' },
    { label: 'Views', value: grouped(json.views), unit: '',
      meaning: left ? `${grouped(left)} without a pose` : 'all were used' },
    { label: 'σ enlarged', value: number(Math.sqrt(json.correlation_factor), 3), unit: '×',
      meaning: 'since errors of corners are alike over a second' }];
}

/** Two halves and the uncertainty of a camera, in words. */
function cameraLine({ camera: { lens, cam_T_cam0: pose, halves_px: halves, halves_sigma_px: sigma } }: CameraFigures,
    c: number): string {
  const distance = Math.hypot(...pose.slice(0, 3).map((row) => row[3]));
  return `Lens ${lens}.` + (c ? ` ${number(1000 * distance, 4)} mm from cam0.` : '') +
    (halves === undefined || sigma === undefined ? '' :
      ` Two halves of the views differ by ${number(halves, 2)} px over the image, ` +
      `where ${number(sigma, 2)} px are expected.`);
}

function cameraPanel(figures: CameraFigures, c: number, sigma: number): HTMLElement {
  return panel(figures.name, make('p', { class: 'muted' }, cameraLine(figures, c)),
    make('div', { class: 'figure-grid' }, errorFigure(figures), uncertaintyFigure(figures),
      coverageFigure(figures), scatterFigure(figures, sigma)));
}

function viewsPanel({ first_s: start, figures }: CamerasData['views'], cameras: number): HTMLElement {
  const { seconds, camera, rms, corners, suspicious } = decodeColumns(figures);
  const [first, last] = extremes(seconds), [lowest, highest] = extremes(rms);
  const log = highest > 20 * quantile(rms, 0.5);
  const at = (place: Place, i: number) => [place.x(seconds[i]), place.y(rms[i])];
  const figure = chart({
    label: 'error of each view over time',
    x: { label: 'time since the first view [s]', low: first, high: Math.max(last, first + 1e-3) },
    y: { label: 'error [px]', log, low: log ? Math.max(0.9 * lowest, 1e-4) : 0, high: 1.05 * Math.max(highest, 1e-6) },
    height: 230,
    draw: (g, place) => {
      for (let i = 0; i < rms.length; i++) {
        const [x, y] = at(place, i);
        g.fillStyle = faded(cameraColour(camera[i]), 0.75);
        g.beginPath();
        g.arc(x, y, 1.8, 0, 2 * Math.PI);
        g.fill();
        if (!suspicious[i]) continue;
        g.strokeStyle = palette.bad;
        g.lineWidth = 1.5;
        g.beginPath();
        g.arc(x, y, 5, 0, 2 * Math.PI);
        g.stroke();
      }
    },
    tip: (x, y, place) => {
      let best = -1, least = 12;
      for (let i = 0; i < rms.length; i++) {
        const [u, v] = at(place, i), distance = Math.hypot(u - place.x(x), v - place.y(y));
        if (distance < least) [best, least] = [i, distance];
      }
      return best < 0 ? null : `cam${camera[best]} at ${fixed(seconds[best], 3)} s: ` +
        `${fixed(rms[best], 3)} px, ${corners[best]} corners${suspicious[best] ? ', suspicious' : ''}`;
    },
  });
  const keys = Array.from({ length: cameras }, (_, c) =>
    make('span', { class: 'key' }, swatch('dots', cameraColour(c)), `cam${c}`));
  if (Array.from(suspicious).some(Boolean)) {
    keys.push(make('span', { class: 'key' }, swatch('rings', 'bad'), 'suspicious'));
  }
  return panel('Views', make('div', { class: 'legend' }, ...keys), figure,
    make('p', { class: 'muted small' }, 'Root mean square error of the corners of each view. ' +
      `The first is at ${start.toFixed(3)} s.`));
}

export function camerasContent(data: CamerasData): PageContent {
  const { calibration } = data, figures = figuresOf(data);
  const compared = figures.filter(({ camera }) => camera.lenses);
  const count = figures.length === 1 ? '1 camera' : `${figures.length} cameras`;
  return {
    title: 'Calibration of cameras',
    line: [count, [...new Set(figures.map(({ camera }) => camera.lens))].join(', '),
      `${grouped(calibration.views)} views`].join(' · '),
    cards: cards(calibration),
    panels: [
      verdict(calibration),
      ...figures.map((one, c) => cameraPanel(one, c, calibration.pixel_sigma_px)),
      viewsPanel(data.views, figures.length),
      panel('Parameters', parameterTable(calibration.parameters),
        make('p', { class: 'muted small' }, 'σ covers the errors of corners. The halves are two calibrations ' +
          `from alternate pieces of the recording; more than ${DIFFERENT} σ between them are a sign of errors ` +
          'that σ does not cover.')),
      panel('Correlations', correlationFigure(calibration)),
      ...(compared.length ? [panel('Compared lenses', ...compared.map(({ name, camera }) => lensTable(name, camera)),
        make('p', { class: 'muted small' }, 'Error of views that took no part. The lens of fewest parameters ' +
          'within 1 % of the least error is chosen.'))] : []),
    ],
  };
}
