// Kleinert & Stilla's figure 2: the true path, the estimates and the landmarks of one run.

class StudyView extends MapView {
  setStudy(study) {
    this.study = study;
    this.landmarks = study.landmarks;
    this.origin = study.origin;
  }

  /** Looks at the paths and at all but the farthest landmarks. */
  fit() {
    const { truth, landmarks, filters } = this.study;
    const paths = [truth, ...filters.filter((_, k) => this.study.shown[k]).map((f) => f.estimate)];
    const ranges = this.axes.map((axis) => {
      const path = paths.flatMap((p) => Array.from(p[axis])).filter(Number.isFinite);
      const low = [quantile(path, 0), quantile(landmarks[axis], 0.01)].filter(Number.isFinite);
      const high = [quantile(path, 1), quantile(landmarks[axis], 0.99)].filter(Number.isFinite);
      return low.length ? [Math.min(...low), Math.max(...high)] : [-1, 1];
    });
    this.centre = ranges.map(([low, high]) => (low + high) / 2);
    const [spanX, spanY] = ranges.map(([low, high]) => Math.max(high - low, 1e-3));
    this.scale = Math.min(0.88 * this.width / spanX, 0.86 * this.height / spanY, 2000);
    this.fitScale = this.scale;
  }
}

/** Mouse, touch and keyboard as on a run's map; the pointer moves the time cursor along the paths. */
class StudyMapInput extends MapInput {
  point(e) {
    if (e) this.followPath(e.offsetX, e.offsetY);
  }

  followPath(px, py) {
    const [a, b] = this.view.axes;
    let best = -1, nearest = 14;
    for (const k of shownFilters()) {
      const path = activeRun().filters[k].estimate;
      for (let i = 0; i < path[a].length; i++) {
        const [x, y] = this.view.toScreen(path[a][i], path[b][i]);
        const distance = Math.hypot(x - px, y - py);
        if (distance < nearest) [best, nearest] = [i, distance];
      }
    }
    if (best >= 0) setCursor(best);
  }

  hideTip() {}
}

class StudyMap {
  constructor() {
    this.canvas = byId('map');
    this.view = new StudyView();
    this.show = { truth: true, landmarks: true };
    this.draw = throttled(() => this.drawNow());
    new StudyMapInput(this);
    for (const kind of ['cursor', 'theme', 'shown']) listen(kind, this.draw);
    listen('run', () => this.showStudy());
    listen('print', () => { this.resize(); this.drawNow(); });
    byId('map-view').addEventListener('change', (e) => {
      this.view.setPlane(e.target.value);
      this.fit();
    });
    byId('map-fit').addEventListener('click', () => this.fit());
    byId('map-in').addEventListener('click', () => this.zoom(1.6));
    byId('map-out').addEventListener('click', () => this.zoom(1 / 1.6));
    byId('map-png').addEventListener('click', () => downloadPng(fileName(activeRun().name, 'top-view'),
      this.canvas, `Top view – ${activeRun().name}`, 'dots: landmarks',
      [{ text: 'truth (wide)', colour: 'truth' }, ...filterKey()]));
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  showStudy() {
    const study = activeRun();
    byId('map-panel').hidden = !study.truth;
    if (!study.truth) return;
    this.view.setStudy(study);
    this.showLegend();
    this.canvas.setAttribute('aria-label', 'Top view with the true path, ' +
      `${study.filters.length} estimates and ${study.landmarks.x.length} landmarks.`);
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
    if (atFit && activeRun().truth) this.view.fit();
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
    const layers = [['truth', 'Truth', 'area', 'truth']];
    if (activeRun().landmarks.x.length) layers.push(['landmarks', 'Landmarks', 'dots', 'landmark']);
    byId('map-legend').replaceChildren(...layers.map(([key, label, style, colour]) => {
      const box = make('input', { type: 'checkbox' });
      box.checked = this.show[key];
      box.addEventListener('change', () => { this.show[key] = box.checked; this.draw(); });
      return make('label', { class: 'key toggle' }, box, swatch(style, colour), label);
    }));
  }

  drawNow() {
    const study = activeRun();
    if (!study.truth) return;
    const g = prepareCanvas(this.canvas, this.view.width, this.view.height);
    drawGrid(g, this.view);
    if (this.show.landmarks) this.drawLandmarks(g);
    if (this.show.truth) this.drawTruth(g);
    for (const k of shownFilters()) {
      drawPath(g, this.view, study.filters[k].estimate, palette[filterColour(k)], 1.8,
        filterDash(k) || []);
    }
    this.drawStart(g);
    this.drawCursors(g);
    drawScale(g, this.view);
  }

  /** Wide and pale: the estimates lie on it. */
  drawTruth(g) {
    g.globalAlpha = 0.3;
    drawPath(g, this.view, activeRun().truth, palette.truth, 6, []);
    g.globalAlpha = 1;
  }

  drawLandmarks(g) {
    const [a, b] = this.view.axes.map((axis) => this.view.landmarks[axis]);
    const size = clamp(Math.sqrt(this.view.scale) * 0.9, 2.4, 4);
    g.fillStyle = palette.landmark;
    g.globalAlpha = 0.85;
    for (let i = 0; i < a.length; i++) {
      const [x, y] = this.view.toScreen(a[i], b[i]);
      g.fillRect(x - size / 2, y - size / 2, size, size);
    }
    g.globalAlpha = 1;
  }

  drawStart(g) {
    const { truth } = activeRun();
    if (!truth.x.length) return;
    const [a, b] = this.view.axes.map((axis) => truth[axis]);
    const [x, y] = this.view.toScreen(a[0], b[0]);
    drawDot(g, x, y, palette.truth);
    drawTag(g, 'start', x + 9, y, 'left');
  }

  drawCursors(g) {
    for (const k of shownFilters()) {
      const [a, b] = this.view.axes.map((axis) => activeRun().filters[k].estimate[axis]);
      const [x, y] = this.view.toScreen(a[app.cursor], b[app.cursor]);
      if (!Number.isFinite(x)) continue;
      g.fillStyle = palette[filterColour(k)];
      g.strokeStyle = palette.panel;
      g.lineWidth = 1.5;
      g.beginPath();
      g.arc(x, y, 4.5, 0, 2 * Math.PI);
      g.fill();
      g.stroke();
    }
  }
}
