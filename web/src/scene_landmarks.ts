// The landmarks of the scene: dots that show what each is at the time of the cursor.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Float32BufferAttribute, Group, Points,
  PointsMaterial } from 'three';

import { type Life, LIVES, rowsByLife } from './landmark_life';
import type { MapOptions } from './map_draw';
import { landmarkScale } from './map_view';
import type { Run } from './runs';
import { palette, rampColour } from './theme';

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

/** A dot a landmark, coloured as on the map: those in view are large with a rim, the retired ones
 *  pale, those seen later grey. */
export class LandmarkDots {
  readonly group = new Group();
  private readonly layers: { life: Life; indices: BufferAttribute; geometry: BufferGeometry }[] = [];

  constructor(private readonly run: Run, options: MapOptions) {
    const position = new Float32BufferAttribute(positions(run.landmarks), 3);
    const colour = new Float32BufferAttribute(colours(run, options.colour), 3);
    const add = (life: Life, size: number, opacity: number, plain?: string) => {
      if (!options.show[life]) return;
      const geometry = new BufferGeometry();
      const indices = new BufferAttribute(new Uint32Array(run.landmarks.id.length), 1);
      indices.setUsage(DynamicDrawUsage);
      geometry.setAttribute('position', position);
      if (!plain) geometry.setAttribute('color', colour);
      geometry.setIndex(indices);
      const points = new Points(geometry, new PointsMaterial({ size, sizeAttenuation: false, opacity,
        transparent: opacity < 1, vertexColors: !plain, color: plain ? palette[plain] : '#ffffff' }));
      points.renderOrder = LIVES.indexOf(life) - LIVES.length;
      this.group.add(points);
      this.layers.push({ life, indices, geometry });
    };
    add('later', 2.5, 0.35, 'muted');
    add('retired', 3, 0.7);
    add('view', 6.5, 1, 'ink');
    add('view', 4.5, 1);
  }

  /** Shows what the landmarks are at that time of the run. Those that a live run has got since
   *  these dots were made come with the next ones. */
  setTime(t: number): void {
    const rows = rowsByLife(this.run, t);
    for (const { life, indices, geometry } of this.layers) {
      const made = rows[life].filter((row) => row < indices.count);
      (indices.array as Uint32Array).set(made);
      indices.needsUpdate = true;
      geometry.setDrawRange(0, made.length);
    }
  }
}
