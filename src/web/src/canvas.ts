// Drawing helpers that the maps and the boxes share.
import { clamp } from './data';
import { download } from './files';
import { grouped, number } from './format';
import { palette } from './theme';

export type Pen = CanvasRenderingContext2D;
export interface KeyEntry { text: string; colour: string; dash?: number[] }

export const FONT_FAMILY = 'system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
const FONT = `11.5px ${FONT_FAMILY}`;

const context = (canvas: HTMLCanvasElement): Pen => {
  const pen = canvas.getContext('2d');
  if (!pen) throw new Error('the browser gives no canvas');
  return pen;
};

/** Fits the canvas's pixels to its size on the screen; returns its context in css pixels. */
export function prepareCanvas(canvas: HTMLCanvasElement, width: number, height: number): Pen {
  const ratio = Math.max(window.devicePixelRatio || 1, 2);
  const g = context(canvas), size = [Math.round(width * ratio), Math.round(height * ratio)];
  // To be given another size costs more than to be cleared.
  if (canvas.width === size[0] && canvas.height === size[1] && 'reset' in g) g.reset();
  else [canvas.width, canvas.height] = size;
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, width, height);
  g.font = FONT;
  g.lineJoin = 'round';
  return g;
}

/** A step of 1, 2 or 5 times a power of ten, so that the range has about `wanted` of them. */
export function niceStep(range: number, wanted: number): number {
  const raw = range / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(raw));
  const factor = [1, 2, 5, 10].find((f) => f * power >= raw * 0.999) ?? 10;
  return factor * power;
}

export const ticksOf = (low: number, high: number, wanted: number): number[] =>
  (high > low ? multiplesOf(niceStep(high - low, wanted), low, high) : []);

/** The multiples of a step in a range; none so far out that a number does not distinguish neighbours. */
export function multiplesOf(step: number, low: number, high: number): number[] {
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  const multiples: number[] = [];
  if (!Number.isSafeInteger(first) || !Number.isSafeInteger(last)) return multiples;
  for (let k = first; k <= last; k++) multiples.push(k * step);
  return multiples;
}

export function tickText(v: number, step: number): string {
  const decimals = clamp(-Math.floor(Math.log10(step) + 1e-9), 0, 6);
  return Math.abs(v) >= 1e5 ? number(v) : grouped(Math.abs(v) < step / 1e3 ? 0 : v, decimals);
}

/** Strokes a polyline; non-finite points break it. Points within a third of a pixel of the last one
 *  are left out: nobody sees them, and a long run has hundreds on each pixel. */
export function polyline(g: Pen, n: number, xOf: (i: number) => number, yOf: (i: number) => number):
    void {
  g.beginPath();
  let pen = false, skipped = false;
  let x = 0, y = 0, keptX = 0, keptY = 0;
  for (let i = 0; i < n; i++) {
    const nextX = xOf(i), nextY = yOf(i), known = Number.isFinite(nextX + nextY);
    if (skipped && !known) g.lineTo(x, y);
    skipped = known && pen && Math.abs(nextX - keptX) < 0.33 && Math.abs(nextY - keptY) < 0.33;
    [x, y] = [nextX, nextY];
    if (known && !skipped) {
      if (pen) g.lineTo(x, y); else g.moveTo(x, y);
      [keptX, keptY] = [x, y];
    }
    pen = known;
  }
  if (skipped) g.lineTo(x, y);
  g.stroke();
}

/** Half axes and direction of the 95 % ellipse of the covariance [[a, b], [b, c]]. */
export function ellipseOf(a: number, b: number, c: number) {
  const middle = (a + c) / 2, half = Math.hypot((a - c) / 2, b);
  // 5.991: the 95 % quantile of chi-square with two degrees of freedom.
  return {
    major: Math.sqrt(5.991 * Math.max(0, middle + half)),
    minor: Math.sqrt(5.991 * Math.max(0, middle - half)),
    angle: 0.5 * Math.atan2(2 * b, a - c),
  };
}

export function drawDot(g: Pen, x: number, y: number, colour: string): void {
  if (!Number.isFinite(y)) return;
  g.fillStyle = colour;
  g.beginPath();
  g.arc(x, y, 3, 0, 2 * Math.PI);
  g.fill();
}

/** A canvas as a PNG file, with a title and an explanation above it, and a key of lines. */
export function downloadPng(name: string, canvas: HTMLCanvasElement, title: string, note: string,
    key: KeyEntry[] = []): void {
  const out = document.createElement('canvas');
  const ratio = canvas.width / canvas.clientWidth, room = canvas.clientWidth - 20;
  const g = context(out);
  const rows = keyRows(g, key, room);
  const head = (46 + 16 * rows.length) * ratio;
  out.width = canvas.width;
  out.height = canvas.height + head;
  g.fillStyle = palette.panel;
  g.fillRect(0, 0, out.width, out.height);
  g.drawImage(canvas, 0, head);
  g.scale(ratio, ratio);
  g.fillStyle = palette.ink;
  g.font = FONT.replace('11.5px', '600 14px');
  g.fillText(title, 10, 20, room);
  g.fillStyle = palette.muted;
  g.font = FONT;
  g.fillText(note, 10, 38, room);
  rows.forEach((row, k) => row.forEach((entry) => drawKey(g, entry, 52 + 16 * k)));
  out.toBlob((blob) => { if (blob) download(name + '.png', blob); });
}

/** The entries of a key in rows of that width, each with its x. */
function keyRows(g: Pen, key: KeyEntry[], width: number): (KeyEntry & { x: number })[][] {
  const rows: (KeyEntry & { x: number })[][] = [];
  let x = Infinity;
  g.font = FONT;
  for (const entry of key) {
    const wide = 46 + g.measureText(entry.text).width;
    if (x + wide > width) {
      rows.push([]);
      x = 10;
    }
    rows[rows.length - 1].push({ ...entry, x });
    x += wide;
  }
  return rows;
}

function drawKey(g: Pen, { text, colour, dash, x }: KeyEntry & { x: number }, y: number): void {
  g.strokeStyle = palette[colour];
  g.lineWidth = 2;
  g.setLineDash(dash ?? []);
  g.beginPath();
  g.moveTo(x, y);
  g.lineTo(x + 26, y);
  g.stroke();
  g.setLineDash([]);
  g.fillStyle = palette.ink;
  g.textBaseline = 'middle';
  g.fillText(text, x + 32, y);
}

