// A plot over time: stacked panels with one common time axis, the common cursor and time span.
//
// A panel: { label, unit, log, zero, clip,
//   series: [{ label, name, style, values, low, high, colour, dash, legend }] }.
// Styles: 'line', 'band' (between low and high), 'area' (from zero), 'level' (a thin dashed line).

let panelHeight = 104;  // a page of larger plots sets it once
const AXIS_HEIGHT = 22, LEFT = 54, RIGHT = 10, TOP = 20, GAP = 24;

class TimePlot {
  constructor(spec) {
    this.spec = spec;
    this.canvas = make('canvas', { tabindex: '0', role: 'img',
      'aria-label': plotDescription(spec) });
    this.readout = make('div', { class: 'readout' });
    this.draw = throttled(() => this.drawNow());
    this.element = make('figure', { class: 'panel plot' + (spec.wide ? ' wide' : '') },
      make('div', { class: 'panel-head' }, make('h3', {}, spec.title), this.buttons()),
      legendOf(spec), this.canvas, this.readout,
      spec.caption ? make('figcaption', { class: 'muted small' }, spec.caption) : null);
    this.listenToPointer();
    this.listenToKeys();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  buttons() {
    const name = () => fileName(activeRun().name, this.spec.title);
    const png = () => downloadPng(name(), this.canvas, `${this.spec.title} – ${activeRun().name}`,
      legendTexts(this.spec).map((l) => l.text).join(' · '), this.spec.key);
    const csv = () => downloadCsv(name(), plotColumns(this.spec));
    return make('div', { class: 'small-buttons' },
      make('button', { type: 'button', onclick: png, title: 'Save as picture' }, 'PNG'),
      make('button', { type: 'button', onclick: csv, title: 'Save the numbers' }, 'CSV'));
  }

  height() {
    return TOP + this.spec.panels.length * (panelHeight + GAP) - GAP + AXIS_HEIGHT;
  }

  topOf(k) {
    return TOP + k * (panelHeight + GAP);
  }

  xOf(t) {
    const [low, high] = app.span;
    return LEFT + ((t - low) / (high - low)) * (this.width - LEFT - RIGHT);
  }

  timeAt(x) {
    const [low, high] = app.span;
    return low + ((x - LEFT) / (this.width - LEFT - RIGHT)) * (high - low);
  }

  drawNow() {
    this.width = this.canvas.clientWidth;
    if (!this.width) return;
    this.canvas.style.height = this.height() + 'px';
    const g = prepareCanvas(this.canvas, this.width, this.height());
    this.spec.panels.forEach((panel, k) => this.drawPanel(g, panel, this.topOf(k)));
    this.drawTimeAxis(g);
    this.drawSelection(g);
    this.drawCursor(g);
    this.showValues();
  }

  drawPanel(g, panel, top) {
    const scale = panelScale(panel, top);
    const right = this.width - RIGHT;
    drawHealth(g, (t) => this.xOf(t), top, right);
    drawValueAxis(g, scale, right);
    g.save();
    g.beginPath();
    g.rect(LEFT, top, right - LEFT, panelHeight);
    g.clip();
    const x = (i) => this.xOf(activeRun().states.t[i]);
    for (const series of panel.series) drawSeries(g, series, x, scale);
    g.restore();
    drawPanelLabel(g, panel, top - 15, right);
  }

  drawTimeAxis(g) {
    const [low, high] = app.span;
    const bottom = this.height() - AXIS_HEIGHT;
    const ticks = ticksOf(low, high, (this.width - LEFT) / 80);
    const step = ticks.length > 1 ? ticks[1] - ticks[0] : 1;
    g.fillStyle = palette.muted;
    g.textAlign = 'center';
    g.textBaseline = 'top';
    ticks.forEach((t, k) => {
      const text = tickText(t, step) + (k === ticks.length - 1 ? ' s' : '');
      const half = g.measureText(text).width / 2;
      g.fillText(text, Math.min(this.xOf(t), this.width - half - 1), bottom + 6);
    });
  }

  drawCursor(g) {
    const t = activeRun().states.t[app.cursor];
    if (t === undefined || t < app.span[0] || t > app.span[1]) return;
    g.strokeStyle = palette.cursor;
    g.lineWidth = 1.25;
    const x = this.xOf(t);
    this.spec.panels.forEach((_, k) => {
      const top = this.topOf(k);
      g.beginPath();
      g.moveTo(x, top);
      g.lineTo(x, top + panelHeight);
      g.stroke();
    });
  }

  drawSelection(g) {
    if (!this.selection) return;
    const [a, b] = this.selection;
    g.globalAlpha = 0.18;
    g.fillStyle = palette.cursor;
    g.fillRect(Math.min(a, b), TOP, Math.abs(b - a), this.height() - TOP - AXIS_HEIGHT);
    g.globalAlpha = 1;
  }

  showValues() {
    const i = app.cursor;
    const texts = [`t = ${fixed(activeRun().states.t[i], 2)} s`];
    for (const panel of this.spec.panels) {
      for (const series of panel.series) {
        if (series.values && series.style !== 'level') texts.push(valueText(panel, series, i));
      }
    }
    this.readout.replaceChildren(...texts.map((text) => make('span', {}, text)));
  }

  listenToPointer() {
    const canvas = this.canvas;
    let start = null;
    canvas.addEventListener('pointerdown', (e) => {
      if (e.pointerType === 'mouse' && e.button === 0) start = e.offsetX;
      setCursorTime(this.timeAt(e.offsetX));
    });
    canvas.addEventListener('pointermove', (e) => {
      if (start !== null && Math.abs(e.offsetX - start) > 5) {
        this.selection = [start, e.offsetX];
        this.draw();
      }
      setCursorTime(this.timeAt(e.offsetX));
    });
    const finish = () => {
      if (this.selection) this.zoomToSelection();
      start = null;
    };
    canvas.addEventListener('pointerup', finish);
    canvas.addEventListener('pointerleave', finish);
    canvas.addEventListener('dblclick', () => setSpan(...app.fullSpan));
  }

  zoomToSelection() {
    const [a, b] = this.selection.map((x) => this.timeAt(x)).sort((p, q) => p - q);
    this.selection = null;
    setSpan(a, b);
  }

  listenToKeys() {
    this.canvas.addEventListener('keydown', (e) => {
      const action = timeKeys(e);
      if (!action) return;
      e.preventDefault();
      action();
    });
  }
}

/** What a key does to the cursor and the time span; undefined for any other key. */
function timeKeys(e) {
  const stride = e.shiftKey ? 10 : 1;
  const zoom = (factor) => {
    const t = activeRun().states.t[app.cursor];
    const [low, high] = app.span;
    setSpan(t - (t - low) * factor, t + (high - t) * factor);
  };
  return {
    ArrowLeft: () => setCursor(app.cursor - stride),
    ArrowRight: () => setCursor(app.cursor + stride),
    Home: () => setCursor(0),
    End: () => setCursor(activeRun().count - 1),
    '+': () => zoom(0.5),
    '=': () => zoom(0.5),
    '-': () => zoom(2),
    0: () => setSpan(...app.fullSpan),
    Escape: () => setSpan(...app.fullSpan),
  }[e.key];
}

function valueText(panel, series, i) {
  const name = series.name || panel.label || series.label;
  if (!Number.isFinite(series.values[i])) return `${name} –`;
  const sigma = series.sigma ? ` ± ${number(3 * series.sigma[i], 2)}` : '';
  return `${name} ${number(series.values[i])}${sigma}${panel.unit ? ' ' + panel.unit : ''}`;
}

function plotDescription(spec) {
  return `${spec.title}. ${spec.caption || ''} Arrow keys move the time cursor; the CSV button ` +
    'gives the numbers.';
}

/** The columns of a plot's csv file: time, then what each panel draws. */
function plotColumns(spec) {
  const columns = [{ label: 'time_s', values: activeRun().states.t }];
  const add = (panel, series, suffix, values) => values && typeof values !== 'number' &&
    columns.push({ label: [panel.label, series.label].filter(Boolean).join(' ') + suffix, values });
  for (const panel of spec.panels) {
    for (const series of panel.series) {
      add(panel, series, '', series.values);
      add(panel, series, ' low', series.low);
      add(panel, series, ' high', series.high);
    }
  }
  return columns;
}
