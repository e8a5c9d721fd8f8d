// What tells the runs of a page apart: a name and a colour, the same in every figure.

const CHARTS = ['standard', 'left-se3', 'right-se3', 'right-sen3'];
const SPARE_HUES = ['f-5', 'f-6', 'f-7', 'f-8'];

const chartOf = (run) => [(run.summary.settings || {}).chart, run.summary.chart]
  .find((v) => typeof v === 'string') || '';

/** Each chart has its colour; a further run of the same chart takes a spare one and a broken line. */
function colourRuns(runs) {
  const taken = new Set();
  let spare = 0;
  for (const run of runs) {
    const own = `f-${1 + CHARTS.indexOf(chartOf(run))}`;
    const first = own !== 'f-0' && !taken.has(own);
    run.colour = first ? own : SPARE_HUES[spare++ % SPARE_HUES.length];
    run.dash = first ? [] : [8, 4];
    taken.add(run.colour);
  }
}

/** Names for legends: short, and different for each run: the recordings', or the folders' where two
 *  runs are of one recording. */
function labelRuns(runs) {
  const count = (key, value) => runs.filter((r) => r[key] === value).length;
  const short = (text) => (text.length > 40 ? text.slice(0, 39) + '…' : text);
  const twins = runs.some((run) => count('name', run.name) > 1);
  runs.forEach((run, k) => {
    const ownFolder = twins && run.folder && count('folder', run.folder) === 1;
    const name = (ownFolder ? run.folder : run.name) || 'run';
    const cut = runs.length > 1 && short(name) !== name;
    run.label = count('name', run.name) > 1 && !ownFolder || cut ? `${k + 1}: ${short(name)}` : short(name);
  });
}

/** The colour of the run that the page shows: alone it is the estimate. */
const estimateColour = () => (app.runs.length > 1 ? activeRun().colour : 'estimate');
