// Lines in the scene that are some pixels wide.
import { BufferAttribute, BufferGeometry, Mesh, Vector4, type WebGLRenderer } from 'three';
import { LineMaterial, type LineMaterialParameters } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';

/** The same lines with vertices of their own for each piece. three.js makes each piece an instance of
 *  one piece, and where a processor draws, each instance is a drawing of its own: hundreds of a path,
 *  which take several times as long as one. */
function withoutInstances(lines: LineSegmentsGeometry): BufferGeometry {
  const flat = new BufferGeometry(), pieces = lines.instanceCount;
  const corners = lines.getAttribute('position').count;
  for (const [name, attribute] of Object.entries(lines.attributes)) {
    const { itemSize } = attribute, ofPiece = name.startsWith('instance');
    const values = new Float32Array(pieces * corners * itemSize);
    for (let vertex = 0, at = 0; vertex < pieces * corners; vertex++) {
      const from = ofPiece ? Math.floor(vertex / corners) : vertex % corners;
      for (let k = 0; k < itemSize; k++) values[at++] = attribute.getComponent(from, k);
    }
    flat.setAttribute(name, new BufferAttribute(values, itemSize));
  }
  const triangles = [...(lines.getIndex()?.array ?? [])];
  flat.setIndex(Array.from({ length: pieces }, (_, piece) =>
    triangles.map((corner) => piece * corners + corner)).flat());
  // Of the lines: a mesh would take them from the corners of one piece.
  [flat.boundingBox, flat.boundingSphere] = [lines.boundingBox, lines.boundingSphere];
  return flat;
}

class WideLines extends Mesh<BufferGeometry, LineMaterial> {
  private static readonly viewport = new Vector4();

  override onBeforeRender = (renderer: WebGLRenderer): void => {
    const { z, w } = renderer.getViewport(WideLines.viewport);
    this.material.resolution.set(z, w);
  };
}

/** Pieces of line between pairs of points [m]. */
export function wideSegments(points: number[], style: LineMaterialParameters): Mesh {
  const geometry = new LineSegmentsGeometry(), material = new LineMaterial(style);
  geometry.setPositions(points);
  if (style.dashed) new LineSegments2(geometry, material).computeLineDistances();
  return new WideLines(withoutInstances(geometry), material);
}

/** A line through all of the points [m]. */
export function widePath(points: number[], style: LineMaterialParameters): Mesh {
  const pairs: number[] = [];
  for (let i = 0; i + 6 <= points.length; i += 3) pairs.push(...points.slice(i, i + 6));
  return wideSegments(pairs, style);
}
