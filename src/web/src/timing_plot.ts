// What a frame took, in all and by its stages.
import { type Column, extremes, mean, quantile } from './data';
import { number } from './format';
import type { PlotSpec, Series } from './plot_spec';
import type { Run } from './runs';

const STAGES: Record<string, { label: string; colour: string }> = {
  front_end: { label: 'front end', colour: 'f-7' },
  propagation: { label: 'propagation', colour: 'f-5' },
  update: { label: 'update', colour: 'f-6' },
  landmarks: { label: 'landmarks', colour: 'f-8' },
};
const SPARE = ['f-1', 'f-2', 'f-3', 'f-4'];

/** The stages on top of each other. */
function stacked(names: string[], stages: Column[]): Series[] {
  let below = new Float32Array(stages[0].length);
  return stages.map((values, k) => {
    const low = below, high = low.map((v, i) => v + values[i]);
    below = high;
    const { label, colour } = STAGES[names[k]] ??
      { label: names[k].replaceAll('_', ' '), colour: SPARE[k % SPARE.length] };
    return { label, name: label, style: 'stack', values, low, high, colour };
  });
}

export function timingPlot(run: Run): PlotSpec | null {
  const { milliseconds: ms, t } = run.states;
  if (!(extremes(ms)[1] > 0)) return null;
  const period = run.count > 1 ? 1000 * (t[run.count - 1] - t[0]) / (run.count - 1) : NaN;
  const known = run.stages.length > 0;
  const frontEnd = run.stageNames.includes('front_end');
  return {
    title: known ? 'Time per stage' : 'Time per frame',
    ...(known ? { height: 160 } : {}),
    caption: 'Wall time that a frame took' + (Number.isFinite(period)
      ? `: ${number(mean(ms))} ms on average, and a frame arrives every ${number(period)} ms.`
      : '.') +
      (known ? ' Stages are stacked: the state’s propagation, the update with its gate, initialisation, ' +
        'conversion and retirement of landmarks. The rest up to the line is reading, waiting and writing.' : '') +
      (frontEnd ? ' The front end may work beside the filter, ahead of it: then the stages add up to ' +
        'more than the frame.' : '') +
      (quantile(ms, 1) > 3 * quantile(ms, 0.99) ? ' Single spikes are cut off.' : ''),
    panels: [{
      label: '', unit: 'ms', zero: true, clip: true,
      summary: `median ${number(quantile(ms, 0.5))} ms, 99 % below ${number(quantile(ms, 0.99))} ms`,
      // The line first, so that it lies below the stages.
      series: known ? [{ label: 'whole frame', name: 'whole frame', style: 'line', values: ms, colour: 'ink' },
        ...stacked(run.stageNames, run.stages)]
        : [{ label: 'time', style: 'line', values: ms, colour: 'estimate', legend: false },
          { label: 'median', style: 'level', values: quantile(ms, 0.5), colour: 'muted' }],
    }],
  };
}
