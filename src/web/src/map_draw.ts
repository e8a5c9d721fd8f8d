// How the map is drawn. `view` maps world metres to pixels: see MapView.
import { ellipseOf, multiplesOf, niceStep, type Pen, polyline, tickText } from './canvas';
import { closuresOf } from './closures';
import { AXES, clamp, type Vector } from './data';
import { number } from './format';
import type { MapView, Plane, PlaneCovariance } from './map_view';
import { activeRun, placedColumns, type Run, truthColumns } from './runs';
import { app } from './store';
import { palette, ramp } from './theme';

export interface MapOptions {
  /** Layers by their keys; what is not there has not been switched: see layerShown(). */
  show: Record<string, boolean>;
  colour: string;
  ellipses: string;
  truth: string;
}

/** Whether a layer is shown. Until somebody switches them the initial positions are shown only of a run
 *  that maps along known poses; every other layer is shown. */
export const layerShown = ({ show }: MapOptions, key: string): boolean =>
  show[key] ?? (key !== 'initial' || activeRun().summary.mode === 'map');

type Points = Partial<Record<'x' | 'y' | 'z', ArrayLike<number>>>;

/** The colour of the run that the page shows: alone it is the estimate. */
export const estimateColour = (): string =>
  (app.subjects.length > 1 ? activeRun().colour : 'estimate');

/** What lies over the landmarks and does not follow the cursor: paths, the scale, the key of colours. */
export function drawPaths(g: Pen, view: MapView, options: MapOptions, ellipses: boolean): void {
  (app.subjects as Run[]).forEach((run, k) => {
    if (k !== app.active && layerShown(options, `run-${k}`)) drawOtherRun(g, view, run);
  });
  const run = activeRun();
  if (options.show.dead && run.deadReckoning) {
    drawPath(g, view, run.deadReckoning, palette.dead, 1.8, [2, 4]);
  }
  if (options.show.truth && run.truth) {
    drawPath(g, view, truthColumns(run, options.truth), palette.truth, 1.8, [9, 5]);
  }
  if (options.show.estimate) drawEstimate(g, view, run, ellipses);
  if (layerShown(options, 'closures')) drawClosures(g, view, run);
  drawScale(g, view);
  const coloured = options.show.view || options.show.retired;
  if (coloured && options.colour !== 'plain') drawRamp(g, view, options);
}

export function drawGrid(g: Pen, view: Plane): void {
  const step = niceStep(view.width / view.scale, view.width / 110);
  g.strokeStyle = palette.line;
  g.globalAlpha = 0.55;
  g.lineWidth = 1;
  g.beginPath();
  const [left, top] = view.toWorld(0, 0), [right, bottom] = view.toWorld(view.width, view.height);
  for (const at of multiplesOf(step, left, right)) {
    const x = Math.round(view.xOnScreen(at)) + 0.5;
    g.moveTo(x, 0);
    g.lineTo(x, view.height);
  }
  for (const at of multiplesOf(step, bottom, top)) {
    const y = Math.round(view.yOnScreen(at)) + 0.5;
    g.moveTo(0, y);
    g.lineTo(view.width, y);
  }
  g.stroke();
  g.globalAlpha = 1;
}

export function drawPath(g: Pen, view: MapView, columns: Points, colour: string, width: number,
    dash: number[], shift: Vector = [0, 0, 0]): void {
  const [a, b] = view.axes.map((axis) => columns[axis] ?? []);
  const [da, db] = view.axes.map((axis) => shift[AXES.indexOf(axis)]);
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.setLineDash(dash);
  polyline(g, a.length, (i) => view.xOnScreen(a[i] + da), (i) => view.yOnScreen(b[i] + db));
  g.setLineDash([]);
}

export function drawPlan(g: Pen, view: MapView, { truth }: MapOptions): void {
  const { plan } = activeRun();
  // From the side it would be a line without meaning.
  if (!plan || view.axes.includes('z')) return;
  drawPath(g, view, placedColumns(plan.furniture, truth), palette.line, 1.2, []);
  drawPath(g, view, placedColumns(plan.wall, truth), palette.muted, 1.2, []);
}

function drawOtherRun(g: Pen, view: MapView, run: Run): void {
  const shift = run.origin.map((o, i) => o - activeRun().origin[i]) as Vector;
  drawPath(g, view, run.states, palette[run.colour], 1.8, [12, 3, 2, 3], shift);
}

function drawEstimate(g: Pen, view: MapView, run: Run, ellipses: boolean): void {
  if (ellipses) drawPositionEllipses(g, view, run);
  g.lineCap = 'round';
  drawPath(g, view, run.states, palette.panel, 4.6, []);
  drawPath(g, view, run.states, palette[estimateColour()], 2.4, []);
  g.lineCap = 'butt';
  if (run.count) drawStart(g, view, run);
}

/** A ring where past landmarks returned into the state. */
function drawClosures(g: Pen, view: MapView, run: Run): void {
  g.strokeStyle = palette.cursor;
  g.lineWidth = 1.6;
  for (const { state } of closuresOf(run)) {
    const [x, y] = view.stateAt(run, state);
    g.beginPath();
    g.arc(x, y, 6, 0, 2 * Math.PI);
    g.stroke();
  }
}

function drawStart(g: Pen, view: MapView, run: Run): void {
  const [x, y] = view.stateAt(run, 0);
  g.fillStyle = palette.panel;
  g.strokeStyle = palette[estimateColour()];
  g.lineWidth = 2;
  g.beginPath();
  g.arc(x, y, 4.5, 0, 2 * Math.PI);
  g.fill();
  g.stroke();
  // Behind the first pose, where the path is not.
  const behind = view.forward(run, 0)[0] > 0;
  drawTag(g, 'start', x + (behind ? -10 : 10), besideMarker(y), behind ? 'right' : 'left');
}

/** The height of a tag that the marker of a pose at y does not hide: a path may end where it began. */
export const besideMarker = (y: number): number => y + (y > 32 ? -20 : 20);

/** A short text that begins or ends at x, moved to where the picture has all of it; on a piece of
 *  ground, so that what lies below does not disturb it. */
export function drawTag(g: Pen, text: string, x: number, y: number, align: 'left' | 'right'): void {
  g.textAlign = 'left';
  g.textBaseline = 'middle';
  const { width } = g.measureText(text), picture = g.canvas.width / g.getTransform().a;
  const left = clamp(align === 'left' ? x : x - width, 4, Math.max(4, picture - width - 4));
  g.globalAlpha = 0.8;
  g.fillStyle = palette.panel;
  g.fillRect(left - 3, y - 8, width + 6, 16);
  g.globalAlpha = 1;
  g.fillStyle = palette.ink;
  g.fillText(text, left, y);
}

/** Ellipses of the position about every 70 pixels of the way. */
function drawPositionEllipses(g: Pen, view: MapView, run: Run): void {
  let [lastX, lastY] = [-1e9, -1e9];
  g.strokeStyle = g.fillStyle = palette[estimateColour()];
  g.lineWidth = 1;
  for (let i = 0; i < run.count; i++) {
    const [x, y] = view.stateAt(run, i);
    if (Math.hypot(x - lastX, y - lastY) < 70) continue;
    [lastX, lastY] = [x, y];
    strokeEllipse(g, view, x, y, view.stateCovariance(run, i), 0.03, 0.45);
  }
}

export function strokeEllipse(g: Pen, view: MapView, x: number, y: number, covariance: PlaneCovariance,
    fillAlpha: number, strokeAlpha = 0.8): void {
  const e = ellipseOf(...covariance);
  g.beginPath();
  // The screen's y axis points down, so the angle changes its sign.
  g.ellipse(x, y, e.major * view.scale, e.minor * view.scale, -e.angle, 0, 2 * Math.PI);
  if (fillAlpha > 0) {
    g.globalAlpha = fillAlpha;
    g.fill();
  }
  g.globalAlpha = strokeAlpha;
  g.stroke();
  g.globalAlpha = 1;
}

/** The size of a pixel of the picture [css px]. */
export const pixelOf = (g: Pen): number => 1 / g.getTransform().a;

/** Of whole pixels: quick to draw, and the same whatever part of the map is drawn. */
export function fillSquare(g: Pen, x: number, y: number, size: number, pixel: number): void {
  const side = pixel * Math.round(size / pixel);
  const start = (middle: number) => pixel * Math.round((middle - side / 2) / pixel);
  g.fillRect(start(x), start(y), side, side);
}

/** The landmark under the pointer. */
export function drawHovered(g: Pen, view: MapView): void {
  const [x, y] = view.landmarkAt(view.hovered);
  g.strokeStyle = g.fillStyle = palette.cursor;
  g.lineWidth = 1.6;
  strokeEllipse(g, view, x, y, view.landmarkCovariance(view.hovered), 0.15);
  g.beginPath();
  g.arc(x, y, 5, 0, 2 * Math.PI);
  g.stroke();
}

/** The pose at the cursor: an arrow along the body's x axis, with the ellipse of its position. */
export function drawMarker(g: Pen, view: MapView, run: Run): void {
  if (!run.count) return;
  const [x, y] = view.stateAt(run, app.cursor);
  g.strokeStyle = g.fillStyle = palette.cursor;
  g.lineWidth = 1.4;
  strokeEllipse(g, view, x, y, view.stateCovariance(run, app.cursor), 0.18);
  const [fx, fy] = view.forward(run, app.cursor);
  const length = Math.hypot(fx, fy);
  g.save();
  g.translate(x, y);
  g.rotate(Math.atan2(-fy, fx));
  g.beginPath();
  const reach = 6 + 7 * Math.min(1, length);
  g.moveTo(reach, 0);
  g.lineTo(-6, 6.5);
  g.lineTo(-3, 0);
  g.lineTo(-6, -6.5);
  g.closePath();
  g.strokeStyle = palette.panel;
  g.lineWidth = 3.5;
  g.stroke();
  g.fill();
  g.restore();
}

export function drawScale(g: Pen, view: Plane): void {
  const metres = niceStep(view.width / view.scale, view.width / 90);
  const length = metres * view.scale, x = 14, y = view.height - 16;
  g.strokeStyle = palette.ink;
  g.lineWidth = 1.5;
  g.beginPath();
  g.moveTo(x, y - 5);
  g.lineTo(x, y);
  g.lineTo(x + length, y);
  g.lineTo(x + length, y - 5);
  g.stroke();
  g.textBaseline = 'alphabetic';
  g.fillStyle = palette.ink;
  g.textAlign = 'left';
  g.fillText(metres >= 1000 ? `${number(metres / 1000)} km` : `${tickText(metres, metres)} m`, x + 4, y - 5);
  g.fillStyle = palette.muted;
  if (view.names && view.width > 480) {
    g.fillText(`${view.names[0]} →  ${view.names[1]} ↑`, x + length + 10, y);
  }
}

/** The key of the landmarks' colours. */
function drawRamp(g: Pen, view: MapView, options: MapOptions): void {
  const [low, high] = view.colourRange;
  if (!(high > low)) return;
  const width = 120, x = view.width - width - 14, y = view.height - 18;
  g.globalAlpha = 0.85;
  g.fillStyle = palette.panel;
  g.fillRect(x - 8, y - 22, width + 16, 36);
  g.globalAlpha = 1;
  for (let k = 0; k < width; k++) {
    g.fillStyle = ramp(k / (width - 1));
    g.fillRect(x + k, y, 1.5, 6);
  }
  g.fillStyle = palette.ink;
  g.textBaseline = 'alphabetic';
  const unit = options.colour === 'sigma' ? 'σ' : 'z';
  g.textAlign = 'left';
  g.fillText(`${unit} ${number(low, 2)}`, x, y - 6);
  g.textAlign = 'right';
  g.fillText(`${number(high, 2)} m`, x + width, y - 6);
}
