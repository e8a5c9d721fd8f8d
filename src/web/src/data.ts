// The numbers that travel in the page: json with columns of base64.
import { unzlibSync } from 'fflate';

export type Column = Float32Array | Float64Array | Int32Array;
export type Columns = Record<string, Column>;
export type Axis = 'x' | 'y' | 'z';
export type Vector = [number, number, number];
/** One number for all rows, or one a row. */
export type Values = ArrayLike<number> | number;

export const AXES: readonly Axis[] = ['x', 'y', 'z'];
export const DEG = 180 / Math.PI;

function bytesOf(base64: string): Uint8Array {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Little-endian numbers from their planes: first the first bytes of all numbers, then the second … */
function fromPlanes(planes: Uint8Array, size: number): ArrayBuffer {
  const n = planes.length / size;
  const bytes = new Uint8Array(planes.length);
  for (let k = 0; k < size; k++) {
    for (let i = 0; i < n; i++) bytes[i * size + k] = planes[k * n + i];
  }
  return bytes.buffer;
}

/** A column "f32:…", "f64:…" or "i32:…": base64 of the zlib stream of the numbers' byte planes. */
export function column(text: string): Column {
  const planes = unzlibSync(bytesOf(text.slice(4)));
  switch (text.slice(0, 4)) {
    case 'f32:': return new Float32Array(fromPlanes(planes, 4));
    case 'f64:': return new Float64Array(fromPlanes(planes, 8));
    case 'i32:': return new Int32Array(fromPlanes(planes, 4));
    default: throw new Error(`unknown column ${text.slice(0, 4)}`);
  }
}

export function decodeColumns(group: Record<string, string> | undefined): Columns {
  const out: Columns = {};
  for (const [name, text] of Object.entries(group ?? {})) out[name] = column(text);
  return out;
}

/** The json that the program put into the page. */
export const pageData = (): unknown =>
  JSON.parse(document.getElementById('report-data')?.textContent ?? '{}');

export const clamp = (v: number, low: number, high: number): number =>
  Math.min(high, Math.max(low, v));

export const at = (values: Values, i: number): number =>
  (typeof values === 'number' ? values : values[i]);

/** Index of the value nearest to v in a rising array. */
export function nearestIndex(sorted: ArrayLike<number>, v: number): number {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= v) low = middle; else high = middle;
  }
  return high >= 0 && Math.abs(sorted[high] - v) < Math.abs(sorted[low] - v) ? high : low;
}

/** The q-quantile of the finite values; NaN when there are none. */
export function quantile(values: ArrayLike<number>, q: number): number {
  const finite = Float64Array.from(Array.from(values).filter(Number.isFinite)).sort();
  return finite.length ? finite[Math.round(q * (finite.length - 1))] : NaN;
}

export function mean(values: ArrayLike<number>): number {
  let sum = 0, n = 0;
  for (let i = 0; i < values.length; i++) {
    if (Number.isFinite(values[i])) { sum += values[i]; n++; }
  }
  return n ? sum / n : NaN;
}

/** Least and greatest of the finite values; [Infinity, -Infinity] when there are none. */
export function extremes(values: ArrayLike<number>): [number, number] {
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < values.length; i++) {
    const v = values[i];
    if (!Number.isFinite(v)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return [low, high];
}

/** The share of the finite values within [low, high]. */
export function shareInside(values: ArrayLike<number>, low: Values, high: Values): number {
  let inside = 0, n = 0;
  for (let i = 0; i < values.length; i++) {
    if (!Number.isFinite(values[i])) continue;
    n++;
    if (values[i] >= at(low, i) && values[i] <= at(high, i)) inside++;
  }
  return n ? inside / n : NaN;
}
