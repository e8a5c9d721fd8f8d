// A panel of a plot over time: a uPlot with the page's common cursor and time span.
import uPlot from 'uplot';

import { at, clamp, type Values } from './data';
import { make } from './format';
import { isKnown, panelLimits, tickTexts, unwell, valueTicks } from './plot_scale';
import { isBand, type Panel, panelTitle, type PlotSpec, type Series } from './plot_spec';
import { activeSubject, app, setCursorTime, setSpan, showAllTimes } from './store';
import { faded, palette } from './theme';

const LEFT = 54, RIGHT = 10, AXIS_HEIGHT = 26, FONT = '11px system-ui, sans-serif';

/** Between the ticks of the time axis [s]: steps whose texts are short and exact. */
const STEPS = Array.from({ length: 42 }, (_, k) => [1, 2, 5][k % 3] * 10 ** (Math.floor(k / 3) - 5));

/** What uPlot draws: gaps are null. */
const known = (values: Values, n: number): (number | null)[] =>
  Array.from({ length: n }, (_, i) => (isKnown(values, i) ? at(values, i) : null));

/** What a panel needs of its plot. */
interface PanelHost {
  readonly spec: PlotSpec;
  /** Labels of the series that are switched off. */
  readonly hidden: ReadonlySet<string>;
}

/** A panel of the plot: made when it comes near the screen, for there may be many rows. */
export class PlotPanel {
  readonly element = make('div', { class: 'plot-panel' });
  private chart: uPlot | null = null;
  private readonly host = make('div', { class: 'plot-host' });
  private readonly cursorLine = make('div', { class: 'time-cursor' });
  private readonly summary = make('span', { class: 'muted' });
  /** The chart does not have the panel's numbers yet. */
  private outdated = false;

  constructor(private readonly plot: PanelHost, public panel: Panel, private readonly last: boolean) {
    this.summary.textContent = panel.summary ?? '';
    this.element.append(make('div', { class: 'plot-label' }, make('span', {}, panelTitle(panel)),
      this.summary), this.host);
    this.host.style.height = `${this.height()}px`;
  }

  private height(): number {
    return (this.plot.spec.height ?? 104) + 4 + (this.last ? AXIS_HEIGHT : 8);
  }

  drawn(): Series[] {
    return this.panel.series.filter((s) => !this.plot.hidden.has(s.label));
  }

  show(width: number): void {
    if (this.chart) this.chart.setSize({ width, height: this.height() });
    else this.create(width);
    this.moveCursor();
  }

  private create(width: number): void {
    const series: uPlot.Series[] = [{}], bands: uPlot.Band[] = [];
    for (const s of this.panel.series) {
      const show = !this.plot.hidden.has(s.label);
      if (isBand(s) && s.low !== undefined && s.high !== undefined) {
        const opacity = s.style === 'stack' ? 0.6 : 0.25;
        bands.push({ series: [series.length, series.length + 1],
          fill: () => faded(s.colour, opacity) });
        series.push(this.edge(s, show), this.edge(s, show));
      } else if (s.values !== undefined) {
        series.push(this.line(s, show));
      }
    }
    this.outdated = false;
    this.chart = new uPlot(this.options(width, series, bands), this.data(), this.host);
    this.chart.over.append(this.cursorLine);
    this.listenToTouch(this.chart);
  }

  /** Times, and what each line of the chart is at them. */
  private data(): uPlot.AlignedData {
    const { count, t } = activeSubject();
    const columns = this.panel.series.flatMap((s) => {
      if (isBand(s) && s.low !== undefined && s.high !== undefined) {
        return [known(s.high, count), known(s.low, count)];
      }
      return s.values === undefined ? [] : [known(s.values, count)];
    });
    return [Array.from(t), ...columns] as uPlot.AlignedData;
  }

  /** The same series with other numbers, which the next redraw shows. */
  update(panel: Panel): void {
    this.panel = panel;
    this.summary.textContent = panel.summary ?? '';
    this.outdated = true;
  }

  private edge(s: Series, show: boolean): uPlot.Series {
    return { show, stroke: () => faded(s.colour, 0.75), width: 0.8, points: { show: false } };
  }

  private line(s: Series, show: boolean): uPlot.Series {
    const single = () => activeSubject().count === 1;
    return {
      show, stroke: () => palette[s.colour], width: s.style === 'line' ? 1.4 : 1,
      dash: s.dash?.length ? s.dash : s.style === 'level' ? [5, 4] : [],
      points: { show: single, size: 6, fill: () => palette[s.colour] },
      ...(s.style === 'area' ? { fill: () => faded(s.colour, 0.4), fillTo: 0 } : {}),
    };
  }

  private options(width: number, series: uPlot.Series[], bands: uPlot.Band[]): uPlot.Options {
    const axis: uPlot.Axis = { font: FONT, stroke: () => palette.muted,
      grid: { stroke: () => palette.line, width: 1 }, ticks: { show: false } };
    return {
      width, height: this.height(), series, bands, padding: [4, RIGHT, this.last ? 0 : 4, 0],
      legend: { show: false },
      cursor: { x: false, y: false, points: { show: false }, drag: { x: true, y: false, setScale: false },
        bind: { dblclick: () => () => { showAllTimes(); return null; } } },
      scales: { x: { time: false, range: () => app.span },
        y: { distr: this.panel.log ? 3 : 1, range: () => panelLimits(this.panel, this.drawn()) } },
      axes: [
        { ...axis, show: this.last, size: AXIS_HEIGHT, gap: 4, space: 70, incrs: STEPS,
          values: (_, ticks) => tickTexts(ticks).map((text, k) =>
            (k === ticks.length - 1 ? text + ' s' : text)) },
        { ...axis, size: LEFT, gap: 6,
          splits: (_, __, low, high) => valueTicks([low, high], this.panel.log),
          filter: (_, ticks) => ticks, values: (_, ticks) => tickTexts(ticks, this.panel.log) },
      ],
      hooks: { drawClear: [drawHealth], draw: [drawFrame], setCursor: [followPointer],
        setSelect: [zoomToSelection] },
    };
  }

  /** uPlot answers to the mouse; a finger moves the cursor, and scrolls the page up and down. */
  private listenToTouch(chart: uPlot): void {
    const move = (e: PointerEvent) => {
      if (e.pointerType !== 'mouse') setCursorTime(chart.posToVal(e.offsetX, 'x'));
    };
    chart.over.addEventListener('pointerdown', move);
    chart.over.addEventListener('pointermove', move);
  }

  /** Draws anew: another time span, theme or choice of series. */
  redraw(): void {
    const { chart } = this;
    if (!chart) return;
    chart.batch(() => {
      if (this.outdated) chart.setData(this.data(), false);
      this.outdated = false;
      let k = 1;
      for (const s of this.panel.series) {
        const show = !this.plot.hidden.has(s.label);
        const lines = isBand(s) ? 2 : s.values === undefined ? 0 : 1;
        for (let i = 0; i < lines; i++, k++) {
          if (chart.series[k].show !== show) chart.setSeries(k, { show });
        }
      }
      chart.setScale('x', { min: app.span[0], max: app.span[1] });
      chart.redraw(true, true);
    });
    this.moveCursor();
  }

  moveCursor(): void {
    const t = activeSubject().t[app.cursor];
    const visible = this.chart !== null && t >= app.span[0] && t <= app.span[1];
    this.cursorLine.hidden = !visible;
    if (!this.chart || !visible) return;
    const share = (t - app.span[0]) / (app.span[1] - app.span[0]);
    this.cursorLine.style.left = `${100 * share}%`;
  }

  destroy(): void {
    this.chart?.destroy();
    this.chart = null;
  }
}

/** Shades the times at which the filter did not call itself well. */
function drawHealth({ ctx, bbox, valToPos }: uPlot): void {
  for (const [from, to, name] of unwell()) {
    const left = clamp(valToPos(from, 'x', true), bbox.left, bbox.left + bbox.width);
    const right = clamp(valToPos(to, 'x', true), bbox.left, bbox.left + bbox.width);
    if (right <= bbox.left || left >= bbox.left + bbox.width) continue;
    ctx.fillStyle = faded(name === 'lost' ? 'bad' : 'warn', 0.16);
    ctx.fillRect(left, bbox.top, Math.max(1, right - left), bbox.height);
  }
}

function drawFrame({ ctx, bbox }: uPlot): void {
  ctx.strokeStyle = palette.line;
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([]);
  ctx.strokeRect(bbox.left, bbox.top, bbox.width, bbox.height);
}

function followPointer(chart: uPlot): void {
  const { left, event } = chart.cursor;
  // Also called while a chart is made or resized: only a pointer moves the common cursor.
  if (event && left !== undefined && left >= 0) setCursorTime(chart.posToVal(left, 'x'));
}

function zoomToSelection(chart: uPlot): void {
  const { left, width } = chart.select;
  if (width <= 5) return;
  const [low, high] = [chart.posToVal(left, 'x'), chart.posToVal(left + width, 'x')];
  chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  setSpan(low, high);
}
