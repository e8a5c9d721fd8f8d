// Where the map of a study looks: every view is an orthographic projection.
import { DEG, type Vector } from './data';
import { Plane, rangeOf } from './map_view';
import type { Points, Study } from './studies';

interface Projection {
  title: string;
  /** The directions in the world that go to the right and up on the screen. */
  right: Vector; up: Vector;
  names: Plane['names'];
}

/** The map turned by an azimuth, seen from that elevation above the horizon [rad]. */
function slanted(azimuth: number, elevation: number): Pick<Projection, 'right' | 'up'> {
  const [c, s] = [Math.cos(azimuth), Math.sin(azimuth)];
  const sink = Math.sin(elevation);
  return { right: [c, s, 0], up: [-s * sink, c * sink, Math.cos(elevation)] };
}

const VIEWS: Record<string, Projection> = {
  top: { title: 'Top view', right: [1, 0, 0], up: [0, 1, 0], names: ['x', 'y'] },
  side: { title: 'Side view', right: [1, 0, 0], up: [0, 0, 1], names: ['x', 'z'] },
  front: { title: 'Front view', right: [0, 1, 0], up: [0, 0, 1], names: ['y', 'z'] },
  slanted: { title: 'Slanted view', ...slanted(30 / DEG, 30 / DEG), names: null },
};

const along = ({ x, y, z }: Points, [a, b, c]: Vector, i: number): number => a * x[i] + b * y[i] + c * z[i];

export class StudyView extends Plane {
  projection = VIEWS.top;

  setView(name: string): void {
    this.projection = VIEWS[name];
    this.names = this.projection.names;
  }

  /** A view along an axis: the grid's metres are the world's. */
  straight(): boolean {
    return this.projection.names !== null;
  }

  xOf(points: Points, i: number): number {
    return this.xOnScreen(along(points, this.projection.right, i));
  }

  yOf(points: Points, i: number): number {
    return this.yOnScreen(along(points, this.projection.up, i));
  }

  fitStudy({ truth, landmarks, filters, shown }: Study): void {
    const paths = filters.filter((_, k) => shown[k]).map((f) => f.estimate);
    if (truth) paths.push(truth);
    // Estimated landmarks may lie anywhere: the true ones say how far the scene reaches.
    this.lookAt([this.projection.right, this.projection.up].map((direction) => {
      const all = (points: Points) => Float64Array.from(points.x, (_, i) => along(points, direction, i));
      return rangeOf(paths.map(all), all(landmarks), 0.01);
    }), [0.88, 0.86]);
  }
}
