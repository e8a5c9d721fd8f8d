// A camera's picture with what was followed into it. The colours are the same in every theme: they stand
// on a picture. Shapes differ as the colours do, so that neither is needed to distinguish them.
import type { Pen } from './canvas';
import type { CameraImages, Outcome, Point } from './images';

export interface ImageOptions {
  show: Record<Outcome | 'ellipses' | 'tails', boolean>;
  /** How many times as large ellipses and innovations are drawn. */
  enlarged: number;
}

export const OUTCOME_COLOURS: Record<Outcome, string> = {
  used: '#4fc6ff', rejected: '#ff7b3d', begun: '#ffe24a', waiting: '#f4f4f4',
};
const EMPTY = '#1d232c', EDGE = 'rgba(8, 12, 18, .75)';
const MARK = 3.2;  // half the size of a cross or square [css px]

/** Draws twice, a dark edge first. */
function edged(g: Pen, colour: string, width: number, trace: () => void): void {
  for (const [style, wide] of [[EDGE, width + 1.8], [colour, width]] as const) {
    g.strokeStyle = style;
    g.lineWidth = wide;
    g.beginPath();
    trace();
    g.stroke();
  }
}

function traceMark(g: Pen, outcome: Outcome, x: number, y: number): void {
  if (outcome === 'begun') {
    g.rect(x - MARK, y - MARK, 2 * MARK, 2 * MARK);
  } else if (outcome === 'rejected') {
    g.moveTo(x - MARK, y - MARK);
    g.lineTo(x + MARK, y + MARK);
    g.moveTo(x - MARK, y + MARK);
    g.lineTo(x + MARK, y - MARK);
  } else {
    g.arc(x, y, outcome === 'used' ? 1.9 : 1.2, 0, 2 * Math.PI);
  }
}

/** A mark as pictures have it; the legend's too. */
export function drawMark(g: Pen, outcome: Outcome, x: number, y: number): void {
  edged(g, OUTCOME_COLOURS[outcome], outcome === 'rejected' ? 2.2 : 1.6, () => traceMark(g, outcome, x, y));
  if (outcome !== 'used') return;
  g.fillStyle = OUTCOME_COLOURS.used;
  g.fill();
}

/** The 3 sigma ellipse about where the point was expected. The mark stays where it was seen; the
 *  ellipse is `enlarged` about it, so that a mark outside of it stays outside. */
function drawEllipse(g: Pen, p: Point, scale: number, enlarged: number): void {
  const e = p.expected;
  if (!e) return;
  const middle = (e.uu + e.vv) / 2, half = Math.hypot((e.uu - e.vv) / 2, e.uv);
  const radius = (variance: number) => 3 * Math.sqrt(Math.max(0, variance)) * enlarged * scale;
  edged(g, OUTCOME_COLOURS[p.outcome], 1.1, () => g.ellipse(
    (p.u + enlarged * (e.u - p.u)) * scale, (p.v + enlarged * (e.v - p.v)) * scale,
    radius(middle + half), radius(middle - half), 0.5 * Math.atan2(2 * e.uv, e.uu - e.vv),
    0, 2 * Math.PI));
}

function drawTail(g: Pen, { u, v, before, outcome }: Point, scale: number): void {
  if (!before) return;
  edged(g, OUTCOME_COLOURS[outcome], 1.4, () => {
    g.moveTo(before[0] * scale, before[1] * scale);
    g.lineTo(u * scale, v * scale);
  });
}

/** In a canvas as wide as `width` [css px]; points that matter most come last. */
export function drawImage(g: Pen, images: CameraImages, picture: ImageBitmap | null, points: Point[],
    { show, enlarged }: ImageOptions, width: number): void {
  const scale = width / images.width, height = images.height * scale;
  g.fillStyle = EMPTY;
  g.fillRect(0, 0, width, height);
  if (picture) g.drawImage(picture, 0, 0, width, height);
  for (const outcome of ['waiting', 'begun', 'used', 'rejected'] as const) {
    if (!show[outcome]) continue;
    const own = points.filter((p) => p.outcome === outcome);
    if (show.tails) for (const p of own) drawTail(g, p, scale);
    if (show.ellipses) for (const p of own) drawEllipse(g, p, scale, enlarged);
    for (const p of own) drawMark(g, outcome, p.u * scale, p.v * scale);
  }
}
