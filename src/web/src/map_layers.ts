// The map in layers: what a moving cursor does not change is kept as a picture.
import { type Pen, prepareCanvas } from './canvas';
import { drawGrid, drawHovered, drawMarker, drawPaths, drawPlan, layerShown, type MapOptions }
  from './map_draw';
import { drawInitial, knowsInitial } from './map_initial';
import { MapLandmarks, type Part } from './map_landmarks';
import type { MapView } from './map_view';
import { activeRun } from './runs';
import { drawSavedMap } from './saved_map_draw';

export class MapLayers {
  /** What stays under the landmarks: the grid, the floor plan, a saved map, the initial positions. */
  private readonly below = document.createElement('canvas');
  /** That and the landmarks; above them all that stays. */
  private readonly ground = document.createElement('canvas');
  private readonly paths = document.createElement('canvas');
  private landmarks: MapLandmarks | null = null;

  constructor(private readonly view: MapView, private readonly options: MapOptions) {}

  /** Something else than the cursor has changed. */
  invalidate(): void {
    this.landmarks = null;
  }

  draw(canvas: HTMLCanvasElement): void {
    const { view } = this, g = prepareCanvas(canvas, view.width, view.height);
    // On another screen a pixel of the style sheet may be more or fewer of the screen's.
    if (this.ground.width !== canvas.width) this.invalidate();
    if (this.landmarks) this.followCursor(this.landmarks); else this.drawAll();
    for (const layer of [this.ground, this.paths]) copy(g, layer);
    if (view.hovered >= 0) drawHovered(g, view);
    drawMarker(g, view, activeRun());
  }

  private drawAll(): void {
    const { view, options } = this, { width, height } = view;
    const ellipses = options.ellipses === 'always' || (options.ellipses === 'auto' && view.zoomedIn());
    this.landmarks = new MapLandmarks(view, options, ellipses);
    this.landmarks.followCursor();
    this.drawBelow(prepareCanvas(this.below, width, height), ellipses);
    this.drawGround(prepareCanvas(this.ground, width, height), this.landmarks,
      { left: 0, top: 0, right: width, bottom: height });
    drawPaths(prepareCanvas(this.paths, width, height), view, options, ellipses);
  }

  private drawBelow(g: Pen, ellipses: boolean): void {
    const { view, options } = this;
    drawGrid(g, view);
    if (options.show.plan) drawPlan(g, view, options);
    if (view.savedMap) drawSavedMap(g, view, view.savedMap, options, ellipses);
    if (knowsInitial(view.landmarks) && layerShown(options, 'initial')) drawInitial(g, view);
  }

  private drawGround(g: Pen, landmarks: MapLandmarks, part: Part): void {
    copy(g, this.below);
    landmarks.draw(g, part);
  }

  private followCursor(landmarks: MapLandmarks): void {
    const changed = landmarks.followCursor();
    const g = this.ground.getContext('2d');
    if (!changed || !g) return;
    // Whole pixels: what is drawn to an edge joins what is there without a seam.
    const ratio = this.ground.width / this.view.width;
    const part = { left: Math.floor(changed.left * ratio) / ratio, top: Math.floor(changed.top * ratio) / ratio,
      right: Math.ceil(changed.right * ratio) / ratio, bottom: Math.ceil(changed.bottom * ratio) / ratio };
    g.save();
    g.beginPath();
    g.rect(part.left, part.top, part.right - part.left, part.bottom - part.top);
    g.clip();
    g.clearRect(part.left, part.top, part.right - part.left, part.bottom - part.top);
    this.drawGround(g, landmarks, part);
    g.restore();
  }
}

/** Pixel by pixel. */
function copy(g: Pen, layer: HTMLCanvasElement): void {
  g.save();
  g.resetTransform();
  g.drawImage(layer, 0, 0);
  g.restore();
}
