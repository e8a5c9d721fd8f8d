// The outliers among the runs of a study, by number, with the commands that do them again.
import { byId, fixed, make } from './format';
import { activeStudy, type Study } from './studies';
import { boxOf, MEASURES } from './study_boxes';
import { filterName } from './study_colours';
import { commandOf } from './study_command';
import { DEGREES_OF_POSE } from './study_tables';

const FAR_BOXES = 3, MOST_OUTLIERS = 40;

/** Diverged runs, and runs farther than three boxes above the box in one of the measures. */
interface Outlier { k: number; i: number; why: string; far: number }

function outliersOf(study: Study): Outlier[] {
  const found: Outlier[] = [];
  const { trials } = study;
  trials.run.forEach((_, i) => {
    if (trials.diverged[i]) found.push({ k: trials.filter[i], i, why: 'diverged', far: Infinity });
  });
  study.filters.forEach((_, k) => MEASURES.forEach((measure) => {
    const box = boxOf(study, k, measure);
    if (!box || box.runs.length < 4) return;
    const reach = box.q3 - box.q1;
    for (const { run, value } of box.runs) {
      const far = (value - box.q3) / reach;
      if (!(far > FAR_BOXES)) continue;
      const i = trials.run.findIndex((r, j) => r === run && trials.filter[j] === k);
      const why = measure.title.replace(/ of each run.*/, '').toLowerCase().replace('nees', 'NEES');
      const same = found.find((f) => f.i === i);
      if (!same) found.push({ k, i, why, far });
      else Object.assign(same, { why: `${same.why}, ${why}`, far: Math.max(same.far, far) });
    }
  }));
  return found.sort((a, b) => (b.far === a.far ? a.i - b.i : b.far - a.far));
}

/** A command, which names all settings, to be opened and copied: a click takes all of it. */
const commandBox = (command: string): HTMLElement => make('details', {},
  make('summary', { class: 'muted small' }, 'its command'),
  make('code', { class: 'command small', tabindex: 0, role: 'region',
    'aria-label': 'The command of this run' }, command));

export function showOutliers(): void {
  const study = activeStudy();
  byId('outliers-panel').hidden = study.single;
  const found = outliersOf(study), { trials } = study;
  const cell = (v: number, digits: number) => make('td', { class: 'figure' }, fixed(v, digits));
  const rows = found.slice(0, MOST_OUTLIERS).map(({ k, i, why }) => make('tr', {},
    make('th', { scope: 'row' }, filterName(k)), make('td', { class: 'figure' }, String(trials.run[i])),
    make('td', {}, why, commandBox(commandOf(study, k, trials.run[i]))),
    cell(trials.position_error[i], 3), cell(trials.attitude_error[i], 3),
    cell(trials.nees_pose[i] / DEGREES_OF_POSE, 2)));
  const head = make('tr', {}, ...['filter', 'run', 'far out in', 'position [m]', 'attitude [°]',
    'pose NEES / dof'].map((h) => make('th', { scope: 'col' }, h)));
  byId('outliers').replaceChildren(...(rows.length
    ? [make('table', {}, make('thead', {}, head), make('tbody', {}, ...rows))] : []));
  const more = found.length > MOST_OUTLIERS ? ` The first ${MOST_OUTLIERS} of ${found.length}.` : '';
  byId('outliers-caption').textContent = (found.length ? '' : 'None. ') + 'Runs that diverged, or whose ' +
    `average lies more than ${FAR_BOXES} boxes above the box of its filter.${more} ` +
    'The command of a run does it again by itself and makes its page; a scene along a path needs ' +
    '--path FILE as the study had it.';
}
