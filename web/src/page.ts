// Starts the page of runs: reads the data, builds the parts, keeps them together.
import 'uplot/dist/uPlot.min.css';
import '../styles/page.css';

import { pageData } from './data';
import { startExact } from './exact';
import { byId } from './format';
import { showAtTime, showRunLine, startPicker } from './header';
import { Overview } from './overview';
import { overviewPlots } from './overview_table';
import { Player } from './player';
import { followStore, plotsInColumns, showPlots } from './plot_list';
import { plotSpecs } from './plots';
import { activeRun, colourRuns, decodeRun, labelRuns, type RawRun } from './runs';
import { type RawScene, readScenes } from './scenes';
import { app, listen, setActive, throttled } from './store';
import { showCards, showFigures, showHealth, showRemarks, showSettings } from './tables';
import { startTheme } from './theme';
import { World } from './world';

function readData(): void {
  const data = pageData() as
    { runs: RawRun[]; scenes?: RawScene[]; bounds: Record<string, number> };
  const runs = data.runs.map((raw) => decodeRun(raw, data.bounds));
  labelRuns(runs);
  colourRuns(runs);
  app.subjects = runs;
  readScenes(data.scenes);
}

function showRunPlots(): void {
  const run = activeRun();
  showPlots([...overviewPlots(), ...plotSpecs(run)], plotsInColumns);
  byId('health-key').hidden = !run.states.health.some((h) => run.healthNames[h] !== 'ok');
}

readData();
startTheme();
startExact();
startPicker();
new Player();
new Overview();
new World();
showFigures();
showSettings();
for (const show of [showRunLine, showCards, showRemarks, showHealth, showRunPlots]) listen('run', show);
listen('cursor', throttled(showAtTime));
followStore();
setActive(0);
