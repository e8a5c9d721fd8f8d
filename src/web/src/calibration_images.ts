// Figures of one camera: what its image has of corners, of their errors and of uncertainty.
import { type Pen, niceStep } from './canvas';
import type { CameraFigures, Cells } from './calibration_data';
import { type ChartForm, type ColourScale, type Place, chart, colourAt } from './chart';
import { clamp, extremes, quantile } from './data';
import { fixed, grouped, make, number } from './format';
import { faded, palette } from './theme';

const sizeOf = ({ camera }: CameraFigures) => ({ width: camera.resolution[0], height: camera.resolution[1] });

/** The axes of an image: a pixel's centre has whole coordinates. */
function imageAxes(figures: CameraFigures): Pick<ChartForm, 'x' | 'y' | 'aspect'> {
  const { width, height } = sizeOf(figures);
  return {
    x: { label: 'u [px]', low: -0.5, high: width - 0.5 },
    y: { label: 'v [px]', low: height - 0.5, high: -0.5 },
    aspect: height / width,
  };
}

function titled(title: string, figure: HTMLElement, note: string): HTMLElement {
  return make('div', { class: 'figure-box' }, make('h3', {}, title), figure,
    make('p', { class: 'muted small' }, note));
}

const cellAt = (figures: CameraFigures, u: number, v: number): number => {
  const { width, height } = sizeOf(figures), { columns, rows } = figures.cells;
  return clamp(Math.floor(rows * (v + 0.5) / height), 0, rows - 1) * columns +
    clamp(Math.floor(columns * (u + 0.5) / width), 0, columns - 1);
};

/** Calls f with the rectangle of each part of the image. */
function eachCell({ columns, rows }: Cells, { left, top, width, height }: Place,
    f: (k: number, x: number, y: number, w: number, h: number) => void): void {
  const [w, h] = [width / columns, height / rows];
  for (let k = 0; k < columns * rows; k++) {
    f(k, left + w * (k % columns), top + h * Math.floor(k / columns), w, h);
  }
}

function arrow(g: Pen, x: number, y: number, dx: number, dy: number): void {
  const length = Math.hypot(dx, dy), head = Math.min(4, length / 2);
  const angle = Math.atan2(dy, dx);
  g.beginPath();
  g.moveTo(x, y);
  g.lineTo(x + dx, y + dy);
  for (const side of [-2.6, 2.6]) {
    g.moveTo(x + dx, y + dy);
    g.lineTo(x + dx + head * Math.cos(angle + side), y + dy + head * Math.sin(angle + side));
  }
  g.stroke();
}

/** Single errors as dots, and means of parts of the image as arrows. */
export function errorFigure(figures: CameraFigures): HTMLElement {
  const { corners, cells, name } = figures, { du, dv, corners: counts } = cells.figures;
  const sizes = Float64Array.from(corners.du, (e, i) => Math.hypot(e, corners.dv[i]));
  const means = Float64Array.from(du, (e, k) => (counts[k] >= 5 ? Math.hypot(e, dv[k]) : NaN));
  // At most one arrow in twenty is longer than a part is wide.
  const long = Math.max(quantile(means, 0.95), 1e-6);
  const power = niceStep(sizeOf(figures).width / cells.columns / long / 2, 1);
  const colours: ColourScale = { label: 'px', low: 0, high: Math.max(quantile(sizes, 0.98), 1e-6) };
  return titled('Reprojection errors', chart({
    label: `reprojection errors over the image of ${name}`,
    ...imageAxes(figures),
    colours,
    draw: (g, place) => {
      for (let i = 0; i < sizes.length; i++) {
        g.fillStyle = colourAt(colours, sizes[i]);
        g.fillRect(place.x(corners.u[i]) - 1, place.y(corners.v[i]) - 1, 2, 2);
      }
      const perPixel = power * place.width / sizeOf(figures).width;
      for (const [colour, wide] of [[palette.panel, 3.6], [palette.ink, 1.3]] as const) {
        g.strokeStyle = colour;
        g.lineWidth = wide;
        eachCell(cells, place, (k, x, y, w, h) => {
          if (counts[k] >= 5) arrow(g, x + w / 2, y + h / 2, perPixel * du[k], perPixel * dv[k]);
        });
      }
    },
    tip: (u, v) => {
      const k = cellAt(figures, u, v);
      return counts[k] === 0 ? 'no corner' : `${grouped(counts[k])} corners here, mean error ` +
        `${fixed(du[k], 3)}, ${fixed(dv[k], 3)} px`;
    },
  }), `Dots: ${grouped(sizes.length)} of ${grouped(figures.camera.corners)} corners, coloured by their error. ` +
    `Arrows: the mean error of a part of the image, ${grouped(power)} times enlarged. Measured minus projected.`);
}

/** How many corners the parts of the image have. */
export function coverageFigure(figures: CameraFigures): HTMLElement {
  const { cells, name } = figures, counts = cells.figures.corners;
  const empty = Array.from(counts).filter((count) => count === 0).length;
  const colours: ColourScale = { label: 'corners', low: 1, high: Math.max(2, extremes(counts)[1]), log: true };
  return titled('Coverage', chart({
    label: `corners over the image of ${name}`,
    ...imageAxes(figures),
    colours,
    draw: (g, place) => eachCell(cells, place, (k, x, y, w, h) => {
      g.fillStyle = counts[k] > 0 ? colourAt(colours, counts[k]) : palette.ground;
      g.fillRect(x, y, w + 0.5, h + 0.5);
      g.strokeStyle = palette.bad;
      g.lineWidth = 1.2;
      if (counts[k] > 0) return;
      for (const turn of [-1, 1]) {
        g.beginPath();
        g.moveTo(x + w / 2 - 3, y + h / 2 - 3 * turn);
        g.lineTo(x + w / 2 + 3, y + h / 2 + 3 * turn);
        g.stroke();
      }
    }),
    tip: (u, v) => `${grouped(counts[cellAt(figures, u, v)])} corners`,
  }), `${grouped(figures.camera.corners)} corners in ${grouped(figures.camera.views)} views. ` +
    (empty ? `×: a part without any, ${empty} of ${counts.length}.` : 'Each part of the image has some.'));
}

/** How well the calibration knows where a direction is seen. */
export function uncertaintyFigure(figures: CameraFigures): HTMLElement {
  const { grid } = figures.camera.projection;
  const [low, high] = extremes(grid.map(([, , sigma]) => sigma));
  const colours: ColourScale = { label: 'σ [px]', log: true, low: Math.max(low, 1e-9),
    high: Math.max(high, 1.01 * low, 2e-9) };
  const columns = [...new Set(grid.map(([u]) => u))].sort((a, b) => a - b);
  const rows = [...new Set(grid.map(([, v]) => v))].sort((a, b) => a - b);
  const { width, height } = sizeOf(figures);
  const [du, dv] = [width / Math.max(1, columns.length - 1), height / Math.max(1, rows.length - 1)];
  const nearest = (u: number, v: number) => grid.find(([a, b]) =>
    Math.abs(a - u) <= du / 2 + 1 && Math.abs(b - v) <= dv / 2 + 1);
  const numbered = (place: Place, [u, v]: [number, number, number, number]) =>
    (columns.indexOf(u) - 2) % (place.width > 330 ? 4 : 6) === 0 && (rows.indexOf(v) + 1) % 3 === 0;
  return titled('Projection uncertainty', chart({
    label: `standard deviation of the projection over the image of ${figures.name}, ` +
      `from ${number(low)} to ${number(high)} pixels`,
    ...imageAxes(figures),
    colours,
    draw: (g, place) => {
      const [w, h] = [place.x(du) - place.x(0), place.y(dv) - place.y(0)];
      for (const [u, v, sigma] of grid) {
        g.fillStyle = colourAt(colours, sigma);
        g.fillRect(place.x(u) - w / 2, place.y(v) - h / 2, w + 0.5, h + 0.5);
      }
      g.textAlign = 'center';
      g.textBaseline = 'middle';
      g.lineWidth = 3;
      g.strokeStyle = faded('panel', 0.85);
      g.fillStyle = palette.ink;
      for (const point of grid.filter((one) => numbered(place, one))) {
        g.strokeText(number(point[2], 2), place.x(point[0]), place.y(point[1]));
        g.fillText(number(point[2], 2), place.x(point[0]), place.y(point[1]));
      }
    },
    tip: (u, v) => {
      const found = nearest(u, v);
      return found ? `u ${fixed(found[0], 0)}, v ${fixed(found[1], 0)}: ${number(found[2])} px, ` +
        `${number(1000 * found[3])} mm at 1 m` : 'beyond the reach of the lens model';
    },
  }), 'Standard deviation of the pixel of a direction, along the worse axis, but for a turn of the camera. ' +
    'It grows where no corners were.');
}

/** The errors of corners against each other's axis. */
export function scatterFigure(figures: CameraFigures, sigma: number): HTMLElement {
  const { width, height } = sizeOf(figures), { du, dv } = figures.corners;
  const reach = 5 * sigma, wide = reach * width / height;
  const outside = Array.from(du).filter((e, i) => Math.abs(e) > wide || Math.abs(dv[i]) > reach).length;
  return titled('Errors of corners', chart({
    label: `errors of the corners of ${figures.name} along u and v`,
    x: { label: 'error of u [px]', low: -wide, high: wide },
    y: { label: 'error of v [px]', low: reach, high: -reach },
    aspect: height / width,
    draw: (g, place) => {
      g.fillStyle = faded('estimate', 0.45);
      for (let i = 0; i < du.length; i++) {
        g.fillRect(clamp(place.x(du[i]), place.left + 1, place.left + place.width - 1) - 1,
          clamp(place.y(dv[i]), place.top + 1, place.top + place.height - 1) - 1, 2, 2);
      }
      g.strokeStyle = palette.ink;
      g.lineWidth = 1.2;
      for (const k of [1, 2, 3]) {
        g.beginPath();
        g.ellipse(place.x(0), place.y(0), place.x(k * sigma) - place.x(0),
          place.y(k * sigma) - place.y(0), 0, 0, 2 * Math.PI);
        g.stroke();
      }
    },
  }), `Circles: 1, 2 and 3 times the standard deviation of a corner, ${number(sigma)} px. ` +
    (outside ? `${outside} of ${grouped(du.length)} corners lie beyond the edge.` : ''));
}
