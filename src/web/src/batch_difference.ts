// What became better or worse since an earlier batch.
import type { Difference, Ratio, Verdict } from './batch_data';
import { fixed, make } from './format';

function ratioLine(figure: string, { ratio, low, high, pairs }: Ratio): HTMLElement {
  const interval = low === null || high === null ? '' : ` (95 %: ${fixed(low, 3)} to ${fixed(high, 3)})`;
  return make('li', {}, make('b', {}, figure),
    ` ${fixed(ratio, 3)} times that of the earlier batch${interval}, ${pairs} recordings`);
}

/** Lists of the recordings with another verdict, and of the figures. */
export function differenceList(difference: Difference, badge: (verdict: Verdict) => Node): Node[] {
  const { better, worse, only_before: gone, only_now: added, figures } = difference;
  const changes = [...worse, ...better].map(({ name, before, now }) =>
    make('li', {}, badge(before), ' → ', badge(now), make('span', { dir: 'auto' }, ` ${name}`)));
  return [
    make('p', {}, `${worse.length} worse, ${better.length} better, ${added.length} new, ${gone.length} gone`),
    make('ul', { class: 'changes' }, ...changes),
    make('ul', {}, ...Object.entries(figures).map(([figure, ratio]) => ratioLine(figure, ratio))),
  ];
}
