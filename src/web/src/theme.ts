// Colours come from the style sheet, so that the canvases follow light, dark and print.
import { clamp } from './data';
import { byId } from './format';
import { notify } from './store';

const NAMES = ['ink', 'muted', 'line', 'panel', 'ground', 'estimate', 'truth', 'dead', 'landmark',
  'initial', 'cursor', 'band', 'good', 'bad', 'warn',
  'f-1', 'f-2', 'f-3', 'f-4', 'f-5', 'f-6', 'f-7', 'f-8',
  // Of studies alone: study.css.
  'left-invariant', 'estimated-landmark'];

export const palette: Record<string, string> = {};

function readPalette(): void {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) palette[name] = style.getPropertyValue('--' + name).trim();
}

/** A colour of the palette with an opacity. */
export function faded(name: string, alpha: number): string {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(palette[name].slice(k, k + 2), 16));
  return `rgba(${r},${g},${b},${alpha})`;
}

export const currentTheme = (): string => document.documentElement.dataset.theme ?? 'light';

function applyTheme(theme: string): void {
  document.documentElement.dataset.theme = theme;
  byId('theme-button').textContent = theme === 'dark' ? 'Light' : 'Dark';
  readPalette();
  notify('theme');
}

/** Follows the system until the reader chooses; a print is always light. */
export function startTheme(): void {
  const system = matchMedia('(prefers-color-scheme: dark)');
  let chosen: string | null = null;
  const wanted = () => chosen ?? (system.matches ? 'dark' : 'light');
  byId('theme-button').addEventListener('click', () => {
    chosen = currentTheme() === 'dark' ? 'light' : 'dark';
    applyTheme(chosen);
  });
  byId('print-button').addEventListener('click', () => window.print());
  system.addEventListener('change', () => applyTheme(wanted()));
  // Canvases do not follow the paper's layout by themselves: the page takes its width first.
  window.addEventListener('beforeprint', () => {
    document.documentElement.classList.add('printing');
    applyTheme('light');
    notify('print');
  });
  window.addEventListener('afterprint', () => {
    document.documentElement.classList.remove('printing');
    applyTheme(wanted());
  });
  applyTheme(wanted());
}

// From dark violet over teal to yellow: lightness rises evenly, so the order shows in every kind of
// colour vision and in grey print.
const RAMP = [[62, 22, 98], [54, 78, 140], [30, 128, 142], [48, 172, 116], [142, 208, 66],
  [252, 226, 60]];

/** A colour for s in 0…1, red, green and blue in 0…255. The end that vanishes into the ground is
 *  cut off. */
export function rampColour(s: number): number[] {
  const [low, high] = currentTheme() === 'dark' ? [0.28, 1] : [0, 0.86];
  const x = (low + (high - low) * clamp(s, 0, 1)) * (RAMP.length - 1);
  const i = Math.min(Math.floor(x), RAMP.length - 2);
  return RAMP[i].map((c, k) => Math.round(c + (x - i) * (RAMP[i + 1][k] - c)));
}

export const ramp = (s: number): string => `rgb(${rampColour(s).join(',')})`;
