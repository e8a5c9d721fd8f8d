// The runs of one recording over its floor plan, Kleinert & Stilla's figure 4; and with a truth, what
// theirs could not have, errors.
import { downloadPng, type Pen, polyline, prepareCanvas } from './canvas';
import { extremes } from './data';
import { fileName } from './files';
import { byId, make, swatch, toggle } from './format';
import { drawGrid, drawScale, drawTag } from './map_draw';
import { type MapHost, MapInput, startMapButtons } from './map_input';
import { Plane } from './map_view';
import { runAt, runSwatch, showOverviewTable } from './overview_table';
import { activeRun } from './runs';
import { type Scene, sceneOf, type SceneRun, type Way } from './scenes';
import { listen, throttled } from './store';
import { palette } from './theme';

const MARK = 5;  // half the size of the mark at an end [px]; that at the start is larger

class OverviewView extends Plane {
  fitScene({ truth, plan, runs }: Scene): void {
    const parts = [...(truth ? [truth] : []), plan.wall, ...runs.map((r) => r.at)];
    const ranges = (['x', 'y'] as const).map((axis): [number, number] => {
      const ends = parts.map((p) => extremes(p[axis])).filter(([low]) => Number.isFinite(low));
      return [Math.min(...ends.map((e) => e[0])), Math.max(...ends.map((e) => e[1]))];
    });
    this.lookAt(ranges, [1, 1], [40, 76]);
    // The scale has its place below.
    this.centre[1] -= 14 / this.scale;
  }
}

export class Overview implements MapHost {
  readonly canvas = byId<HTMLCanvasElement>('overview-map');
  readonly view = new OverviewView();
  readonly draw = throttled(() => this.drawNow());
  private scene: Scene | undefined;
  private factor = 1;
  private readonly hidden = new Set<string | number>();

  constructor() {
    new MapInput(this);
    startMapButtons('overview', this);
    listen('theme', this.draw);
    listen('run', () => this.showScene());
    listen('rows', () => { if (sceneOf() !== this.scene) this.showScene(); });
    listen('print', () => { this.resize(); this.drawNow(); });
    byId('overview-factor').addEventListener('change', (e) => {
      this.factor = Number((e.target as HTMLSelectElement).value);
      this.draw();
    });
    byId('overview-png').addEventListener('click', () => this.savePicture());
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  /** The scene of the active run, or nothing where it has none. */
  private showScene(): void {
    const scene = this.scene = sceneOf();
    byId('overview').hidden = !scene;
    if (!scene) return;
    byId('overview-title').textContent = !scene.truth || scene.plan.wall.x.length
      ? 'Over the floor plan' : 'On the truth';
    this.canvas.setAttribute('aria-label', 'Top view with ' +
      `${scene.truth ? 'the true trajectory' : 'the floor plan'} and ${scene.runs.length} estimates.`);
    // Without a truth there is no deviation from it.
    byId('overview-factor-label').hidden = !scene.truth;
    byId('overview-help-truth').hidden = !scene.truth;
    byId('overview-help-plan').hidden = Boolean(scene.truth);
    this.view.names = scene.axes;
    this.showLegend(scene);
    showOverviewTable(scene);
    this.resize(true);
    this.draw();
  }

  private resize(anew = false): void {
    const atFit = this.view.measure(this.canvas) || anew;
    if (atFit && this.scene) this.view.fitScene(this.scene);
  }

  fit(): void {
    if (this.scene) this.view.fitScene(this.scene);
    this.draw();
  }

  zoom(factor: number): void {
    this.view.zoomAbout(this.view.width / 2, this.view.height / 2, factor);
    this.draw();
  }

  private showLegend({ truth, plan, runs }: Scene): void {
    const layers: [string | number, HTMLElement, string][] = [];
    if (truth) layers.push(['truth', swatch('area', 'truth'), 'Truth']);
    if (plan.wall.x.length) layers.push(['plan', swatch('area', 'muted'), 'Plan']);
    for (const { index } of runs) layers.push([index, runSwatch(index), runAt(index).label]);
    byId('overview-legend').replaceChildren(...layers.map(([key, sign, label]) =>
      toggle(sign, make('span', { dir: 'auto' }, label), !this.hidden.has(key), (on) => {
        if (on) this.hidden.delete(key); else this.hidden.add(key);
        this.draw();
      })));
  }

  private shownRuns(): SceneRun[] {
    return (this.scene?.runs ?? []).filter(({ index }) => !this.hidden.has(index));
  }

  private savePicture(): void {
    const key = this.shownRuns().map(({ index }) =>
      ({ text: runAt(index).label, colour: runAt(index).colour, dash: runAt(index).dash }));
    const name = activeRun().name;
    const [title, truth] = this.scene?.truth
      ? ['Estimates on the truth', 'wide and pale: the truth; '] : ['Estimates over the floor plan', ''];
    downloadPng(fileName(name, 'overview'), this.canvas, `${title} – ${name}`,
      `${truth}cross: start, diamonds: ends`, key);
  }

  private drawNow(): void {
    const { scene } = this;
    if (!scene || this.canvas.clientWidth === 0) return;
    const g = prepareCanvas(this.canvas, this.view.width, this.view.height);
    if (scene.plan.wall.x.length) {
      if (!this.hidden.has('plan')) this.drawPlan(g, scene);
    } else {
      drawGrid(g, this.view);
    }
    if (scene.truth && !this.hidden.has('truth')) this.drawTruth(g, scene.truth);
    for (const run of this.shownRuns()) this.drawRun(g, run);
    this.drawMarks(g, scene);
    drawScale(g, this.view);
    this.drawFactor(g);
  }

  /** What is inside of the walls is free. */
  private drawPlan(g: Pen, { plan: { wall, furniture } }: Scene): void {
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

  private drawTruth(g: Pen, truth: Way): void {
    g.strokeStyle = palette.truth;
    g.globalAlpha = 0.22;
    g.lineWidth = 7;
    g.lineCap = 'round';
    drawWay(g, this.view, truth);
    g.lineCap = 'butt';
    g.globalAlpha = 1;
  }

  /** The estimate, its deviation from the truth drawn larger where asked for. */
  private drawRun(g: Pen, run: SceneRun): void {
    const { colour, dash } = runAt(run.index);
    g.strokeStyle = palette[colour];
    g.lineWidth = 1.7;
    g.setLineDash(dash);
    drawWay(g, this.view, this.drawnWay(run));
    g.setLineDash([]);
  }

  private drawnWay({ at, against }: SceneRun): Way {
    if (!against) return at;
    const more = this.factor - 1, { error } = against;
    return { x: Float32Array.from(at.x, (v, i) => v + more * error.x[i]),
      y: Float32Array.from(at.y, (v, i) => v + more * error.y[i]) };
  }

  /** A cross where the truth begins, or, without one, each estimate; a diamond where each ends. */
  private drawMarks(g: Pen, { truth, runs }: Scene): void {
    const ways = this.shownRuns().map((run) => this.drawnWay(run));
    const tagged = truth ?? ways[0] ?? runs[0].at, last = tagged.x.length - 1;
    const [x, y] = this.view.toScreen(tagged.x[0], tagged.y[0]);
    const [endX, endY] = this.view.toScreen(tagged.x[last], tagged.y[last]);
    const apart = Math.hypot(endX - x, endY - y) > 40;
    for (const way of truth ? [truth] : ways) drawCross(g, ...this.view.toScreen(way.x[0], way.y[0]));
    this.shownRuns().forEach((run, k) => {
      const { x: wayX, y: wayY } = ways[k], end = wayX.length - 1;
      drawDiamond(g, ...this.view.toScreen(wayX[end], wayY[end]), palette[runAt(run.index).colour]);
    });
    if (!truth && !ways.length) return;
    drawTag(g, apart ? 'start' : 'start (cross), end', x - 12, y - 13, 'right');
    if (apart) drawTag(g, 'end', endX + 12, endY + 14, 'left');
  }

  private drawFactor(g: Pen): void {
    if (this.factor === 1 || !this.scene?.truth) return;
    drawTag(g, `errors against the truth drawn ${this.factor} times as large`,
      this.view.width - 14, this.view.height - 20, 'right');
  }
}

function drawWay(g: Pen, view: Plane, { x, y }: Way): void {
  polyline(g, x.length, (i) => view.xOnScreen(x[i]), (i) => view.yOnScreen(y[i]));
}

/** A path of closed pieces that NaN separates. */
function tracePieces(g: Pen, view: Plane, { x, y }: Way): void {
  g.beginPath();
  let pen = false;
  for (let i = 0; i < x.length; i++) {
    if (!Number.isFinite(x[i])) { pen = false; continue; }
    const [px, py] = view.toScreen(x[i], y[i]);
    if (pen) g.lineTo(px, py); else g.moveTo(px, py);
    pen = true;
  }
}

function drawDiamond(g: Pen, x: number, y: number, colour: string): void {
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

function drawCross(g: Pen, x: number, y: number): void {
  for (const [colour, width] of [[palette.panel, 5], [palette.ink, 2.4]] as const) {
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
