// Kleinert & Stilla's figures 2 (a) and 3 (a): the true path, the estimates and the landmarks of one run.
import { downloadPng, drawDot, type Pen, polyline, prepareCanvas } from './canvas';
import { clamp, type Vector } from './data';
import { fileName } from './files';
import { byId, swatch, toggle } from './format';
import { besideMarker, drawGrid, drawScale, drawTag } from './map_draw';
import { type MapHost, MapInput, nearestOnScreen, startMapButtons } from './map_input';
import { app, listen, setCursor, throttled } from './store';
import { activeStudy, geometryOf, partTitle, type Points } from './studies';
import { filterColour, filterDash, filterKey, shownFilters } from './study_colours';
import { StudyView } from './study_view';
import { palette } from './theme';

const WORLD_AXES: [name: string, direction: Vector][] =
  [['x', [1, 0, 0]], ['y', [0, 1, 0]], ['z', [0, 0, 1]]];

export class StudyMap implements MapHost {
  readonly canvas = byId<HTMLCanvasElement>('map');
  readonly view = new StudyView();
  readonly draw = throttled(() => this.drawNow());
  private readonly show: Record<string, boolean> = { truth: true, landmarks: true, estimated: true };
  private readonly select = byId<HTMLSelectElement>('map-view');

  constructor() {
    new MapInput(this);
    startMapButtons('map', this);
    for (const kind of ['cursor', 'theme', 'shown'] as const) listen(kind, this.draw);
    listen('run', () => this.showStudy());
    listen('print', () => { this.resize(); this.drawNow(); });
    this.select.addEventListener('change', () => this.setView(this.select.value));
    byId('map-png').addEventListener('click', () => this.savePicture());
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  /** The pointer moves the time cursor along the paths. */
  point(place: { x: number; y: number } | null): void {
    if (!place) return;
    for (const k of shownFilters()) {
      const path = activeStudy().filters[k].estimate;
      const found = nearestOnScreen(path.x.length,
        (i) => [this.view.xOf(path, i), this.view.yOf(path, i)], place, 14);
      if (found >= 0) return setCursor(found);
    }
  }

  private showStudy(): void {
    const study = activeStudy();
    byId('map-panel').hidden = !study.truth;
    if (!study.truth) return;
    this.showLegend();
    this.view.measure(this.canvas);
    // The paper shows the hallway from above and the cube from a corner.
    this.setView(geometryOf(study) === 'turntable' ? 'slanted' : 'top');
  }

  private setView(name: string): void {
    const study = activeStudy(), { view } = this;
    this.select.value = name;
    view.setView(name);
    const { title } = view.projection;
    byId('map-title').textContent = partTitle(study, 'a', title);
    byId('slanted-help').hidden = view.straight();
    this.canvas.setAttribute('aria-label', `${title} with the true path, ${study.filters.length} estimates ` +
      `and ${study.landmarks.x.length} landmarks.`);
    this.fit();
  }

  private savePicture(): void {
    const { title } = this.view.projection, { name } = activeStudy();
    const note = this.layers().filter(({ key, style }) => style === 'dots' && this.show[key])
      .map(({ label, paint }) => `${paint} dots: ${label.toLowerCase()}`).join('; ');
    downloadPng(fileName(name, title), this.canvas, `${title} – ${name}`, note, [
      ...(this.show.truth ? [{ text: 'true path (wide)', colour: 'truth' }] : []), ...filterKey()]);
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

  /** What can be switched besides the filters. */
  private layers() {
    const { landmarks, filters } = activeStudy();
    return [
      { key: 'truth', label: 'True path', style: 'area', colour: 'truth', paint: 'red', there: true },
      { key: 'landmarks', label: 'True landmarks', style: 'dots', colour: 'landmark', paint: 'orange',
        there: landmarks.x.length > 0 },
      { key: 'estimated', label: 'Estimated landmarks', style: 'dots', colour: 'estimated-landmark',
        paint: 'light blue', there: filters.some((f) => f.landmarks.x.length > 0) },
    ].filter(({ there }) => there);
  }

  private showLegend(): void {
    byId('map-legend').replaceChildren(...this.layers().map(({ key, label, style, colour }) =>
      toggle(swatch(style, colour), label, this.show[key],
        (on) => { this.show[key] = on; this.draw(); })));
  }

  private drawNow(): void {
    const study = activeStudy();
    if (!study.truth) return;
    const g = prepareCanvas(this.canvas, this.view.width, this.view.height);
    if (this.view.straight()) drawGrid(g, this.view);
    // Below the true ones and larger, for a good estimate lies on its landmark.
    if (this.show.estimated) {
      for (const k of shownFilters()) {
        this.drawLandmarks(g, study.filters[k].landmarks, 'estimated-landmark', 1.3);
      }
    }
    if (this.show.landmarks) this.drawLandmarks(g, study.landmarks, 'landmark', 1);
    if (this.show.truth) this.drawTruth(g, study.truth);
    for (const k of shownFilters()) {
      g.setLineDash(filterDash(k));
      this.drawPath(g, study.filters[k].estimate, filterColour(k), 1.8);
      g.setLineDash([]);
    }
    this.drawStart(g, study.truth);
    this.drawCursors(g);
    drawScale(g, this.view);
    if (!this.view.straight()) this.drawAxes(g);
  }

  private drawPath(g: Pen, path: Points, colour: string, width: number): void {
    g.strokeStyle = palette[colour];
    g.lineWidth = width;
    polyline(g, path.x.length, (i) => this.view.xOf(path, i), (i) => this.view.yOf(path, i));
  }

  /** Wide and pale: the estimates lie on it, and one of them is as red. */
  private drawTruth(g: Pen, truth: Points): void {
    g.globalAlpha = 0.3;
    this.drawPath(g, truth, 'truth', 6);
    g.globalAlpha = 1;
  }

  private drawLandmarks(g: Pen, marks: Points, colour: string, scale: number): void {
    const size = scale * clamp(Math.sqrt(this.view.scale) * 0.9, 2.4, 4);
    g.fillStyle = palette[colour];
    g.globalAlpha = 0.85;
    for (let i = 0; i < marks.x.length; i++) {
      g.fillRect(this.view.xOf(marks, i) - size / 2, this.view.yOf(marks, i) - size / 2, size, size);
    }
    g.globalAlpha = 1;
  }

  private drawStart(g: Pen, truth: Points): void {
    if (!truth.x.length) return;
    const x = this.view.xOf(truth, 0), y = this.view.yOf(truth, 0);
    drawDot(g, x, y, palette.truth);
    drawTag(g, 'start', x + 9, besideMarker(y), 'left');
  }

  /** In place of the grid: where the world's axes point, each as long as a length along it appears. */
  private drawAxes(g: Pen): void {
    const { right, up } = this.view.projection, length = 32;
    const x = this.view.width - 58, y = this.view.height - 32;
    g.strokeStyle = g.fillStyle = palette.muted;
    g.lineWidth = 1.5;
    g.textAlign = 'center';
    g.textBaseline = 'middle';
    for (const [name, axis] of WORLD_AXES) {
      const [across, high] = [right, up].map((d) => axis.reduce((sum, a, i) => sum + a * d[i], 0));
      g.beginPath();
      g.moveTo(x, y);
      g.lineTo(x + length * across, y - length * high);
      g.stroke();
      const beyond = length + 10 / Math.hypot(across, high);
      g.fillText(name, x + beyond * across, y - beyond * high);
    }
  }

  private drawCursors(g: Pen): void {
    for (const k of shownFilters()) {
      const path = activeStudy().filters[k].estimate;
      const x = this.view.xOf(path, app.cursor), y = this.view.yOf(path, app.cursor);
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
