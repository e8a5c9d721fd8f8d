// A plot over time: panels, a legend, buttons, the numbers at the cursor.
import { downloadCsv, downloadSvg, downloadSvgAsPng, fileName } from './files';
import { button, fixed, make, setText, swatch, toggle } from './format';
import { PlotPanel } from './plot_panel';
import { legendSeries, type Panel, panelTitle, plotColumns, plotDescription, type PlotSpec, valueText }
  from './plot_spec';
import { plotSvg } from './plot_svg';
import { activeSubject, app, setCursor, setSpan, showAllTimes, throttled } from './store';

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

  /** Far from the screen nothing is done: show() moves the cursor when the plot comes near. */
  readonly moveCursor = throttled(() => {
    if (!this.visible) return;
    for (const panel of this.panels) panel.moveCursor();
    this.showValues();
  });

  private showValues(): void {
    const i = app.cursor, texts = [`t = ${fixed(activeSubject().t[i], 2)} s`];
    for (const { panel } of this.panels) {
      for (const s of panel.series) {
        if (s.values === undefined || s.style === 'level' || this.hidden.has(s.label)) continue;
        texts.push(valueText(panel, s, i));
      }
    }
    while (this.readout.children.length > texts.length) this.readout.lastChild?.remove();
    while (this.readout.children.length < texts.length) this.readout.append(make('span'));
    texts.forEach((text, k) => setText(this.readout.children[k], text));
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
