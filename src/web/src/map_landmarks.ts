// The landmarks of the map. A step of the cursor changes few of them, which lie together: only the box
// about these is drawn anew.
import type { Pen } from './canvas';
import { clamp } from './data';
import { type Life, lifeAt, LIVES } from './landmark_life';
import { fillSquare, type MapOptions, pixelOf, strokeEllipse } from './map_draw';
import type { MapView } from './map_view';
import { activeRun } from './runs';
import { app } from './store';
import { palette } from './theme';

/** A part of the screen [css px]. */
export interface Part { left: number; top: number; right: number; bottom: number }

/** Those seen later are grey, the retired ones pale, those in view have a rim. */
export class MapLandmarks {
  /** What each is in the picture. */
  private lives: Life[] = [];
  private readonly size: number;
  /** Of the picture [css px]. */
  private pixel = 1;

  constructor(private readonly view: MapView, private readonly options: MapOptions,
    private readonly ellipses: boolean) {
    this.size = clamp(Math.sqrt(view.scale) * 1.2, 1.8, 4);
  }

  /** Takes what they are at the cursor's time. The part of the screen about those that are something
   *  else than before; null where there are none. */
  followCursor(): Part | null {
    const run = activeRun(), time = run.t[app.cursor], { view } = this;
    const part: Part = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
    for (let i = 0; i < view.landmarks.id.length; i++) {
      const life = lifeAt(run, i, time);
      if (life === this.lives[i]) continue;
      this.lives[i] = life;
      const [x, y] = view.landmarkAt(i), reach = this.reach(i) + 1;
      part.left = Math.min(part.left, x - reach);
      part.right = Math.max(part.right, x + reach);
      part.top = Math.min(part.top, y - reach);
      part.bottom = Math.max(part.bottom, y + reach);
    }
    return part.left < part.right ? part : null;
  }

  /** How far the drawing of a landmark reaches from its middle [css px], whatever it is. */
  private reach(i: number): number {
    const dot = this.size + 3.5;
    if (!this.ellipses) return dot;
    const [a, , c] = this.view.landmarkCovariance(i);
    return Math.max(dot, Math.sqrt(5.991 * Math.max(0, a + c)) * this.view.scale + 1);
  }

  /** Draws those that reach into a part of the screen. */
  draw(g: Pen, { left, top, right, bottom }: Part): void {
    const { view } = this, rows: Record<Life, number[]> = { later: [], retired: [], view: [] };
    this.lives.forEach((life, i) => {
      const [x, y] = view.landmarkAt(i), reach = this.reach(i);
      if (x + reach > left && x - reach < right && y + reach > top && y - reach < bottom) {
        rows[life].push(i);
      }
    });
    g.lineWidth = 0.8;
    this.pixel = pixelOf(g);
    for (const life of LIVES) {
      if (this.options.show[life]) for (const i of rows[life]) this.drawOne(g, i, life);
    }
    g.globalAlpha = 1;
  }

  private drawOne(g: Pen, i: number, life: Life): void {
    const { view, size, pixel } = this, [x, y] = view.landmarkAt(i);
    g.fillStyle = g.strokeStyle = life === 'later' ? palette.muted : view.colours[i];
    if (this.ellipses && life !== 'later') {
      strokeEllipse(g, view, x, y, view.landmarkCovariance(i), 0.06, life === 'view' ? 0.8 : 0.4);
    }
    g.globalAlpha = { later: 0.35, retired: 0.65, view: 1 }[life];
    if (life !== 'view') return fillSquare(g, x, y, size, pixel);
    const { fillStyle } = g;
    g.fillStyle = palette.ink;
    fillSquare(g, x, y, size + 3.5, pixel);
    g.fillStyle = fillStyle;
    fillSquare(g, x, y, size + 1.3, pixel);
  }
}
