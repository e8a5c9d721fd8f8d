// A chart on a canvas with two axes, for what is no plot over the states of a run.
import { type Pen, niceStep, prepareCanvas, tickText, ticksOf } from './canvas';
import { clamp } from './data';
import { make, number } from './format';
import { listen } from './store';
import { palette, ramp } from './theme';

export interface Scale {
  label: string;
  /** At the left or the bottom; may be the greater one. */
  low: number;
  high: number;
  log?: boolean;
  /** At 0, 1, …, instead of numbers. */
  names?: string[];
}

export interface ColourScale { label: string; low: number; high: number; log?: boolean }

/** Where the numbers are [css px]. */
export interface Place {
  left: number;
  top: number;
  width: number;
  height: number;
  x: (v: number) => number;
  y: (v: number) => number;
}

export interface ChartForm {
  /** What is to be seen, for those who do not see it. */
  label: string;
  x: Scale;
  y: Scale;
  /** The height of the plot, or its ratio to the width. */
  height?: number;
  aspect?: number;
  colours?: ColourScale;
  draw: (g: Pen, place: Place) => void;
  /** What is at a point; null: nothing. */
  tip?: (x: number, y: number, place: Place) => string | null;
}

const TOP = 6, BOTTOM = 36, BAR = 58;

const share = ({ low, high, log }: { low: number; high: number; log?: boolean }, v: number): number =>
  (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low));
const valueAt = ({ low, high, log }: Scale, s: number): number =>
  (log ? low * (high / low) ** s : low + s * (high - low));

/** The colour of a value. */
export const colourAt = (scale: ColourScale, v: number): string => ramp(share(scale, v));

function ticks(scale: { low: number; high: number; log?: boolean }, wanted: number):
    { v: number; text: string }[] {
  const low = Math.min(scale.low, scale.high), high = Math.max(scale.low, scale.high);
  if (!scale.log) {
    const step = niceStep(high - low, wanted);
    return ticksOf(low, high, wanted).map((v) => ({ v, text: tickText(v, step) }));
  }
  const decades = Math.log10(high / low), factors = decades < 2.2 ? [1, 2, 5] : [1];
  const list: { v: number; text: string }[] = [];
  const stride = Math.max(1, Math.ceil(decades / wanted));
  for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high); k++) {
    if (k % stride) continue;
    for (const v of factors.map((f) => f * 10 ** k)) {
      if (v >= low * 0.999 && v <= high * 1.001) list.push({ v, text: number(v, 1).replace('.00e', 'e') });
    }
  }
  return list;
}

function placeOf(g: Pen, form: ChartForm, width: number): Place {
  const names = form.y.names ?? ticks(form.y, 5).map(({ text }) => text);
  const left = 22 + Math.max(14, ...names.map((text) => g.measureText(text).width));
  const wide = Math.max(40, width - left - (form.colours ? BAR : 10));
  const height = form.height ?? wide * (form.aspect ?? 1);
  return {
    left, top: TOP, width: wide, height,
    x: (v) => left + wide * share(form.x, v),
    y: (v) => TOP + height * (1 - share(form.y, v)),
  };
}

/** Of so many names along an axis one is written. */
const everyName = (names: string[], length: number): number =>
  Math.max(1, Math.ceil(11 * names.length / length));

/** The room below the plot: for the numbers of x and its label, or for its names from below. */
function roomBelow({ x }: ChartForm, { width }: Place): number {
  if (!x.names) return BOTTOM;
  return everyName(x.names, width) > 1 ? 6 : 8 + 6.2 * Math.max(...x.names.map((name) => name.length));
}

function drawNames(g: Pen, { x, y }: ChartForm, place: Place): void {
  const every = everyName(y.names ?? [], place.height);
  g.textAlign = 'right';
  y.names?.forEach((name, i) => { if (i % every === 0) g.fillText(name, place.left - 6, place.y(i)); });
  if (everyName(x.names ?? [], place.width) > 1) return;
  x.names?.forEach((name, i) => {
    g.save();
    g.translate(place.x(i), place.top + place.height + 6);
    g.rotate(-Math.PI / 2);
    g.fillText(name, 0, 0);
    g.restore();
  });
}

function drawAxes(g: Pen, form: ChartForm, place: Place): void {
  const { left, top, width, height } = place;
  g.fillStyle = palette.muted;
  g.strokeStyle = palette.line;
  g.textBaseline = 'middle';
  if (form.y.names) return drawNames(g, form, place);
  g.lineWidth = 1;
  g.textAlign = 'right';
  for (const { v, text } of ticks(form.y, height / 45)) {
    g.strokeRect(left, place.y(v), width, 0);
    g.fillText(text, left - 6, place.y(v));
  }
  g.textAlign = 'center';
  for (const { v, text } of ticks(form.x, width / 75)) {
    g.strokeRect(place.x(v), top, 0, height);
    g.fillText(text, clamp(place.x(v), left + 4, left + width - 4), top + height + 11);
  }
  g.fillText(form.x.label, left + width / 2, top + height + 27);
  g.save();
  g.translate(7, top + height / 2);
  g.rotate(-Math.PI / 2);
  g.fillText(form.y.label, 0, 0);
  g.restore();
}

function drawColours(g: Pen, colours: ColourScale, { left, top, width, height }: Place): void {
  const x = left + width + 8, rows = 60;
  for (let k = 0; k < rows; k++) {
    g.fillStyle = ramp(1 - (k + 0.5) / rows);
    g.fillRect(x, top + height * k / rows, 9, height / rows + 0.6);
  }
  g.fillStyle = palette.muted;
  g.textAlign = 'left';
  for (const { v, text } of ticks(colours, height / 30)) {
    g.fillText(text, x + 13, clamp(top + height * (1 - share(colours, v)), top + 5, top + height - 5));
  }
  g.textAlign = 'right';
  g.fillText(colours.label, left + width + BAR - 2, top + height + 11);
}

/** The chart of that form, which follows its width, the theme and the print. */
export function chart(form: ChartForm): HTMLElement {
  const canvas = make('canvas', { role: 'img', 'aria-label': form.label });
  const tip = make('div', { class: 'tip', hidden: '' });
  const figure = make('figure', { class: 'chart' }, canvas, tip);
  let place: Place | null = null;
  const redraw = () => {
    const width = figure.clientWidth;
    if (!width) return;
    place = placeOf(prepareCanvas(canvas, width, 1), form, width);
    const height = TOP + place.height + roomBelow(form, place);
    canvas.style.height = `${height}px`;
    const g = prepareCanvas(canvas, width, height);
    drawAxes(g, form, place);
    if (form.colours) drawColours(g, form.colours, place);
    g.save();
    g.beginPath();
    g.rect(place.left, place.top, place.width, place.height);
    g.clip();
    form.draw(g, place);
    g.restore();
  };
  const show = ({ offsetX, offsetY }: PointerEvent) => {
    if (!place || !form.tip) return;
    const [s, t] = [(offsetX - place.left) / place.width, 1 - (offsetY - place.top) / place.height];
    const inside = Math.min(s, t) >= 0 && Math.max(s, t) <= 1;
    const text = inside ? form.tip(valueAt(form.x, s), valueAt(form.y, t), place) : null;
    tip.hidden = text === null;
    if (text === null) return;
    tip.textContent = text;
    tip.style.left = `${clamp(offsetX + 14, 0, Math.max(0, figure.clientWidth - tip.offsetWidth - 2))}px`;
    tip.style.top = `${offsetY + 16}px`;
  };
  canvas.addEventListener('pointermove', show);
  canvas.addEventListener('pointerdown', show);
  canvas.addEventListener('pointerleave', () => { tip.hidden = true; });
  new ResizeObserver(redraw).observe(figure);
  listen('theme', redraw);
  listen('print', redraw);
  return figure;
}
