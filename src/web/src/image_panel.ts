// The panel of the cameras' pictures: which one is shown, its legend, its numbers.
import { downloadPng, prepareCanvas } from './canvas';
import { fileName } from './files';
import { byId, fixed, make, number, toggle } from './format';
import { drawImage, drawMark, OUTCOME_COLOURS, type ImageOptions } from './image_draw';
import { type CameraImages, type Outcome, Pictures, type Point, sigmasAway } from './images';
import { nearestOnScreen, placeTip } from './map_input';
import { activeRun } from './runs';
import { app, listen, setCursor, setCursorTime, throttled } from './store';

const WORDS: Record<Outcome, string> = {
  used: 'used', rejected: 'rejected', begun: 'initialises a landmark', waiting: 'waiting',
};
const ORDER: Outcome[] = ['used', 'rejected', 'begun', 'waiting'];

export class ImagePanel {
  private readonly canvas = byId<HTMLCanvasElement>('camera');
  private readonly select = byId<HTMLSelectElement>('camera-select');
  private readonly draw = throttled(() => this.drawNow());
  private readonly pictures = new Pictures(this.draw);
  private readonly options: ImageOptions = {
    show: { used: true, rejected: true, begun: true, waiting: true, ellipses: true, tails: true },
    enlarged: 10,
  };
  private points: Point[] = [];

  constructor() {
    listen('run', () => this.showRun());
    listen('rows', () => this.showRun());
    listen('cursor', this.draw);
    listen('theme', this.draw);
    listen('print', () => this.drawNow());
    this.select.addEventListener('change', this.draw);
    byId('camera-enlarged').addEventListener('change', (e) => {
      this.options.enlarged = Number((e.target as HTMLSelectElement).value);
      this.draw();
    });
    byId('camera-png').addEventListener('click', () => this.savePicture());
    this.canvas.addEventListener('keydown', (e) => this.key(e));
    this.canvas.addEventListener('pointermove', (e) => this.point({ x: e.offsetX, y: e.offsetY }));
    this.canvas.addEventListener('pointerleave', () => { byId('camera-tip').hidden = true; });
    new ResizeObserver(this.draw).observe(byId('camera-frame'));
    this.showLegend();
  }

  /** None before the first rows of a live run. */
  private images(): CameraImages | undefined {
    const images = activeRun()?.images ?? [];
    return images[Math.min(this.select.selectedIndex, images.length - 1)] ?? images[0];
  }

  private showRun(): void {
    const { images } = activeRun(), chosen = this.select.selectedIndex;
    byId('camera-panel').hidden = !images.length;
    byId('map-layout').classList.toggle('has-camera', images.length > 0);
    this.select.replaceChildren(...images.map(({ camera }) => make('option', {}, `cam${camera}`)));
    this.select.selectedIndex = Math.min(Math.max(chosen, 0), images.length - 1);
    byId('camera-field').hidden = images.length < 2;
    this.draw();
  }

  private showLegend(): void {
    const entry = (key: keyof ImageOptions['show'], sign: Node, label: string) =>
      toggle(sign, label, this.options.show[key], (on) => {
        this.options.show[key] = on;
        this.draw();
      });
    byId('camera-legend').replaceChildren(
      ...ORDER.map((outcome) => entry(outcome, signOf((g) => drawMark(g, outcome, 9, 7)), WORDS[outcome])),
      entry('ellipses', signOf((g) => {
        g.strokeStyle = OUTCOME_COLOURS.used;
        g.beginPath();
        g.ellipse(9, 7, 6.5, 4, -0.4, 0, 2 * Math.PI);
        g.stroke();
      }), 'expected, 3σ'),
      entry('tails', signOf((g) => {
        g.strokeStyle = OUTCOME_COLOURS.used;
        g.beginPath();
        g.moveTo(3, 10);
        g.lineTo(15, 4);
        g.stroke();
      }), 'path over five frames'));
  }

  private drawNow(): void {
    const images = this.images(), width = byId('camera-frame').clientWidth, run = activeRun();
    if (!images || !width || !run.count) return;
    const k = images.nearest(run.t[app.cursor]), picture = this.pictures.get(images, k);
    this.pictures.get(images, Math.min(k + 1, images.jpeg.length - 1));
    if (picture === undefined) return;  // what is there stays until the picture has come
    const height = Math.round(width * images.height / images.width);
    this.canvas.style.height = `${height}px`;
    this.points = images.frame(k);
    drawImage(prepareCanvas(this.canvas, width, height), images, picture, this.points, this.options,
      width);
    const description = this.description(images, k);
    byId('camera-text').textContent = description;
    this.canvas.setAttribute('aria-label', `cam${images.camera}: ${description}`);
  }

  private description(images: CameraImages, k: number): string {
    const count = (outcome: Outcome) => this.points.filter((p) => p.outcome === outcome).length;
    return [`${fixed(images.t[k], 2)} s`, ...ORDER.map((outcome) => `${count(outcome)} ${
      outcome === 'begun' ? 'initialise' : WORDS[outcome]}`)].join(' · ');
  }

  private savePicture(): void {
    const { name } = activeRun();
    this.drawNow();
    downloadPng(fileName(name, 'camera'), this.canvas, name, byId('camera-text').textContent ?? '');
  }

  private key(e: KeyboardEvent): void {
    const images = this.images();
    if (!images || e.ctrlKey || e.metaKey || e.altKey) return;
    const last = images.t.length - 1, k = images.nearest(activeRun().t[app.cursor]);
    const to = (index: number) => () => setCursorTime(images.t[Math.min(Math.max(index, 0), last)]);
    const actions: Record<string, () => void> = {
      ArrowLeft: to(k - 1), ArrowRight: to(k + 1), Home: to(0), End: to(last),
      '[': () => setCursor(app.cursor - 1), ']': () => setCursor(app.cursor + 1),
    };
    const action = actions[e.key];
    if (!action) return;
    e.preventDefault();
    action();
  }

  /** A point shows its numbers. */
  private point(place: { x: number; y: number }): void {
    const images = this.images(), tip = byId('camera-tip');
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!images) return;
    const at = (i: number): [number, number] => {
      const { u, v, outcome } = this.points[i], scale = width / images.width;
      return this.options.show[outcome] ? [u * scale, v * scale] : [-1e9, -1e9];
    };
    const found = nearestOnScreen(this.points.length, at, place, 9);
    tip.hidden = found < 0;
    if (found < 0) return;
    const p = this.points[found], away = sigmasAway(p);
    tip.replaceChildren(...[`Point ${p.id}: ${WORDS[p.outcome]}`, `seen ${p.age} times`,
      Number.isFinite(away) ? `${number(away, 2)} σ from where it was expected` : '']
      .filter(Boolean).map((line) => make('div', {}, line)));
    placeTip(tip, ...at(found), width, height);
  }
}

/** A small picture for the legend, on the ground that the marks are made for. */
function signOf(paint: (g: CanvasRenderingContext2D) => void): HTMLCanvasElement {
  const sign = make('canvas', { class: 'sign', 'aria-hidden': 'true' });
  paint(prepareCanvas(sign, 18, 14));
  return sign;
}

