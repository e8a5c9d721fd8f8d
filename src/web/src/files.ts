// Files that the page gives away.
import { make } from './format';

/** A name that is safe as a file's name. */
export function fileName(...parts: string[]): string {
  const clean = parts.join('-').replace(/[^A-Za-z0-9._-]+/g, '_').replace(/^[._-]+/, '');
  return clean.slice(0, 80) || 'chasles';
}

export function download(name: string, blob: Blob): void {
  const link = make('a', { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export interface CsvColumn { label: string; values: ArrayLike<number> }

/** Quotes, and a leading = + - @ that a spreadsheet would take for a formula, are defused. */
const quoted = (label: string) =>
  '"' + label.replace(/^[=+@-]/, "'$&").replace(/"/g, '""') + '"';

const csvCell = (v: number | undefined) =>
  (v !== undefined && Number.isFinite(v) ? String(Number(v.toPrecision(9))) : '');

/** Columns as a csv file, rows to the longest of them. */
export function downloadCsv(name: string, columns: CsvColumn[]): void {
  const rows = [columns.map((c) => quoted(c.label)).join(',')];
  const n = Math.max(0, ...columns.map((c) => c.values.length));
  for (let i = 0; i < n; i++) rows.push(columns.map((c) => csvCell(c.values[i])).join(','));
  download(name + '.csv', new Blob([rows.join('\n') + '\n'], { type: 'text/csv' }));
}

export function downloadSvg(name: string, svg: string): void {
  download(name + '.svg', new Blob([svg], { type: 'image/svg+xml' }));
}

/** An svg of that size [css px] as a picture of twice as many pixels each way. */
export function downloadSvgAsPng(name: string, svg: string, width: number, height: number): void {
  const image = new Image();
  image.onload = () => {
    const canvas = document.createElement('canvas');
    canvas.width = 2 * width;
    canvas.height = 2 * height;
    canvas.getContext('2d')?.drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => { if (blob) download(name + '.png', blob); });
  };
  image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(svg);
}
