// Where the landmarks of a run were initialised, for runs that know it: a dot each on the map, and a
// line from it to the final position. The time cursor changes none of it.
import type { Pen } from './canvas';
import { AXES, clamp, type Columns } from './data';
import { fillSquare, pixelOf } from './map_draw';
import type { MapView } from './map_view';
import { palette } from './theme';

/** So many lines are as thin as they can be: those of one pixel are drawn ten times as quickly. */
const MANY = 2000;

export const knowsInitial = (landmarks: Columns): boolean => 'ix' in landmarks;

/** How far a landmark has moved since its initialisation [m]; NaN where this is not known. */
export function distanceMoved(m: Columns, i: number): number {
  if (!knowsInitial(m)) return NaN;
  return Math.hypot(...AXES.map((axis) => m[axis][i] - m[`i${axis}`][i]));
}

export function drawInitial(g: Pen, view: MapView): void {
  const size = clamp(0.9 * Math.sqrt(view.scale), 1.6, 3), pixel = pixelOf(g);
  const lines = visibleLines(view, size);
  g.strokeStyle = g.fillStyle = palette.initial;
  g.lineWidth = lines.length > MANY ? pixel : 0.8;
  g.globalAlpha = 0.7;
  g.beginPath();
  for (const [x, y, endX, endY] of lines) {
    g.moveTo(x, y);
    g.lineTo(endX, endY);
  }
  g.stroke();
  g.globalAlpha = 1;
  for (const [x, y] of lines) fillSquare(g, x, y, size, pixel);
}

/** Those that may be seen, each by its two ends on the screen. */
function visibleLines(view: MapView, margin: number): number[][] {
  const { landmarks, width, height } = view;
  const [a, b] = view.axes.map((axis) => landmarks[`i${axis}`]);
  return Array.from(landmarks.id, (_, i) => [...view.toScreen(a[i], b[i]), ...view.landmarkAt(i)])
    // What is compared with NaN is false: a landmark whose initial position is not known is left out.
    .filter(([x, y, endX, endY]) => Math.max(x, endX) > -margin && Math.min(x, endX) < width + margin &&
      Math.max(y, endY) > -margin && Math.min(y, endY) < height + margin);
}
