// Starts the page of runs: reads the data, builds the parts, keeps them together.
import 'uplot/dist/uPlot.min.css';
import '../styles/page.css';

import { showClosures } from './closures';
import { pageData } from './data';
import { startExact } from './exact';
import { byId } from './format';
import { showAtTime, showPicker, showRunLine, startPicker } from './header';
import { ImagePanel } from './image_panel';
import { Live } from './live';
import { Overview } from './overview';
import { overviewPlots } from './overview_table';
import { Player } from './player';
import { followStore, plotsInColumns, showPlots, updatePlots } from './plot_list';
import { plotSpecs } from './plots';
import { activeRun, colourRuns, decodeRun, labelRuns, type RawRun, type Run } from './runs';
import { type RawScene, readScenes } from './scenes';
import { app, grow, listen, setActive, throttled } from './store';
import { showCards, showFigures, showHealth, showRemarks, showSettings } from './tables';
import { startTheme } from './theme';
import { World } from './world';

interface PageData { runs: RawRun[]; scenes?: RawScene[]; bounds: Record<string, number> }

function setRuns(runs: Run[], scenes?: RawScene[]): void {
  labelRuns(runs);
  colourRuns(runs);
  app.subjects = runs;
  readScenes(scenes);
  showPicker();
  showFigures();
  showSettings();
}

function readData({ runs, scenes, bounds }: PageData): void {
  setRuns(runs.map((raw) => decodeRun(raw, bounds)), scenes);
}

const runPlots = () => [...overviewPlots(), ...plotSpecs(activeRun())];

function showHealthKey(): void {
  const run = activeRun();
  byId('health-key').hidden = !run.states.health.some((h) => run.healthNames[h] !== 'ok');
}

/** A run that comes over the socket. */
const livePage = {
  begin(run: Run): void {
    setRuns([run]);
    setActive(0);
  },
  grow,
  all(data: unknown, same: boolean): void {
    readData(data as PageData);
    if (same) grow(); else setActive(0);
  },
};

const data = pageData() as PageData & { live?: boolean };
startTheme();
startExact();
startPicker();
new Player();
new Overview();
new World();
new ImagePanel();
for (const show of [showRunLine, showCards, showRemarks, showHealth, showHealthKey, showClosures]) {
  listen('run', show);
  listen('rows', show);
}
listen('rows', showFigures);
listen('run', () => showPlots(runPlots(), plotsInColumns));
listen('rows', () => updatePlots(runPlots(), plotsInColumns));
listen('cursor', throttled(showAtTime));
followStore();
if (data.live) {
  new Live(livePage);
} else {
  readData(data);
  setActive(0);
}
