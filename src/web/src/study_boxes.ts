// Distributions over the runs: for each filter its runs as dots and a box.
import { downloadPng, type Pen, prepareCanvas, tickText, ticksOf } from './canvas';
import { clamp, extremes, mean } from './data';
import { downloadCsv, fileName, type CsvColumn } from './files';
import { button, byId, make, number } from './format';
import { throttled } from './store';
import { activeStudy, figuresOf, type Study } from './studies';
import { filterColour, shownFilters } from './study_colours';
import { DEGREES_OF_POSE } from './study_tables';
import { faded, palette } from './theme';

const BOX_ROW = 44, BOX_AXIS = 24;

/** Columns of the trials, in the unit that is drawn, with the value of a consistent filter. */
interface Measure {
  column: string; title: string; unit: string; scale: number; expected?: number; caption?: string;
}

export const MEASURES: Measure[] = [
  { column: 'position_error', title: 'Position error of each run', unit: 'm', scale: 1 },
  { column: 'attitude_error', title: 'Attitude error of each run', unit: '°', scale: 1 },
  { column: 'nees_pose', title: 'Pose NEES of each run, per degree of freedom', unit: '',
    scale: 1 / DEGREES_OF_POSE, expected: 1,
    caption: 'Dashed: 1, the mean of a consistent filter’s runs, with the χ² band in which 95 % of such ' +
      'means lie at one instant; diamonds: the means. Single runs scatter more, for what a run has at one ' +
      'time it still has at the next.' },
];

/** Quantile of a sorted list, between its entries where it lies there. */
function sortedQuantile(sorted: number[], q: number): number {
  const at_ = q * (sorted.length - 1), i = Math.floor(at_);
  return i + 1 < sorted.length ? sorted[i] + (at_ - i) * (sorted[i + 1] - sorted[i]) : sorted[i];
}

/** The runs of a filter that have a value, and the box around them; null without any. */
interface Box {
  runs: { run: number; value: number }[];
  q1: number; median: number; q3: number; low: number; high: number;
}

export function boxOf(study: Study, k: number, measure: Measure): Box | null {
  const { trials } = study;
  const runs: Box['runs'] = [];
  for (let i = 0; i < trials.run.length; i++) {
    const value = trials[measure.column][i] * measure.scale;
    if (trials.filter[i] !== k || trials.diverged[i] || !Number.isFinite(value)) continue;
    runs.push({ run: trials.run[i], value });
  }
  if (!runs.length) return null;
  const sorted = runs.map((r) => r.value).sort((a, b) => a - b);
  const [q1, median, q3] = [0.25, 0.5, 0.75].map((q) => sortedQuantile(sorted, q));
  const reach = 1.5 * (q3 - q1);
  return { runs, q1, median, q3,
    low: sorted.find((v) => v >= q1 - reach) ?? q1,
    high: sorted.filter((v) => v <= q3 + reach).pop() ?? q3 };
}

const divergedOf = (study: Study, k: number): number => {
  let n = 0;
  study.trials.filter.forEach((f, i) => { if (f === k && study.trials.diverged[i]) n++; });
  return n;
};

export class BoxPlot {
  readonly element: HTMLElement;
  readonly draw = throttled(() => this.drawNow());
  private readonly canvas: HTMLCanvasElement;
  private readonly readout = make('div', { class: 'readout' });
  private width = 0;
  private height = 0;
  private log = false;
  private limits: [number, number] = [0, 1];
  private x: (v: number) => number = () => 0;
  private dots: { x: number; y: number; run: number; value: number; k: number }[] = [];

  constructor(private readonly measure: Measure) {
    this.canvas = make('canvas', { role: 'img', 'aria-label': `${measure.title}: a box and dots for ` +
      'each filter. The tables above have the means and medians.' });
    const png = () => downloadPng(fileName(activeStudy().name, measure.title), this.canvas,
      `${measure.title} – ${activeStudy().name}`, 'dots: runs; box: middle half, with the median');
    const csv = () => downloadCsv(fileName(activeStudy().name, measure.title), this.columns());
    this.element = make('figure', { class: 'panel plot box-plot' },
      make('div', { class: 'panel-head' },
        make('h3', {}, measure.title + (measure.unit ? ` [${measure.unit}]` : '')),
        make('div', { class: 'small-buttons' },
          button('PNG', 'Save as picture', png), button('CSV', 'Save the numbers', csv))),
      this.canvas, this.readout, measure.caption
        ? make('figcaption', { class: 'muted small' }, measure.caption) : null);
    this.canvas.addEventListener('pointermove', (e) => this.point(e));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  private columns(): CsvColumn[] {
    return shownFilters().flatMap((k) => {
      const box = boxOf(activeStudy(), k, this.measure);
      const label = activeStudy().filters[k].label;
      return box ? [{ label: `run of ${label}`, values: box.runs.map((r) => r.run) },
        { label, values: box.runs.map((r) => r.value) }] : [];
    });
  }

  /** The axis over all boxes; logarithmic where the runs span decades. */
  private setScale(boxes: (Box | null)[]): void {
    const values = boxes.flatMap((b) => (b ? b.runs.map((r) => r.value) : []));
    if (this.measure.expected) values.push(this.measure.expected);
    const [low, high] = extremes(values);
    this.log = low > 0 && high / low > 20;
    const map = this.log ? Math.log10 : (v: number) => v;
    const room = 0.04 * (map(high) - map(low) || Math.abs(map(high)) || 1);
    const from = this.log ? map(low) - room : Math.max(0, map(low) - room), to = map(high) + room;
    this.limits = values.length ? [from, to] : [0, 1];
    this.x = (v) => 10 + ((map(v) - from) / (to - from)) * (this.width - 20);
  }

  drawNow(): void {
    this.width = this.canvas.clientWidth;
    if (!this.width) return;
    const filters = shownFilters();
    const boxes = filters.map((k) => boxOf(activeStudy(), k, this.measure));
    this.height = Math.max(1, filters.length) * BOX_ROW + BOX_AXIS;
    this.canvas.style.height = this.height + 'px';
    const g = prepareCanvas(this.canvas, this.width, this.height);
    this.setScale(boxes);
    this.dots = [];
    this.drawAxis(g);
    filters.forEach((k, row) => this.drawRow(g, k, boxes[row], row * BOX_ROW));
  }

  private ticks(): number[] {
    const [low, high] = this.limits;
    if (!this.log) return ticksOf(low, high, this.width / 90);
    const ticks = [];
    for (let e = Math.floor(low); e <= high; e++) {
      for (const f of high - low > 1.5 ? [1] : [1, 2, 5]) ticks.push(f * 10 ** e);
    }
    return ticks.filter((v) => Math.log10(v) >= low && Math.log10(v) <= high);
  }

  private drawAxis(g: Pen): void {
    const bottom = this.height - BOX_AXIS;
    const ticks = this.ticks(), step = ticks.length > 1 ? ticks[1] - ticks[0] : 1;
    g.textAlign = 'center';
    g.textBaseline = 'top';
    g.lineWidth = 1;
    for (const v of ticks) {
      const x = Math.round(this.x(v)) + 0.5;
      g.strokeStyle = palette.line;
      g.beginPath();
      g.moveTo(x, 0);
      g.lineTo(x, bottom);
      g.stroke();
      g.fillStyle = palette.muted;
      const text = this.log ? String(Number(v.toPrecision(1))) : tickText(v, step);
      const half = g.measureText(text).width / 2;
      g.fillText(text, clamp(x, half, this.width - half), bottom + 5);
    }
    if (!this.measure.expected) return;
    this.drawBand(g, bottom);
    g.strokeStyle = palette.good;
    g.lineWidth = 1.4;
    g.setLineDash([5, 4]);
    const x = this.x(this.measure.expected);
    g.beginPath();
    g.moveTo(x, 0);
    g.lineTo(x, bottom);
    g.stroke();
    g.setLineDash([]);
  }

  /** The band of the filter with the most runs: it is the narrowest. */
  private drawBand(g: Pen, bottom: number): void {
    const bands = figuresOf(activeStudy()).flatMap((f) => (Array.isArray(f.band) ? [f.band] : []));
    if (!bands.length) return;
    const [low, high] = bands.reduce((a, b) => (b[1] - b[0] < a[1] - a[0] ? b : a));
    const [left, right] = [low, high].map((v) => clamp(this.x(v), 0, this.width));
    g.fillStyle = faded('good', 0.16);
    g.fillRect(left, 0, right - left, bottom);
  }

  private drawMean(g: Pen, box: Box, middle: number): void {
    const x = this.x(mean(box.runs.map((r) => r.value)));
    g.beginPath();
    for (const [dx, dy] of [[-5, 0], [0, -5], [5, 0], [0, 5]]) g.lineTo(x + dx, middle + dy);
    g.closePath();
    g.fillStyle = palette.panel;
    g.fill();
    g.lineWidth = 1.6;
    g.stroke();
  }

  private drawRow(g: Pen, k: number, box: Box | null, top: number): void {
    const colour = palette[filterColour(k)], diverged = divergedOf(activeStudy(), k);
    this.drawRowLabel(g, k, diverged, top);
    if (!box) return;
    const middle = top + 29, half = 8;
    g.fillStyle = g.strokeStyle = colour;
    g.globalAlpha = 0.5;
    box.runs.forEach(({ run, value }, i) => {
      // Spread evenly, the same in every drawing.
      const y = middle + half * (2 * ((i * 0.618034) % 1) - 1);
      this.dots.push({ x: this.x(value), y, run, value, k });
      g.beginPath();
      g.arc(this.x(value), y, 1.7, 0, 2 * Math.PI);
      g.fill();
    });
    g.globalAlpha = 0.22;
    g.fillRect(this.x(box.q1), middle - half, this.x(box.q3) - this.x(box.q1), 2 * half);
    g.globalAlpha = 1;
    g.lineWidth = 1.3;
    g.strokeRect(this.x(box.q1), middle - half, this.x(box.q3) - this.x(box.q1), 2 * half);
    g.beginPath();
    for (const [from, to] of [[box.low, box.q1], [box.q3, box.high]]) {
      g.moveTo(this.x(from), middle);
      g.lineTo(this.x(to), middle);
    }
    g.stroke();
    g.lineWidth = 2.6;
    g.beginPath();
    g.moveTo(this.x(box.median), middle - half);
    g.lineTo(this.x(box.median), middle + half);
    g.stroke();
    if (this.measure.expected) this.drawMean(g, box, middle);
  }

  private drawRowLabel(g: Pen, k: number, diverged: number, top: number): void {
    g.textAlign = 'left';
    g.textBaseline = 'top';
    const tail = diverged ? `${diverged} diverged` : '';
    const room = this.width - 10 - (tail ? g.measureText(tail).width + 14 : 0);
    const label = shortened(g, activeStudy().filters[k].label, room);
    g.fillStyle = palette.panel;
    g.globalAlpha = 0.85;
    g.fillRect(4, top + 3, g.measureText(label).width + 5, 14);
    g.globalAlpha = 1;
    g.fillStyle = palette.ink;
    g.fillText(label, 6, top + 4);
    g.textAlign = 'right';
    g.fillStyle = palette.bad;
    g.fillText(tail, this.width - 4, top + 4);
  }

  private point(e: PointerEvent): void {
    let best: (typeof this.dots)[number] | null = null, nearest = 12;
    for (const dot of this.dots) {
      const distance = Math.hypot(dot.x - e.offsetX, dot.y - e.offsetY);
      if (distance < nearest) [best, nearest] = [dot, distance];
    }
    this.readout.textContent = best ? `${activeStudy().filters[best.k].label}, run ${best.run}: ` +
      `${number(best.value)} ${this.measure.unit}` : '';
  }
}

function shortened(g: Pen, text: string, room: number): string {
  let end = text.length;
  while (end > 1 && g.measureText(text.slice(0, end) + '…').width > room) end--;
  return g.measureText(text).width <= room ? text : text.slice(0, end) + '…';
}

let boxes: BoxPlot[] = [];

export const boxPlots = (): readonly BoxPlot[] => boxes;

export function showBoxes(): void {
  const study = activeStudy();
  boxes = study.trials.run.length ? MEASURES.map((measure) => new BoxPlot(measure)) : [];
  byId('boxes').replaceChildren(...boxes.map((plot) => plot.element));
  byId('boxes-head').hidden = byId('boxes').hidden = boxes.length === 0;
}
