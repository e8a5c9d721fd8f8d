// A saved map in the scene.
import { BufferGeometry, Float32BufferAttribute, type Object3D, Points, PointsMaterial } from 'three';

import type { MapOptions } from './map_draw';
import { opacities, type SavedMap, sessionColour } from './saved_map';
import { markShown } from './saved_map_draw';
import { palette } from './theme';

/** Below the dots of a run's own landmarks. */
const ORDER = -5;

function dots(map: SavedMap, rows: number[], size: number, colours: number[] | null): Points {
  const { x, y, z } = map.marks, geometry = new BufferGeometry();
  geometry.setAttribute('position',
    new Float32BufferAttribute(rows.flatMap((i) => [x[i], y[i], z[i]]), 3));
  if (colours) geometry.setAttribute('color', new Float32BufferAttribute(colours, 4));
  const points = new Points(geometry, new PointsMaterial({ size, sizeAttenuation: false,
    transparent: Boolean(colours), vertexColors: Boolean(colours),
    color: colours ? '#ffffff' : palette.ink }));
  points.frustumCulled = false;
  points.renderOrder = colours ? ORDER + 1 : ORDER;
  return points;
}

/** A dot a landmark in the colour of its session, paler where it is uncertain; those that returned
 *  have a rim. */
export function savedMapDots(map: SavedMap, options: MapOptions): Object3D[] {
  const { marks } = map, alpha = opacities(map);
  const shown = Array.from(marks.id, (_, i) => i).filter((i) => markShown(options, marks, i));
  const colour = (i: number) => [1, 3, 5].map((k) =>
    parseInt(palette[sessionColour(marks.session[i])].slice(k, k + 2), 16) / 255);
  return [dots(map, shown.filter((i) => marks.returned[i]), 6.5, null),
    dots(map, shown, 4, shown.flatMap((i) => [...colour(i), alpha[i]]))];
}
