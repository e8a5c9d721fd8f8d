// Kleinert & Stilla's figure 2: the true path, the estimates and the landmarks of one run.
import { downloadPng, drawDot, type Pen, prepareCanvas } from './canvas';
import { clamp } from './data';
import { fileName } from './files';
import { byId, swatch, toggle } from './format';
import { besideMarker, drawGrid, drawPath, drawScale, drawTag } from './map_draw';
import { type MapHost, MapInput, nearestOnScreen, startMapButtons } from './map_input';
import { MapView, rangeOf } from './map_view';
import { app, listen, setCursor, throttled } from './store';
import { activeStudy, type Study } from './studies';
import { filterColour, filterDash, filterKey, shownFilters } from './study_colours';
import { palette } from './theme';

class StudyView extends MapView {
  fitStudy({ truth, landmarks, filters, shown }: Study): void {
    const paths = [truth ?? {}, ...filters.filter((_, k) => shown[k]).map((f) => f.estimate)];
    this.landmarks = landmarks;
    this.lookAt(this.axes.map((axis) => rangeOf(paths.map((p) => p[axis]), landmarks[axis], 0.01)),
      [0.88, 0.86]);
  }
}

export class StudyMap implements MapHost {
  readonly canvas = byId<HTMLCanvasElement>('map');
  readonly view = new StudyView();
  readonly draw = throttled(() => this.drawNow());
  private readonly show: Record<string, boolean> = { truth: true, landmarks: true };

  constructor() {
    new MapInput(this);
    startMapButtons('map', this);
    for (const kind of ['cursor', 'theme', 'shown'] as const) listen(kind, this.draw);
    listen('run', () => this.showStudy());
    listen('print', () => { this.resize(); this.drawNow(); });
    byId<HTMLSelectElement>('map-view').addEventListener('change', (e) => {
      this.view.setPlane((e.target as HTMLSelectElement).value);
      this.fit();
    });
    byId('map-png').addEventListener('click', () => downloadPng(fileName(activeStudy().name, 'top-view'),
      this.canvas, `Top view – ${activeStudy().name}`, 'dots: landmarks',
      [{ text: 'truth (wide)', colour: 'truth' }, ...filterKey()]));
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  /** The pointer moves the time cursor along the paths. */
  point(place: { x: number; y: number } | null): void {
    if (!place) return;
    const [a, b] = this.view.axes;
    for (const k of shownFilters()) {
      const path = activeStudy().filters[k].estimate;
      const found = nearestOnScreen(path[a].length, (i) => this.view.toScreen(path[a][i], path[b][i]),
        place, 14);
      if (found >= 0) return setCursor(found);
    }
  }

  private showStudy(): void {
    const study = activeStudy();
    byId('map-panel').hidden = !study.truth;
    if (!study.truth) return;
    this.showLegend();
    this.canvas.setAttribute('aria-label', 'Top view with the true path, ' +
      `${study.filters.length} estimates and ${study.landmarks.x.length} landmarks.`);
    this.view.measure(this.canvas);
    this.fit();
  }

  private resize(): void {
    if (this.view.measure(this.canvas) && activeStudy()?.truth) this.view.fitStudy(activeStudy());
  }

  fit(): void {
    this.view.fitStudy(activeStudy());
    this.draw();
  }

  zoom(factor: number): void {
    this.view.zoomAbout(this.view.width / 2, this.view.height / 2, factor);
    this.draw();
  }

  private showLegend(): void {
    const layers = [['truth', 'Truth', 'area', 'truth']];
    if (activeStudy().landmarks.x.length) layers.push(['landmarks', 'Landmarks', 'dots', 'landmark']);
    byId('map-legend').replaceChildren(...layers.map(([key, label, style, colour]) =>
      toggle(swatch(style, colour), label, this.show[key],
        (on) => { this.show[key] = on; this.draw(); })));
  }

  private drawNow(): void {
    const study = activeStudy();
    if (!study.truth) return;
    const g = prepareCanvas(this.canvas, this.view.width, this.view.height);
    drawGrid(g, this.view);
    if (this.show.landmarks) this.drawLandmarks(g);
    if (this.show.truth) this.drawTruth(g);
    for (const k of shownFilters()) {
      drawPath(g, this.view, study.filters[k].estimate, palette[filterColour(k)], 1.8,
        filterDash(k));
    }
    this.drawStart(g);
    this.drawCursors(g);
    drawScale(g, this.view);
  }

  /** Wide and pale: the estimates lie on it. */
  private drawTruth(g: Pen): void {
    const { truth } = activeStudy();
    if (!truth) return;
    g.globalAlpha = 0.3;
    drawPath(g, this.view, truth, palette.truth, 6, []);
    g.globalAlpha = 1;
  }

  private drawLandmarks(g: Pen): void {
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

  private drawStart(g: Pen): void {
    const { truth } = activeStudy();
    if (!truth?.x.length) return;
    const [a, b] = this.view.axes.map((axis) => truth[axis]);
    const [x, y] = this.view.toScreen(a[0], b[0]);
    drawDot(g, x, y, palette.truth);
    drawTag(g, 'start', x + 9, besideMarker(y), 'left');
  }

  private drawCursors(g: Pen): void {
    for (const k of shownFilters()) {
      const [a, b] = this.view.axes.map((axis) => activeStudy().filters[k].estimate[axis]);
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
