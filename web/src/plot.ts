// A plot over time: a uPlot for each panel, with the page's common cursor and time span.
import uPlot from 'uplot';

import { at, clamp, type Values } from './data';
import { downloadCsv, downloadSvg, downloadSvgAsPng, fileName } from './files';
import { button, fixed, make, swatch, toggle } from './format';
import { isKnown, panelLimits, tickTexts, unwell, valueTicks } from './plot_scale';
import { isBand, legendSeries, type Panel, panelTitle, plotColumns, plotDescription, type PlotSpec,
  type Series, valueText } from './plot_spec';
import { plotSvg } from './plot_svg';
import { activeSubject, app, setCursor, setCursorTime, setSpan, showAllTimes, throttled }
  from './store';
import { faded, palette } from './theme';

const LEFT = 54, RIGHT = 10, AXIS_HEIGHT = 26, FONT = '11px system-ui, sans-serif';

/** What uPlot draws: gaps are null. */
const known = (values: Values, n: number): (number | null)[] =>
  Array.from({ length: n }, (_, i) => (isKnown(values, i) ? at(values, i) : null));

/** A panel of the plot: made when it comes near the screen, for there may be many rows. */
class PlotPanel {
  readonly element = make('div', { class: 'plot-panel' });
  private chart: uPlot | null = null;
  private readonly host = make('div', { class: 'plot-host' });
  private readonly cursorLine = make('div', { class: 'time-cursor' });
  private readonly summary = make('span', { class: 'muted' });
  /** The chart does not have the panel's numbers yet. */
  private outdated = false;

  constructor(private readonly plot: TimePlot, public panel: Panel, private readonly last: boolean) {
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
        { ...axis, show: this.last, size: AXIS_HEIGHT, gap: 4, space: 70,
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

/** What a key does to the cursor and the time span; undefined for any other key. */
function timeKeys(e: KeyboardEvent): (() => void) | undefined {
  const stride = e.shiftKey ? 10 : 1;
  const zoom = (factor: number) => {
    const t = activeSubject().t[app.cursor], [low, high] = app.span;
    setSpan(t - (t - low) * factor, t + (high - t) * factor);
  };
  const actions: Record<string, () => void> = {
    ArrowLeft: () => setCursor(app.cursor - stride),
    ArrowRight: () => setCursor(app.cursor + stride),
    Home: () => setCursor(0),
    End: () => setCursor(activeSubject().count - 1),
    '+': () => zoom(0.5),
    '=': () => zoom(0.5),
    '-': () => zoom(2),
    0: showAllTimes,
    Escape: showAllTimes,
  };
  return actions[e.key];
}

export class TimePlot {
  readonly element: HTMLElement;
  /** Labels of the series that are switched off. */
  readonly hidden = new Set<string>();
  private readonly stack: HTMLElement;
  private readonly readout = make('div', { class: 'readout' });
  private readonly paper = make('div', { class: 'paper-plot' });
  private readonly caption = make('figcaption', { class: 'muted small' });
  private panels: PlotPanel[] = [];
  private visible = false;
  private stale = false;
  private readonly observers: { disconnect(): void }[] = [];

  constructor(public spec: PlotSpec) {
    this.stack = make('div', { class: 'plot-stack', tabindex: 0, role: 'img',
      'aria-label': plotDescription(spec) });
    this.element = make('figure', { class: 'panel plot' },
      make('div', { class: 'panel-head' }, make('h3', {}, spec.title), this.buttons()),
      this.legend(), this.stack, this.readout, this.paper,
      spec.caption ? this.caption : null);
    this.caption.textContent = spec.caption ?? '';
    this.stack.addEventListener('keydown', (e) => this.key(e));
    this.setPanels(spec.panels);
    this.observe();
  }

  private buttons(): HTMLElement {
    const name = () => fileName(activeSubject().name, this.spec.title);
    const picture = () => plotSvg(this.spec, this.hidden);
    return make('div', { class: 'small-buttons' },
      button('PNG', 'Save as picture', () => {
        const { svg, width, height } = picture();
        downloadSvgAsPng(name(), svg, width, height);
      }),
      button('SVG', 'Save as vector picture', () => downloadSvg(name(), picture().svg)),
      button('CSV', 'Save the numbers', () => downloadCsv(name(), plotColumns(this.spec))));
  }

  private legend(): HTMLElement {
    const toggles = legendSeries(this.spec).map((s) =>
      toggle(swatch(s.dash?.length ? 'dashed' : s.style, s.colour),
        make('span', { dir: 'auto' }, s.label), true, (on) => {
          if (on) this.hidden.delete(s.label); else this.hidden.add(s.label);
          this.draw();
        }));
    return make('div', { class: 'legend', role: 'group', 'aria-label': `Shown in ${this.spec.title}` },
      ...toggles);
  }

  private key(e: KeyboardEvent): void {
    const action = timeKeys(e);
    if (!action || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    action();
  }

  /** Other panels in the same figure. */
  setPanels(panels: Panel[]): void {
    this.spec.panels = panels;
    for (const panel of this.panels) panel.destroy();
    this.panels = panels.map((panel, k) => new PlotPanel(this, panel, k === panels.length - 1));
    this.stack.replaceChildren(...this.panels.map((p) => p.element));
    this.resize();
    this.showValues();
  }

  /** Whether it is the same plot with other numbers. */
  fits(spec: PlotSpec): boolean {
    const shape = (s: PlotSpec) => JSON.stringify([s.title, Boolean(s.caption), s.panels.map((p) =>
      [panelTitle(p), Boolean(p.log), p.series.map((one) => [one.label, one.style])])]);
    return shape(spec) === shape(this.spec);
  }

  /** Other numbers; presumes fits(). */
  update(spec: PlotSpec): void {
    this.spec = spec;
    this.caption.textContent = spec.caption ?? '';
    spec.panels.forEach((panel, k) => this.panels[k].update(panel));
    this.draw();
  }

  /** Charts are drawn when they come near the screen, and again when they come back to it. */
  private observe(): void {
    const near = new IntersectionObserver((entries) => {
      this.visible = entries[entries.length - 1].isIntersecting;
      if (!this.visible) return;
      this.resize();
      this.showValues();
      if (this.stale) this.redrawSoon();
    }, { rootMargin: '400px' });
    near.observe(this.stack);
    const size = new ResizeObserver(() => this.resize());
    size.observe(this.stack);
    this.observers.push(near, size);
  }

  private resize(): void {
    const width = this.stack.clientWidth;
    if (!this.visible || !width) return;
    for (const panel of this.panels) panel.show(width);
  }

  private readonly redrawSoon = throttled(() => {
    this.stale = !this.visible;
    if (this.visible) for (const panel of this.panels) panel.redraw();
  });

  draw(): void {
    this.stale = true;
    this.redrawSoon();
  }

  readonly moveCursor = throttled(() => {
    for (const panel of this.panels) panel.moveCursor();
    if (this.visible) this.showValues();
  });

  private showValues(): void {
    const i = app.cursor, texts = [`t = ${fixed(activeSubject().t[i], 2)} s`];
    for (const { panel } of this.panels) {
      for (const s of panel.series) {
        if (s.values === undefined || s.style === 'level' || this.hidden.has(s.label)) continue;
        texts.push(valueText(panel, s, i));
      }
    }
    this.readout.replaceChildren(...texts.map((text) => make('span', {}, text)));
  }

  /** On paper a vector picture stands in for the charts. */
  print(): void {
    const { svg } = plotSvg(this.spec, this.hidden, 520);
    this.paper.replaceChildren(
      new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement);
  }

  destroy(): void {
    for (const observer of this.observers) observer.disconnect();
    for (const panel of this.panels) panel.destroy();
  }
}
