// Mouse, touch and keyboard on a map.
import { clamp, mean } from './data';
import type { Plane } from './map_view';
import { app, setCursor } from './store';

export interface MapHost {
  canvas: HTMLCanvasElement;
  view: Plane;
  draw(): void;
  fit(): void;
  zoom(factor: number): void;
  /** Answers to the pointer; null when it leaves. */
  point?(at: { x: number; y: number } | null): void;
  /** The wheel was turned over a map that has not been clicked. */
  hint?(): void;
  hideTip?(): void;
}

export class MapInput {
  private readonly pointers = new Map<number, [number, number]>();

  constructor(private readonly host: MapHost) {
    const { canvas } = host;
    canvas.addEventListener('pointerdown', (e) => this.down(e));
    canvas.addEventListener('pointermove', (e) => this.move(e));
    canvas.addEventListener('pointerup', (e) => this.pointers.delete(e.pointerId));
    canvas.addEventListener('pointercancel', (e) => this.pointers.delete(e.pointerId));
    canvas.addEventListener('pointerleave', () => this.host.point?.(null));
    canvas.addEventListener('wheel', (e) => this.wheel(e), { passive: false });
    canvas.addEventListener('keydown', (e) => this.key(e));
    canvas.addEventListener('dblclick', (e) => this.zoomAt(e.offsetX, e.offsetY, 2));
  }

  private down(e: PointerEvent): void {
    this.host.canvas.focus({ preventScroll: true });
    this.host.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (e.pointerType !== 'mouse') this.host.point?.({ x: e.offsetX, y: e.offsetY });
  }

  private move(e: PointerEvent): void {
    const held = this.pointers.get(e.pointerId);
    if (!held) {
      this.host.point?.({ x: e.offsetX, y: e.offsetY });
      return;
    }
    const before = this.pinch();
    this.pointers.set(e.pointerId, [e.offsetX, e.offsetY]);
    const after = this.pinch(), { view } = this.host;
    view.pan(after.x - before.x, after.y - before.y);
    if (before.spread > 0) view.zoomAbout(after.x, after.y, after.spread / before.spread);
    if (Math.hypot(e.offsetX - held[0], e.offsetY - held[1]) > 0) this.host.hideTip?.();
    this.host.draw();
  }

  /** The middle of the fingers and their mean distance from it. */
  private pinch() {
    const points = [...this.pointers.values()];
    const x = mean(points.map((p) => p[0])), y = mean(points.map((p) => p[1]));
    return { x, y, spread: mean(points.map((p) => Math.hypot(p[0] - x, p[1] - y))) };
  }

  /** The wheel scrolls the page until the map has been clicked: no trap on the way down. */
  private wheel(e: WheelEvent): void {
    if (!e.ctrlKey && document.activeElement !== this.host.canvas) {
      this.host.hint?.();
      return;
    }
    e.preventDefault();
    this.zoomAt(e.offsetX, e.offsetY, Math.exp(-0.0016 * e.deltaY * (e.deltaMode === 1 ? 20 : 1)));
  }

  private zoomAt(x: number, y: number, factor: number): void {
    this.host.view.zoomAbout(x, y, factor);
    this.host.draw();
  }

  private key(e: KeyboardEvent): void {
    const { host } = this, step = e.shiftKey ? 160 : 40;
    const pan = (dx: number, dy: number) => () => { host.view.pan(dx, dy); host.draw(); };
    const actions: Record<string, () => void> = {
      ArrowLeft: pan(step, 0), ArrowRight: pan(-step, 0),
      ArrowUp: pan(0, step), ArrowDown: pan(0, -step),
      '+': () => host.zoom(1.4), '=': () => host.zoom(1.4),
      '-': () => host.zoom(1 / 1.4), 0: () => host.fit(),
      '[': () => setCursor(app.cursor - 1), ']': () => setCursor(app.cursor + 1),
    };
    const action = actions[e.key];
    if (!action || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    action();
  }
}

/** The buttons + − ⤢ of a map. */
export function startMapButtons(prefix: string, host: MapHost): void {
  const click = (id: string, f: () => void) =>
    document.getElementById(`${prefix}-${id}`)?.addEventListener('click', f);
  click('fit', () => host.fit());
  click('in', () => host.zoom(1.6));
  click('out', () => host.zoom(1 / 1.6));
}

/** The index of the point nearest to a place on the screen; -1 where none is within the reach. */
export function nearestOnScreen(count: number, at: (i: number) => [number, number],
    place: { x: number; y: number }, reach: number): number {
  let best = -1, nearest = reach;
  for (let i = 0; i < count; i++) {
    const [x, y] = at(i), distance = Math.hypot(x - place.x, y - place.y);
    if (distance < nearest) [best, nearest] = [i, distance];
  }
  return best;
}

/** Puts a box of numbers beside a point, within the frame. */
export function placeTip(tip: HTMLElement, x: number, y: number, width: number, height: number): void {
  tip.hidden = false;
  const left = x + 14 + tip.offsetWidth > width ? x - 14 - tip.offsetWidth : x + 14;
  tip.style.left = clamp(left, 4, Math.max(4, width - tip.offsetWidth - 4)) + 'px';
  tip.style.top = clamp(y - 20, 4, Math.max(4, height - tip.offsetHeight - 4)) + 'px';
}
