// The run in three dimensions: what is drawn, and how it answers.
import { ColorManagement, Group, type InstancedMesh, LinearSRGBColorSpace, Matrix4, Mesh, type Object3D,
  Scene, Vector3, WebGLRenderer } from 'three';

import { type Axis, clamp, type Columns, extremes, quantile, type Vector } from './data';
import { byId, number } from './format';
import { landmarkShown, showLandmarkTip } from './map';
import { estimateColour, type MapOptions } from './map_draw';
import { nearestOnScreen } from './map_input';
import { landmarkScale } from './map_view';
import { activeRun, placedColumns, type Run, truthColumns } from './runs';
import { ellipsoidMatrix, ellipsoids, LandmarkEllipsoids } from './scene_ellipsoids';
import { LandmarkDots } from './scene_landmarks';
import { bodyAxes, camerasOf, frustum, groundGrid, LongPath, pathLine, planLines } from './scene_objects';
import { type Box, boxOf, SceneView, sizeOf } from './scene_view';
import { app, listen, setCursor, throttled } from './store';
import { SMOOTH } from './webgl';

/** States of a run that is long. */
const MANY = 20000;
/** Where a processor draws, a scene that was drawn less than so long ago [ms] is in motion: it is drawn
 *  coarsely, and in full once it is still. */
const STILL = 250;

// The colours of the page as they are: there is no light to mix.
ColorManagement.enabled = false;

const pathOf = ({ x, y, z }: Columns): Record<Axis, ArrayLike<number>> => ({ x, y, z });

export class ScenePanel {
  readonly canvas = byId<HTMLCanvasElement>('scene');
  readonly draw = throttled(() => this.drawNow());
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: SMOOTH, alpha: true });
  private readonly view = new SceneView(this.canvas, this.draw);
  private readonly scene = new Scene();
  private content = new Group();
  private body = new Group();
  private ellipsoids: LandmarkEllipsoids | null = null;
  private dots: LandmarkDots | null = null;
  private pose: InstancedMesh | null = null;
  private box: Box = { low: new Vector3(), high: new Vector3() };
  private size = 1;
  /** The run has grown while the scene was not shown. */
  private outdated = false;
  /** What was drawn before: its shaders serve what is drawn in its place, so it goes after that. */
  private old: Group[] = [];
  private drawnAt = -Infinity;
  private toldAt = -Infinity;
  private stillTimer = 0;
  /** Of the canvas [css px]; 0 while it is not shown. */
  private width = 0;
  private height = 0;

  constructor(private readonly options: MapOptions, private readonly hint: () => void) {
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.listenToInput();
    listen('run', () => { this.measureRun(); this.build(); this.fit(); });
    listen('rows', () => this.growRun());
    for (const kind of ['theme', 'shown'] as const) listen(kind, () => { this.build(); this.draw(); });
    listen('cursor', () => { if (this.visible()) { this.moveBody(); this.draw(); } });
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  private visible(): boolean {
    return this.width > 0 && app.subjects.length > 0;
  }

  /** A view that shows everything goes on to do so. */
  private growRun(): void {
    this.outdated = !this.visible();
    if (this.outdated) return;
    this.measureRun();
    this.build();
    if (this.view.atFit()) this.fit();
    this.draw();
  }

  setView(view: string): void {
    this.view.choose(view);
    this.resize();
    if (this.outdated) this.growRun();
    this.fit();
  }

  private measureRun(): void {
    this.box = boxOf(activeRun());
    this.size = sizeOf(this.box);
  }

  private clear(): void {
    for (const group of this.old.splice(0)) {
      group.traverse((object) => {
        if (!(object instanceof Mesh) && !('geometry' in object)) return;
        const { geometry, material } = object as Mesh;
        geometry.dispose();
        for (const m of [material].flat()) m.dispose();
      });
    }
  }

  private build(): void {
    if (!app.subjects.length) return;
    this.clear();
    this.scene.remove(this.content, this.body);
    this.old.push(this.content, this.body);
    const run = activeRun();
    const floor = this.floor(run);
    const objects: (Object3D | null)[] = [this.ground(run, floor), ...this.plan(run, floor)];
    this.dots = this.ellipsoids = null;
    if (run.landmarks.id.length) {
      this.dots = new LandmarkDots(run, this.options);
      this.ellipsoids = new LandmarkEllipsoids(run.landmarks, this.options);
      objects.push(this.dots.group, ...this.ellipsoids.meshes);
    }
    objects.push(...this.paths(run));
    this.content = new Group();
    this.content.add(...objects.filter((o) => o !== null));
    this.body = this.buildBody(run);
    this.scene.add(this.content, this.body);
    this.moveBody();
  }

  private paths(run: Run): (Object3D | null)[] {
    const { show } = this.options, dash = this.size / 40;
    const fine = !SMOOTH && run.count > MANY;
    const others = (app.subjects as Run[]).map((other, k) => {
      if (k === app.active || show[`run-${k}`] === false) return null;
      const shift = other.origin.map((o, i) => o - run.origin[i]) as Vector;
      return pathLine(pathOf(other.states), this.size, { colour: other.colour, width: 1.8, shift, fine });
    });
    return [...others,
      show.dead && run.deadReckoning ? pathLine(pathOf(run.deadReckoning), this.size,
        { colour: 'dead', width: 1.6, dash: dash / 4, fine }) : null,
      show.truth && run.truth ? pathLine(truthColumns(run, this.options.truth), this.size,
        { colour: 'truth', width: 2, dash, fine }) : null,
      show.estimate ? pathLine(pathOf(run.states), this.size,
        { colour: estimateColour(), width: 3, fine }) : null];
  }

  /** The height of the ground: of the lowest landmarks about the path, where there are any. */
  private floor(run: Run): number {
    const [lowest] = extremes(run.states.z), marks = quantile(run.landmarks.z, 0.03);
    const floor = Number.isFinite(lowest) ? lowest : 0;
    return Number.isFinite(marks) ? clamp(marks, floor - 0.3 * this.size, floor) : floor;
  }

  private plan({ plan }: Run, floor: number): Object3D[] {
    const { show, truth } = this.options, piece = this.size / 8;
    if (!plan || !show.plan) return [];
    return [planLines(placedColumns(plan.furniture, truth), floor, piece, 'line', 1.2),
      planLines(placedColumns(plan.wall, truth), floor, piece, 'muted', 1.6)];
  }

  private ground(run: Run, z: number): Object3D {
    const { low, high } = this.box;
    const [grid, step] = groundGrid(this.size, (low.x + high.x) / 2, (low.y + high.y) / 2, z);
    byId('scene-note').textContent = `grid: ${number(step)} m${this.colourNote(run)}`;
    return grid;
  }

  /** What the colours of the landmarks mean. */
  private colourNote(run: Run): string {
    const { colour, show } = this.options;
    if (colour === 'plain' || !(show.view || show.retired) || !run.landmarks.id.length) return '';
    const [low, high] = landmarkScale(run.landmarks, run.origin[2], colour).range;
    return `, landmarks: ${colour === 'height' ? 'z' : 'σ'} ${number(low, 2)} m dark to ` +
      `${number(high, 2)} m bright`;
  }

  private buildBody(run: Run): Group {
    const body = new Group(), reach = clamp(this.size / 9, 0.15, 6);
    body.add(...bodyAxes(0.6 * reach));
    for (const camera of camerasOf(run)) body.add(frustum(camera, reach));
    // Not turned with the body: the covariance is in the axes of the world.
    this.pose = ellipsoids(1, 'cursor', 0.3);
    this.content.add(this.pose);
    return body;
  }

  /** Puts the body, and the ellipsoids about it, to where the cursor is. */
  private moveBody(): void {
    const { states: s, count, t } = activeRun(), i = app.cursor;
    this.dots?.setTime(t[i]);
    this.body.visible = count > 0 && Number.isFinite(s.x[i] + s.y[i] + s.z[i] + s.qw[i]);
    if (!this.body.visible) return;
    this.body.position.set(s.x[i], s.y[i], s.z[i]);
    this.body.quaternion.set(s.qx[i], s.qy[i], s.qz[i], s.qw[i]);
    this.ellipsoids?.setPlace([s.x[i], s.y[i], s.z[i]], this.size);
    if (this.pose) {
      this.pose.count = 1;
      this.pose.setMatrixAt(0, ellipsoidMatrix(s, i, new Matrix4()));
      this.pose.instanceMatrix.needsUpdate = true;
    }
    if (this.view.follows()) this.view.follow(s, t, i, this.size);
  }

  fit(): void {
    this.resize();
    this.view.fit(this.box);
    this.moveBody();
    this.draw();
  }

  zoom(factor: number): void {
    this.view.zoom(factor);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.width = width;
    this.height = height;
    if (!width || !height) return;
    this.renderer.setPixelRatio(SMOOTH ? Math.min(window.devicePixelRatio || 1, 2) : 1);
    this.renderer.setSize(width, height, false);
    this.view.setShape(width, height);
  }

  drawNow(): void {
    if (!this.visible()) return;
    const coarse = !SMOOTH && performance.now() - this.drawnAt < STILL;
    this.drawOnce(coarse);
    clearTimeout(this.stillTimer);
    // Counted from when it is on the screen, however long that took.
    requestAnimationFrame(() => {
      this.drawnAt = performance.now();
      clearTimeout(this.stillTimer);
      if (coarse) this.stillTimer = window.setTimeout(this.draw, STILL + 20);
    });
  }

  /** As it is when it is still. */
  drawInFull(): void {
    if (this.visible()) this.drawOnce(false);
  }

  private drawOnce(coarse: boolean): void {
    const { canvas } = this, run = activeRun(), marks = run.landmarks.id.length;
    const screen = this.view.screen(this.width, this.height);
    const dots = this.dots?.arrange(coarse ? screen : undefined) ?? 0;
    this.ellipsoids?.arrange(screen, coarse);
    for (const o of this.content.children) if (o instanceof LongPath) o.setCoarse(coarse);
    this.renderer.render(this.scene, this.view.camera);
    this.clear();
    canvas.dataset.detail = coarse ? `coarse: ${dots} of ${marks} dots` : 'full';
    // While it moves it changes with every drawing.
    if (coarse && performance.now() - this.toldAt < 1000) return;
    this.toldAt = performance.now();
    canvas.setAttribute('aria-label', `The run in three dimensions: ${run.count} estimated poses and ` +
      `${marks} landmarks, ${this.dots?.inView() ?? 0} of them in view. Arrow keys turn it.`);
  }

  private listenToInput(): void {
    const { canvas } = this;
    canvas.addEventListener('wheel', () => { if (!this.view.wheelZooms()) this.hint(); },
      { passive: true });
    canvas.addEventListener('pointerdown', () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener('keydown', (e) => this.key(e));
    let place: { x: number; y: number } | null = null;
    const point = throttled(() => { if (place) this.point(place); });
    canvas.addEventListener('pointermove', (e) => {
      place = e.buttons ? null : { x: e.offsetX, y: e.offsetY };
      if (place) point(); else byId('map-tip').hidden = true;
    });
    canvas.addEventListener('pointerleave', () => {
      place = null;
      byId('map-tip').hidden = true;
    });
  }

  private key(e: KeyboardEvent): void {
    const angle = e.shiftKey ? 0.4 : 0.1;
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.view.turn(-angle, 0), ArrowRight: () => this.view.turn(angle, 0),
      ArrowUp: () => this.view.turn(0, angle), ArrowDown: () => this.view.turn(0, -angle),
      '+': () => this.zoom(1.25), '=': () => this.zoom(1.25), '-': () => this.zoom(0.8),
      0: () => this.fit(),
      '[': () => setCursor(app.cursor - 1), ']': () => setCursor(app.cursor + 1),
    };
    const action = actions[e.key];
    if (!action || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    action();
  }

  /** A landmark tells its numbers, the estimate takes the time cursor. */
  private point(place: { x: number; y: number }): void {
    const run = activeRun(), { width, height } = this;
    const mark = this.view.onScreen(run.landmarks, width, height);
    const shown = (i: number): [number, number] =>
      (landmarkShown(this.options, i) ? mark(i) : [-1e9, -1e9]);
    const found = nearestOnScreen(run.landmarks.id.length, shown, place, 6);
    if (found >= 0) {
      showLandmarkTip(found, ...mark(found), width, height);
      return;
    }
    byId('map-tip').hidden = true;
    if (this.view.follows()) return;
    const state = nearestOnScreen(run.count, this.view.onScreen(run.states, width, height),
      place, 10);
    if (state >= 0) setCursor(state);
  }
}
