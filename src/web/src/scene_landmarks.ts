// The landmarks of the scene: dots that show what each is at the time of the cursor.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Float32BufferAttribute, Group, Points,
  PointsMaterial } from 'three';

import { type Life, lifeAt, LIVES } from './landmark_life';
import type { MapOptions } from './map_draw';
import { landmarkScale } from './map_view';
import type { Run } from './runs';
import type { Screen } from './scene_view';
import { palette, rampColour } from './theme';

/** Of the screen: a coarse drawing has one dot in such a square [px], little larger than a dot. */
const CELL = 4;

const CODES: Record<Life, number> = { later: 0, retired: 1, view: 2 };

const plainColour = (name: string): number[] =>
  [1, 3, 5].map((k) => parseInt(palette[name].slice(k, k + 2), 16));

function colours(run: Run, kind: string): Float32Array {
  const { values, range, share } = landmarkScale(run.landmarks, run.origin[2], kind);
  const plain = plainColour('landmark'), out = new Float32Array(3 * values.length);
  values.forEach((value, i) => {
    const rgb = kind === 'plain' || !(range[1] > range[0]) ? plain : rampColour(share(value));
    out.set(rgb.map((c) => c / 255), 3 * i);
  });
  return out;
}

function positions({ x, y, z }: Run['landmarks']): Float32Array {
  const out = new Float32Array(3 * x.length);
  for (let i = 0; i < x.length; i++) out.set([x[i], y[i], z[i]], 3 * i);
  return out;
}

/** Which squares of a screen have a dot. */
class Cells {
  private taken = new Uint8Array(0);
  private columns = 0;
  private rows = 0;

  clear(width: number, height: number): void {
    this.columns = Math.ceil(width / CELL);
    this.rows = Math.ceil(height / CELL);
    const size = this.columns * this.rows;
    if (this.taken.length === size) this.taken.fill(0); else this.taken = new Uint8Array(size);
  }

  /** Takes the square about a place in −1…1, up and to the right; false where it is taken already
   *  or not on the screen. */
  take(x: number, y: number): boolean {
    const column = Math.floor(0.5 * (x + 1) * this.columns);
    const row = Math.floor(0.5 * (y + 1) * this.rows);
    if (!(column >= 0 && row >= 0 && column < this.columns && row < this.rows)) return false;
    const at = row * this.columns + column, free = this.taken[at] === 0;
    this.taken[at] = 1;
    return free;
  }
}

/** A dot a landmark, coloured as on the map: those in view are large with a rim, the retired ones
 *  pale, those seen later grey. */
export class LandmarkDots {
  readonly group = new Group();
  private readonly place: Float32Array;
  private readonly life: Uint8Array;
  private readonly cells = new Cells();
  /** All of them are shown as they are at the time. */
  private inFull = false;
  /** Rows of landmarks, one list for all layers of a life. */
  private readonly indices = new Map<Life, BufferAttribute>();
  private readonly layers: { life: Life; geometry: BufferGeometry }[] = [];

  constructor(private readonly run: Run, options: MapOptions) {
    const count = run.landmarks.id.length;
    this.place = positions(run.landmarks);
    this.life = new Uint8Array(count);
    const position = new Float32BufferAttribute(this.place, 3);
    const colour = new Float32BufferAttribute(colours(run, options.colour), 3);
    const add = (life: Life, size: number, opacity: number, plain?: string) => {
      if (!options.show[life]) return;
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', position);
      if (!plain) geometry.setAttribute('color', colour);
      geometry.setIndex(this.indicesOf(life));
      const points = new Points(geometry, new PointsMaterial({ size, sizeAttenuation: false, opacity,
        transparent: opacity < 1, vertexColors: !plain, color: plain ? palette[plain] : '#ffffff' }));
      points.frustumCulled = false;
      points.renderOrder = CODES[life] - LIVES.length;
      this.group.add(points);
      this.layers.push({ life, geometry });
    };
    add('later', 2.5, 0.35, 'muted');
    add('retired', 3, 0.7);
    add('view', 6.5, 1, 'ink');
    add('view', 4.5, 1);
  }

  private indicesOf(life: Life): BufferAttribute {
    const known = this.indices.get(life);
    if (known) return known;
    const made = new BufferAttribute(new Uint32Array(this.life.length), 1);
    made.setUsage(DynamicDrawUsage);
    this.indices.set(life, made);
    return made;
  }

  /** Takes what the landmarks are at that time of the run. Those that a live run has got since
   *  these dots were made come with the next ones. */
  setTime(t: number): void {
    for (let i = 0; i < this.life.length; i++) this.life[i] = CODES[lifeAt(this.run, i, t)];
    this.inFull = false;
  }

  inView(): number {
    return this.life.reduce((count, life) => count + Number(life === CODES.view), 0);
  }

  /** Shows all of them, or with a screen those in view and of the others one where many are at one
   *  place of it, and none that is beside it. Returns how many dots there are. */
  arrange(screen?: Screen): number {
    if (!screen && this.inFull) return this.life.length;
    if (screen) this.cells.clear(screen.width, screen.height);
    this.inFull = !screen;
    let dots = 0;
    // Whatever lies on top comes first: it takes the place.
    for (const life of [...LIVES].reverse()) {
      const indices = this.indices.get(life);
      if (!indices) continue;
      const count = this.fill(indices, life, screen);
      for (const layer of this.layers) if (layer.life === life) layer.geometry.setDrawRange(0, count);
      dots += count;
    }
    return dots;
  }

  private fill(indices: BufferAttribute, life: Life, screen?: Screen): number {
    const code = CODES[life], every = life === 'view';
    const rows = indices.array as Uint32Array, { place } = this;
    const m = screen?.clip_T_world.elements;
    let count = 0;
    for (let i = 0; i < this.life.length; i++) {
      if (this.life[i] !== code) continue;
      if (m) {
        const x = place[3 * i], y = place[3 * i + 1], z = place[3 * i + 2];
        const w = m[3] * x + m[7] * y + m[11] * z + m[15];
        const free = w > 0 && this.cells.take((m[0] * x + m[4] * y + m[8] * z + m[12]) / w,
          (m[1] * x + m[5] * y + m[9] * z + m[13]) / w);
        if (!free && !every) continue;
      }
      rows[count++] = i;
    }
    if (!count) return 0;
    indices.clearUpdateRanges();
    indices.addUpdateRange(0, count);
    indices.needsUpdate = true;
    return count;
  }
}
