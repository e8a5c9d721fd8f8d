// The runs of one recording on the truth, over its floor plan: Kleinert & Stilla's figure 4, and what
// theirs could not have, errors.

const MARK = 5;  // half the size of the mark at an end [px]; that at the start is larger

/** A scene as it is drawn: one that is taller than wide lies on its side, y to the right. */
function decodeScene(raw) {
  const truth = decodeColumns(raw.truth);
  const plan = { wall: decodeColumns(raw.plan.wall), furniture: decodeColumns(raw.plan.furniture) };
  const span = (values) => quantile(values, 1) - quantile(values, 0);
  const frame = plan.wall.x.length ? plan.wall : truth;
  const turned = span(frame.y) > 1.2 * span(frame.x);
  const placed = ({ x, y }) => (turned ? { x: y, y: x.map((v) => -v) } : { x, y });
  return {
    axes: turned ? ['y', '−x'] : ['x', 'y'],
    truth: placed(truth),
    plan: { wall: placed(plan.wall), furniture: placed(plan.furniture) },
    runs: raw.runs.map(({ run, mean_nees: meanNees, ...columns }) => {
      const c = decodeColumns(columns);
      return { index: run, meanNees, t: c.t, nees: c.nees, at: placed(c), error: placed({ x: c.ex, y: c.ey }),
        distance: c.ex.map((_, i) => Math.hypot(c.ex[i], c.ey[i], c.ez[i])) };
    }),
  };
}

const sceneOf = (index) => app.scenes.find((s) => s.runs.some((r) => r.index === index));

class OverviewView extends MapView {
  setScene(scene) {
    this.scene = scene;
    this.axes = scene.axes;
  }

  fit() {
    const { truth, plan } = this.scene;
    const parts = [truth, plan.wall, ...this.scene.runs.map((r) => r.at)];
    const ranges = ['x', 'y'].map((axis) => {
      const all = parts.map((p) => p[axis]);
      return [Math.min(...all.map((v) => quantile(v, 0)).filter(Number.isFinite)),
        Math.max(...all.map((v) => quantile(v, 1)).filter(Number.isFinite))];
    });
    this.centre = ranges.map(([low, high]) => (low + high) / 2);
    const [spanX, spanY] = ranges.map(([low, high]) => Math.max(high - low, 1e-3));
    this.scale = Math.min((this.width - 40) / spanX, (this.height - 76) / spanY, 2000);
    // The scale has its place below.
    this.centre[1] -= 14 / this.scale;
    this.fitScale = this.scale;
  }
}

/** Mouse, touch and keyboard as on the map; there is nothing to point at. */
class OverviewInput extends MapInput {
  point() {}
  hint() {}
  hideTip() {}
}

class Overview {
  constructor() {
    this.canvas = byId('overview-map');
    this.view = new OverviewView();
    this.factor = 1;
    this.hidden = new Set();
    this.draw = throttled(() => this.drawNow());
    new OverviewInput(this);
    listen('theme', this.draw);
    listen('run', () => this.showScene());
    listen('print', () => { this.resize(); this.drawNow(); });
    byId('overview-factor').addEventListener('change', (e) => {
      this.factor = Number(e.target.value);
      this.draw();
    });
    byId('overview-fit').addEventListener('click', () => this.fit());
    byId('overview-in').addEventListener('click', () => this.zoom(1.6));
    byId('overview-out').addEventListener('click', () => this.zoom(1 / 1.6));
    byId('overview-png').addEventListener('click', () => this.savePicture());
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  /** The scene of the active run, or nothing where it has none. */
  showScene() {
    const scene = this.scene = sceneOf(app.active);
    byId('overview').hidden = !scene;
    if (!scene) return;
    byId('overview-title').textContent = scene.plan.wall.x.length
      ? 'Over the floor plan' : 'On the truth';
    this.canvas.setAttribute('aria-label',
      `Top view with the true way and ${scene.runs.length} estimates.`);
    this.view.setScene(scene);
    this.showLegend();
    showOverviewTable(scene);
    this.resize(true);
    this.draw();
  }

  resize(anew = false) {
    const atFit = anew || this.view.scale === this.view.fitScale;
    this.view.width = this.canvas.clientWidth || 1;
    this.view.height = this.canvas.clientHeight || 1;
    if (atFit && this.scene) this.view.fit();
  }

  fit() {
    this.view.fit();
    this.draw();
  }

  zoom(factor) {
    this.view.zoomAbout(this.view.width / 2, this.view.height / 2, factor);
    this.draw();
  }

  showLegend() {
    const { plan, runs } = this.scene;
    const layers = [['truth', swatch('area', 'truth'), 'Truth']];
    if (plan.wall.x.length) layers.push(['plan', swatch('area', 'muted'), 'Plan']);
    for (const { index } of runs) layers.push([index, runSwatch(index), app.runs[index].label]);
    byId('overview-legend').replaceChildren(...layers.map(([key, sign, label]) => {
      const box = make('input', { type: 'checkbox' });
      box.checked = !this.hidden.has(key);
      box.addEventListener('change', () => {
        if (box.checked) this.hidden.delete(key); else this.hidden.add(key);
        this.draw();
      });
      return make('label', { class: 'key toggle' }, box, sign, make('span', { dir: 'auto' }, label));
    }));
  }

  shownRuns() {
    return this.scene.runs.filter(({ index }) => !this.hidden.has(index));
  }

  savePicture() {
    const key = this.shownRuns().map(({ index }) =>
      ({ text: app.runs[index].label, colour: app.runs[index].colour, dash: app.runs[index].dash }));
    const name = activeRun().name;
    downloadPng(fileName(name, 'overview'), this.canvas, `Estimates on the truth – ${name}`,
      'wide and pale: the truth; cross: start, diamonds: ends', key);
  }

  drawNow() {
    if (!this.scene) return;
    const g = prepareCanvas(this.canvas, this.view.width, this.view.height);
    if (this.scene.plan.wall.x.length) {
      if (!this.hidden.has('plan')) this.drawPlan(g);
    } else {
      drawGrid(g, this.view);
    }
    if (!this.hidden.has('truth')) this.drawTruth(g);
    for (const run of this.shownRuns()) this.drawRun(g, run);
    this.drawMarks(g);
    drawScale(g, this.view);
    this.drawFactor(g);
  }

  /** What is inside of the walls is free. */
  drawPlan(g) {
    const { wall, furniture } = this.scene.plan;
    g.fillStyle = palette.ground;
    g.fillRect(0, 0, this.view.width, this.view.height);
    tracePieces(g, this.view, wall);
    g.fillStyle = palette.panel;
    g.fill('evenodd');
    g.strokeStyle = palette.muted;
    g.lineWidth = 1.3;
    g.stroke();
    tracePieces(g, this.view, furniture);
    g.fillStyle = palette.line;
    g.fill('nonzero');
  }

  drawTruth(g) {
    g.strokeStyle = palette.truth;
    g.globalAlpha = 0.22;
    g.lineWidth = 7;
    g.lineCap = 'round';
    drawWay(g, this.view, this.scene.truth);
    g.lineCap = 'butt';
    g.globalAlpha = 1;
  }

  /** The estimate, its deviation from the truth drawn larger where asked for. */
  drawRun(g, run) {
    const { colour, dash } = app.runs[run.index];
    g.strokeStyle = palette[colour];
    g.lineWidth = 1.7;
    g.setLineDash(dash);
    drawWay(g, this.view, this.drawnWay(run));
    g.setLineDash([]);
  }

  drawnWay({ at, error }) {
    const more = this.factor - 1;
    return { x: at.x.map((v, i) => v + more * error.x[i]),
      y: at.y.map((v, i) => v + more * error.y[i]) };
  }

  /** A cross where the truth begins, a diamond where each estimate ends. */
  drawMarks(g) {
    const { truth } = this.scene, last = truth.x.length - 1;
    const [x, y] = this.view.toScreen(truth.x[0], truth.y[0]);
    const [endX, endY] = this.view.toScreen(truth.x[last], truth.y[last]);
    const apart = Math.hypot(endX - x, endY - y) > 40;
    drawCross(g, x, y);
    for (const run of this.shownRuns()) {
      const way = this.drawnWay(run), end = way.x.length - 1;
      drawDiamond(g, ...this.view.toScreen(way.x[end], way.y[end]),
        palette[app.runs[run.index].colour]);
    }
    drawTag(g, apart ? 'start' : 'start (cross), end', x - 12, y - 13, 'right');
    if (apart) drawTag(g, 'end', endX + 12, endY + 14, 'left');
  }

  drawFactor(g) {
    if (this.factor === 1) return;
    drawTag(g, `deviations from the truth drawn ${this.factor} times as large`,
      this.view.width - 14, this.view.height - 20, 'right');
  }
}

function drawWay(g, view, { x, y }) {
  polyline(g, x.length, (i) => view.toScreen(x[i], 0)[0], (i) => view.toScreen(0, y[i])[1]);
}

/** A path of closed pieces that NaN separates. */
function tracePieces(g, view, { x, y }) {
  g.beginPath();
  let pen = false;
  for (let i = 0; i < x.length; i++) {
    if (!Number.isFinite(x[i])) { pen = false; continue; }
    const [px, py] = view.toScreen(x[i], y[i]);
    if (pen) g.lineTo(px, py); else g.moveTo(px, py);
    pen = true;
  }
}

function drawDiamond(g, x, y, colour) {
  g.beginPath();
  g.moveTo(x - MARK, y);
  g.lineTo(x, y - MARK);
  g.lineTo(x + MARK, y);
  g.lineTo(x, y + MARK);
  g.closePath();
  g.fillStyle = colour;
  g.fill();
  g.strokeStyle = palette.panel;
  g.lineWidth = 1.2;
  g.stroke();
}

function drawCross(g, x, y) {
  for (const [colour, width] of [[palette.panel, 5], [palette.ink, 2.4]]) {
    g.strokeStyle = colour;
    g.lineWidth = width;
    g.beginPath();
    for (const side of [-1, 1]) {
      g.moveTo(x - 2 * MARK, y - 2 * side * MARK);
      g.lineTo(x + 2 * MARK, y + 2 * side * MARK);
    }
    g.stroke();
  }
}

const runSwatch = (index) => {
  const { colour, dash } = app.runs[index];
  return swatch(dash.length ? 'dashed' : 'line', colour);
};
