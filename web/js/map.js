// The map: where it looks, what it shows, how it answers to mouse, touch and keyboard.

const VIEWS = { top: ['x', 'y'], side: ['x', 'z'], front: ['y', 'z'] };
const COVARIANCES = { xx: 'cxx', xy: 'cxy', xz: 'cxz', yy: 'cyy', yz: 'cyz', zz: 'czz' };

/** World metres ↔ pixels, and the numbers of the active run in the chosen plane. */
class MapView {
  constructor() {
    this.width = this.height = 1;
    this.scale = 1;
    this.centre = [0, 0];
    this.hovered = -1;
    this.colours = [];
    this.colourRange = [0, 0];
    this.setPlane('top');
  }

  setPlane(name) {
    this.axes = VIEWS[name];
  }

  setRun(run) {
    this.landmarks = run.landmarks;
    this.origin = run.origin;
    this.hovered = -1;
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.centre[0]) * this.scale,
      this.height / 2 - (y - this.centre[1]) * this.scale];
  }

  toWorld(px, py) {
    return [this.centre[0] + (px - this.width / 2) / this.scale,
      this.centre[1] - (py - this.height / 2) / this.scale];
  }

  stateAt(run, i) {
    return this.toScreen(run.states[this.axes[0]][i], run.states[this.axes[1]][i]);
  }

  landmarkAt(i) {
    return this.toScreen(this.landmarks[this.axes[0]][i], this.landmarks[this.axes[1]][i]);
  }

  /** [variance, covariance, variance] in the plane of the view. */
  planeCovariance(columns, i) {
    const [a, b] = this.axes;
    return [a + a, a + b, b + b].map((pair) => columns[COVARIANCES[pair]][i]);
  }

  stateCovariance(run, i) { return this.planeCovariance(run.states, i); }
  landmarkCovariance(i) { return this.planeCovariance(this.landmarks, i); }

  /** The body's x axis in the plane of the view. */
  forward(run, i) {
    const { qx, qy, qz, qw } = run.states;
    const [x, y, z, w] = [qx[i], qy[i], qz[i], qw[i]];
    const axis = { x: 1 - 2 * (y * y + z * z), y: 2 * (x * y + w * z), z: 2 * (x * z - w * y) };
    return this.axes.map((name) => axis[name]);
  }

  /** Whether ellipses are large enough on the screen, and few enough, to tell something. */
  zoomedIn() {
    let visible = 0;
    for (let i = 0; i < this.landmarks.id.length && visible <= 700; i++) {
      const [x, y] = this.landmarkAt(i);
      if (x > 0 && y > 0 && x < this.width && y < this.height) visible++;
    }
    return visible <= 700 && (this.scale > this.fitScale * 1.8 || this.landmarks.id.length <= 100);
  }

  zoomAbout(px, py, factor) {
    const before = this.toWorld(px, py);
    this.scale = clamp(this.scale * factor, this.fitScale / 20, 5000);
    const after = this.toWorld(px, py);
    this.centre = this.centre.map((c, k) => c + before[k] - after[k]);
  }

  pan(dx, dy) {
    this.centre = [this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale];
  }

  /** Looks at the paths and at all but the farthest landmarks. */
  fit(run) {
    const paths = [run.states, run.deadReckoning, run.truth && truthColumns(run, 'first')]
      .filter(Boolean);
    const ranges = this.axes.map((axis) => {
      const path = paths.flatMap((p) => Array.from(p[axis])).filter(Number.isFinite);
      const marks = run.landmarks[axis];
      const low = [quantile(path, 0), quantile(marks, 0.02)].filter(Number.isFinite);
      const high = [quantile(path, 1), quantile(marks, 0.98)].filter(Number.isFinite);
      return low.length ? [Math.min(...low), Math.max(...high)] : [-1, 1];
    });
    this.centre = ranges.map(([low, high]) => (low + high) / 2);
    const [spanX, spanY] = ranges.map(([low, high]) => Math.max(high - low, 1e-3));
        // Room at the borders for the farther landmarks, the scale and the buttons.
    this.scale = Math.min(0.84 * this.width / spanX, 0.84 * this.height / spanY, 2000);
    this.fitScale = this.scale;
  }

  /** Colours of the landmarks by standard deviation or height. */
  colourBy(kind) {
    const marks = this.landmarks;
    const value = kind === 'height' ? (i) => marks.z[i] + this.origin[2]
      : (i) => Math.sqrt(Math.max(marks.cxx[i] + marks.cyy[i] + marks.czz[i], 0));
    const values = Array.from(marks.id, (_, i) => value(i));
    const [low, high] = this.colourRange = [quantile(values, 0.05), quantile(values, 0.95)];
    // Standard deviations span decades: their logarithm makes the small ones tell apart.
    const shape = kind === 'height' ? (v) => v : (v) => Math.log(Math.max(v, 1e-9));
    const [a, b] = [shape(low), shape(high)];
    this.colours = values.map((v) => (kind === 'plain' || !(b > a)) ? palette.landmark
      : ramp((shape(v) - a) / (b - a)));
  }
}

class MapPanel {
  constructor() {
    this.canvas = byId('map');
    this.view = new MapView();
    this.options = { show: { estimate: true, truth: true, dead: true, landmarks: true },
      colour: 'sigma', ellipses: 'auto', truth: 'first' };
    this.draw = throttled(() => this.drawNow());
    new MapInput(this);
    this.listenToOptions();
    for (const kind of ['cursor', 'theme']) listen(kind, this.draw);
    listen('theme', () => this.view.landmarks && this.view.colourBy(this.options.colour));
    listen('run', () => this.showRun());
    listen('print', () => { this.resize(); this.drawNow(); });
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  showRun() {
    this.view.setRun(activeRun());
    this.view.colourBy(this.options.colour);
    byId('truth-field').hidden = !activeRun().truth;
    const bare = activeRun().landmarks.id.length === 0;
    for (const id of ['map-colour-field', 'map-csv']) byId(id).hidden = bare;
    this.showLegend();
    this.measure();
    this.fit();
  }

  measure() {
    this.view.width = this.canvas.clientWidth || 1;
    this.view.height = this.canvas.clientHeight || 1;
  }

  resize() {
    const atFit = this.view.scale === this.view.fitScale;
    this.measure();
    if (atFit && this.view.landmarks) this.view.fit(activeRun());
  }

  fit() {
    this.view.fit(activeRun());
    this.draw();
  }

  drawNow() {
    if (!this.view.landmarks) return;
    const g = prepareCanvas(this.canvas, this.view.width, this.view.height);
    drawMap(g, this.view, this.options);
    this.canvas.setAttribute('aria-label', mapDescription(activeRun()));
  }

  listenToOptions() {
    const choose = (id, apply) => byId(id).addEventListener('change', (e) => {
      apply(e.target.value);
      this.draw();
    });
    choose('map-view', (v) => { this.view.setPlane(v); this.view.fit(activeRun()); });
    choose('map-colour', (v) => { this.options.colour = v; this.view.colourBy(v); });
    choose('map-ellipses', (v) => { this.options.ellipses = v; });
    choose('map-truth', (v) => { this.options.truth = v; });
    byId('map-fit').addEventListener('click', () => this.fit());
    byId('map-in').addEventListener('click', () => this.zoom(1.6));
    byId('map-out').addEventListener('click', () => this.zoom(1 / 1.6));
    byId('map-png').addEventListener('click', () => downloadPng(fileName(activeRun().name, 'map'),
      this.canvas, `Map – ${activeRun().name}`, this.legendText()));
    byId('map-csv').addEventListener('click', () => downloadLandmarks(activeRun()));
  }

  zoom(factor) {
    this.view.zoomAbout(this.view.width / 2, this.view.height / 2, factor);
    this.draw();
  }

  layers() {
    const run = activeRun();
    const layers = [['estimate', 'Estimate', 'line', estimateColour()]];
    if (run.truth) layers.push(['truth', 'Truth', 'dashed', 'truth']);
    if (run.deadReckoning) layers.push(['dead', 'Dead reckoning', 'dotted', 'dead']);
    if (run.landmarks.id.length) layers.push(['landmarks', 'Landmarks', 'dots', 'landmark']);
    app.runs.forEach((other, k) => {
      if (k !== app.active) layers.push(['run-' + k, other.label, 'dashdot', other.colour]);
    });
    return layers;
  }

  legendText() {
    return this.layers().filter(([key]) => this.options.show[key] !== false)
      .map(([, label, style]) => `${label} (${style})`).join(' · ');
  }

  showLegend() {
    byId('map-legend').replaceChildren(...this.layers().map(([key, label, style, colour]) => {
      if (this.options.show[key] === undefined) this.options.show[key] = true;
      const box = make('input', { type: 'checkbox' });
      box.checked = this.options.show[key];
      box.addEventListener('change', () => { this.options.show[key] = box.checked; this.draw(); });
      return make('label', { class: 'key toggle' }, box, swatch(style, colour),
        make('span', { dir: 'auto' }, label));
    }));
  }
}

function mapDescription(run) {
  const parts = [`${run.count} estimated poses`, `${run.landmarks.id.length} landmarks`];
  if (run.truth) parts.push('the truth');
  if (run.deadReckoning) parts.push('dead reckoning');
  return `Map with ${parts.join(', ')}.`;
}

function downloadLandmarks(run) {
  const m = run.landmarks;
  const shifted = (name, k) => Float64Array.from(m[name], (v) => v + run.origin[k]);
  const columns = [['id', m.id], ['x_m', shifted('x', 0)], ['y_m', shifted('y', 1)],
    ['z_m', shifted('z', 2)], ['observations', m.observations],
    ...Object.values(COVARIANCES).map((c) => [c + '_m2', m[c]])];
  downloadCsv(fileName(run.name, 'landmarks'),
    columns.map(([label, values]) => ({ label, values })));
}
