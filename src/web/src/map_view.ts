// Where a map looks: world metres ↔ pixels.
import { type Axis, clamp, type Column, type Columns, extremes, quantile, type Vector } from './data';
import { type Run, truthColumns } from './runs';
import { marksBox, type SavedMap } from './saved_map';
import { palette, ramp } from './theme';

const VIEWS: Record<string, [Axis, Axis]> = { top: ['x', 'y'], side: ['x', 'z'], front: ['y', 'z'] };
export const COVARIANCES: Record<string, string> =
  { xx: 'cxx', xy: 'cxy', xz: 'cxz', yy: 'cyy', yz: 'cyz', zz: 'czz' };
/** [variance, covariance, variance] in the plane of a view. */
export type PlaneCovariance = [number, number, number];

/** A plane in metres on a screen in pixels. */
export class Plane {
  width = 1;
  height = 1;
  scale = 1;
  fitScale = 1;
  centre = [0, 0];
  private fitCentre = this.centre;
  /** What the axes are called; null where they are not the world's. */
  names: [string, string] | null = ['x', 'y'];

  /** As large as the canvas is on the page; true if the view was the fitted one before. */
  measure(canvas: HTMLCanvasElement): boolean {
    this.width = canvas.clientWidth || 1;
    this.height = canvas.clientHeight || 1;
    return this.atFit();
  }

  /** Nobody has moved or zoomed it since it was fitted. */
  atFit(): boolean {
    return this.scale === this.fitScale && this.centre === this.fitCentre;
  }

  toScreen(x: number, y: number): [number, number] {
    return [this.xOnScreen(x), this.yOnScreen(y)];
  }

  xOnScreen(x: number): number {
    return this.width / 2 + (x - this.centre[0]) * this.scale;
  }

  yOnScreen(y: number): number {
    return this.height / 2 - (y - this.centre[1]) * this.scale;
  }

  toWorld(px: number, py: number): [number, number] {
    return [this.centre[0] + (px - this.width / 2) / this.scale,
      this.centre[1] - (py - this.height / 2) / this.scale];
  }

  zoomAbout(px: number, py: number, factor: number): void {
    const before = this.toWorld(px, py);
    this.scale = clamp(this.scale * factor, this.fitScale / 20, 5000);
    const after = this.toWorld(px, py);
    this.centre = this.centre.map((c, k) => c + before[k] - after[k]);
  }

  pan(dx: number, dy: number): void {
    this.centre = [this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale];
  }

  /** Looks at the ranges of x and y so that they take that share of the screen, less the margins. */
  lookAt(ranges: [number, number][], share: [number, number], margins: [number, number] = [0, 0]):
      void {
    this.centre = this.fitCentre = ranges.map(([low, high]) => (low + high) / 2);
    const [spanX, spanY] = ranges.map(([low, high]) => Math.max(high - low, 1e-3));
    this.scale = Math.max(1e-6, Math.min((share[0] * this.width - margins[0]) / spanX,
      (share[1] * this.height - margins[1]) / spanY, 2000));
    this.fitScale = this.scale;
  }
}

/** The range of the paths and of all but the farthest landmarks. */
export function rangeOf(paths: ArrayLike<number>[], marks: ArrayLike<number>, share: number):
    [number, number] {
  const [low, high] = [Infinity, -Infinity].map((start, end) => paths.map((p) => extremes(p)[end])
    .concat(quantile(marks, end ? 1 - share : share)).filter(Number.isFinite)
    .reduce((a, b) => (end ? Math.max(a, b) : Math.min(a, b)), start));
  return low <= high ? [low, high] : [-1, 1];
}

/** The numbers of a run in one of the planes of its axes. */
export class MapView extends Plane {
  axes: [Axis, Axis] = VIEWS.top;
  landmarks: Columns = {};
  savedMap: SavedMap | null = null;
  origin: Vector = [0, 0, 0];
  hovered = -1;
  colours: string[] = [];
  colourRange = [0, 0];

  setPlane(name: string): void {
    this.axes = VIEWS[name];
    this.names = this.axes;
  }

  setRun(run: Run): void {
    this.landmarks = run.landmarks;
    this.savedMap = run.savedMap;
    this.origin = run.origin;
    this.hovered = -1;
  }

  stateAt(run: Run, i: number): [number, number] {
    return this.toScreen(run.states[this.axes[0]][i], run.states[this.axes[1]][i]);
  }

  landmarkAt(i: number): [number, number] {
    return this.markAt(this.landmarks, i);
  }

  markAt(marks: Columns, i: number): [number, number] {
    return this.toScreen(marks[this.axes[0]][i], marks[this.axes[1]][i]);
  }

  planeCovariance(columns: Columns, i: number): PlaneCovariance {
    const [a, b] = this.axes;
    return [a + a, a + b, b + b].map((pair) => columns[COVARIANCES[pair]][i]) as PlaneCovariance;
  }

  stateCovariance(run: Run, i: number) { return this.planeCovariance(run.states, i); }
  landmarkCovariance(i: number) { return this.planeCovariance(this.landmarks, i); }

  /** The body's x axis in the plane of the view. */
  forward(run: Run, i: number): number[] {
    const { qx, qy, qz, qw } = run.states;
    const [x, y, z, w] = [qx[i], qy[i], qz[i], qw[i]];
    const axis = { x: 1 - 2 * (y * y + z * z), y: 2 * (x * y + w * z), z: 2 * (x * z - w * y) };
    return this.axes.map((name) => axis[name]);
  }

  /** Whether ellipses are large enough on the screen, and few enough, to show something. */
  zoomedIn(): boolean {
    const sets = [this.landmarks, ...(this.savedMap ? [this.savedMap.marks] : [])];
    let visible = 0, all = 0;
    for (const marks of sets) {
      all += marks.id.length;
      for (let i = 0; i < marks.id.length && visible <= 700; i++) {
        const [x, y] = this.markAt(marks, i);
        if (x > 0 && y > 0 && x < this.width && y < this.height) visible++;
      }
    }
    return visible <= 700 && (this.scale > this.fitScale * 1.8 || all <= 100);
  }

  fit(run: Run): void {
    const paths: Record<Axis, Column>[] = [run.states as Record<Axis, Column>];
    if (run.deadReckoning) paths.push(run.deadReckoning as Record<Axis, Column>);
    if (run.truth) paths.push(truthColumns(run, 'first'));
    const saved = run.savedMap ? marksBox(run.savedMap) : null;
    // Room at the borders for the farther landmarks, the scale and the buttons.
    this.lookAt(this.axes.map((axis) => rangeOf([...paths.map((p) => p[axis]), saved?.[axis] ?? []],
      run.landmarks[axis], 0.02)), [0.84, 0.84]);
  }

  /** Colours of the landmarks by standard deviation or height. */
  colourBy(kind: string): void {
    const { values, range: [low, high], share } = landmarkScale(this.landmarks, this.origin[2], kind);
    this.colourRange = [low, high];
    this.colours = values.map((v) => (kind === 'plain' || !(high > low)) ? palette.landmark
      : ramp(share(v)));
  }
}

/** What colours landmarks: a value each, the range of the ramp, and where in it a value is. */
export function landmarkScale(marks: Columns, height: number, kind: string) {
  const value = kind === 'height' ? (i: number) => marks.z[i] + height
    : (i: number) => Math.sqrt(Math.max(marks.cxx[i] + marks.cyy[i] + marks.czz[i], 0));
  const values = Array.from(marks.id, (_, i) => value(i));
  const range: [number, number] = [quantile(values, 0.05), quantile(values, 0.95)];
  // Standard deviations span decades: their logarithm makes the small ones distinguishable.
  const shape = kind === 'height' ? (v: number) => v : (v: number) => Math.log(Math.max(v, 1e-9));
  const [a, b] = range.map(shape);
  return { values, range, share: (v: number) => (shape(v) - a) / (b - a) };
}
