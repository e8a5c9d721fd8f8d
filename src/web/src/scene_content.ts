// What stands in the scene of a run: the ground, paths, landmarks, and the body where the cursor is.
import { Group, InstancedMesh, Matrix4, Mesh, type Object3D } from 'three';

import { tickText } from './canvas';
import { closuresOf } from './closures';
import { type Axis, clamp, type Columns, extremes, quantile, type Vector } from './data';
import { number } from './format';
import { estimateColour, layerShown, type MapOptions } from './map_draw';
import { landmarkScale } from './map_view';
import { placedColumns, type Run, truthColumns } from './runs';
import { ellipsoidMatrix, ellipsoids, LandmarkEllipsoids } from './scene_ellipsoids';
import { LandmarkDots } from './scene_landmarks';
import { bodyAxes, camerasOf, frustum, groundGrid, LongPath, pathLine, planLines,
  rings } from './scene_objects';
import { savedMapDots } from './saved_map_dots';
import { type Box, type Screen, sizeOf } from './scene_view';
import { app } from './store';
import { SMOOTH } from './webgl';

/** States of a run that is long. */
const MANY = 20000;

const pathOf = ({ x, y, z }: Columns): Record<Axis, ArrayLike<number>> => ({ x, y, z });

export class SceneContent {
  readonly group = new Group();
  /** What the grid and the colours mean. */
  readonly note: string;
  private readonly body = new Group();
  private readonly dots: LandmarkDots | null = null;
  private readonly ellipsoids: LandmarkEllipsoids | null = null;
  /** Not turned with the body: the covariance is in the axes of the world. */
  private readonly pose: InstancedMesh = ellipsoids(1, 'cursor', 0.3);
  private readonly size: number;

  constructor(private readonly run: Run, private readonly options: MapOptions, box: Box) {
    this.size = sizeOf(box);
    const floor = this.floor(), [grid, step] = groundGrid(this.size, box, floor);
    this.note = `grid: ${tickText(step, step)} m${this.colourNote()}`;
    this.group.add(grid, ...this.plan(floor));
    if (run.landmarks.id.length) {
      this.dots = new LandmarkDots(run, options);
      this.ellipsoids = new LandmarkEllipsoids(run.landmarks, options);
      this.group.add(this.dots.group, ...this.ellipsoids.meshes);
    }
    if (run.savedMap) this.group.add(...savedMapDots(run.savedMap, options));
    this.group.add(...this.paths().filter((path) => path !== null), this.pose, this.body);
    const reach = clamp(this.size / 9, 0.15, 6);
    this.body.add(...bodyAxes(0.6 * reach), ...camerasOf(run).map((camera) => frustum(camera, reach)));
  }

  private paths(): (Object3D | null)[] {
    const { run, options: { show, truth } } = this, dash = this.size / 40;
    const fine = !SMOOTH && run.count > MANY;
    const others = (app.subjects as Run[]).map((other, k) => {
      if (k === app.active || show[`run-${k}`] === false) return null;
      const shift = other.origin.map((o, i) => o - run.origin[i]) as Vector;
      return pathLine(pathOf(other.states), this.size, { colour: other.colour, width: 1.8, shift, fine });
    });
    return [...others,
      show.dead && run.deadReckoning ? pathLine(pathOf(run.deadReckoning), this.size,
        { colour: 'dead', width: 1.6, dash: dash / 4, fine }) : null,
      show.truth && run.truth ? pathLine(truthColumns(run, truth), this.size,
        { colour: 'truth', width: 2, dash, fine }) : null,
      show.estimate ? pathLine(pathOf(run.states), this.size,
        { colour: estimateColour(), width: 3, fine }) : null,
      this.closures()];
  }

  private closures(): Object3D | null {
    const { run: { states: { x, y, z } }, options } = this, list = closuresOf(this.run);
    if (!list.length || !layerShown(options, 'closures')) return null;
    return rings(list.map(({ state: i }): Vector => [x[i], y[i], z[i]]), this.size / 60, 'cursor');
  }

  /** The height of the ground: of the lowest landmarks about the path, where there are any. */
  private floor(): number {
    const { states, landmarks, savedMap } = this.run;
    // A map on a page of its own has no path.
    if (savedMap && !this.run.count) return quantile(savedMap.marks.z, 0.03) || 0;
    const [lowest] = extremes(states.z), marks = quantile(landmarks.z, 0.03);
    const floor = Number.isFinite(lowest) ? lowest : 0;
    return Number.isFinite(marks) ? clamp(marks, floor - 0.3 * this.size, floor) : floor;
  }

  private plan(floor: number): Object3D[] {
    const { run: { plan }, options: { show, truth } } = this, piece = this.size / 8;
    if (!plan || !show.plan) return [];
    return [planLines(placedColumns(plan.furniture, truth), floor, piece, 'line', 1.2),
      planLines(placedColumns(plan.wall, truth), floor, piece, 'muted', 1.6)];
  }

  /** What the colours of the landmarks mean. */
  private colourNote(): string {
    const { run, options: { colour, show } } = this;
    if (colour === 'plain' || !(show.view || show.retired) || !run.landmarks.id.length) return '';
    const [low, high] = landmarkScale(run.landmarks, run.origin[2], colour).range;
    return `, landmarks: ${colour === 'height' ? 'z' : 'σ'} ${number(low, 2)} m dark to ` +
      `${number(high, 2)} m bright`;
  }

  /** Shows the run as it is at row i. */
  setRow(i: number): void {
    const { run: { states: s, count, t }, body, pose } = this;
    this.dots?.setTime(t[i]);
    body.visible = pose.visible = count > 0 && Number.isFinite(s.x[i] + s.y[i] + s.z[i] + s.qw[i]);
    if (!body.visible) return;
    body.position.set(s.x[i], s.y[i], s.z[i]);
    body.quaternion.set(s.qx[i], s.qy[i], s.qz[i], s.qw[i]);
    this.ellipsoids?.setPlace([s.x[i], s.y[i], s.z[i]], this.size);
    pose.count = 1;
    pose.setMatrixAt(0, ellipsoidMatrix(s, i, new Matrix4()));
    pose.instanceMatrix.needsUpdate = true;
  }

  /** Makes ready what is drawn as seen like that: fewer things where it is drawn coarsely. Returns how
   *  many dots there are then. */
  arrange(screen: Screen, coarse: boolean): number {
    const dots = this.dots?.arrange(coarse ? screen : undefined) ?? 0;
    this.ellipsoids?.arrange(screen, coarse);
    for (const object of this.group.children) {
      if (object instanceof LongPath) object.setCoarse(coarse);
    }
    return dots;
  }

  landmarksInView(): number {
    return this.dots?.inView() ?? 0;
  }

  /** Gives back what the graphics card holds of it. */
  dispose(): void {
    this.group.traverse((object) => {
      if (object instanceof InstancedMesh) object.dispose();
      if (!(object instanceof Mesh) && !('geometry' in object)) return;
      const { geometry, material } = object as Mesh;
      geometry.dispose();
      for (const m of [material].flat()) m.dispose();
    });
  }
}
