// A rounded number shows under the pointer, or in the keyboard's focus, what it is exactly.
import { clamp } from './data';
import { isNumber, make } from './format';

/** Attributes of an element that shows a number of summary.json. */
export const exact = (key: string, value: unknown): Record<string, string> =>
  (isNumber(value) ? { 'data-exact': `${key}: ${value}` } : {});

export function startExact(): void {
  const tip = make('div', { class: 'tip exact-tip', role: 'tooltip', hidden: '' });
  document.body.append(tip);
  const show = (e: Event) => {
    const element = e.target instanceof Element ? e.target.closest<HTMLElement>('[data-exact]') : null;
    tip.hidden = !element;
    if (!element) return;
    tip.textContent = element.dataset.exact ?? '';
    const box = element.getBoundingClientRect();
    tip.style.left = `${clamp(box.left, 4, Math.max(4, innerWidth - tip.offsetWidth - 4))}px`;
    const below = box.bottom + 6;
    const fits = below + tip.offsetHeight < innerHeight;
    tip.style.top = `${fits ? below : box.top - tip.offsetHeight - 6}px`;
  };
  document.addEventListener('pointerover', show);
  document.addEventListener('focusin', show);
  document.addEventListener('scroll', () => { tip.hidden = true; }, { passive: true });
}
