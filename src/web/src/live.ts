// The page of a run that goes on: a socket to the server that the page came from, what it says of the
// run, and how that is shown. docs/live.md has the protocol.
import { mean } from './data';
import { byId, fixed, grouped, number } from './format';
import { GrowingRun, type RawRows } from './live_rows';
import type { Run, Summary } from './runs';

type Stage = 'waiting' | 'running' | 'smoothing' | 'finished' | 'interrupted' | 'failed';

interface Progress {
  stage: Stage;
  frames: number;
  of: number;
  /** Recorded, and on the clock. */
  seconds: number;
  wall: number;
  message: string;
  /** False where the server only looks on. */
  stoppable?: boolean;
}

interface Message extends Partial<RawRows> {
  run: string;
  progress: Progress;
  landmarks?: number;
  /** Entries of summary.json that are known by now. */
  known?: Summary;
  all?: unknown;
}

/** What the page does with what arrives. */
export interface LivePage {
  /** Another run than before. */
  begin(run: Run): void;
  /** The run that is shown has more rows, or more is known of it. */
  grow(): void;
  /** The whole page; `same`: of the run that is shown. */
  all(data: unknown, same: boolean): void;
}

const ENDS: readonly Stage[] = ['finished', 'interrupted', 'failed'];
const STAGES: Record<Stage, string> = {
  waiting: 'Waiting for the first estimate', running: 'Running',
  smoothing: 'Batch estimation over all frames', finished: 'Finished',
  interrupted: 'Stopped before its end', failed: 'Failed',
};
const BETWEEN_DRAWS = 100;  // [ms]
const FIRST_PAUSE = 500, LONGEST_PAUSE = 10000;  // between attempts to connect [ms]
const STOP_QUESTION = 4000;  // that the question stands [ms]

export class Live {
  private socket: WebSocket | null = null;
  private growing: GrowingRun | null = null;
  /** What the page reports to the server that it has. */
  private have = { run: '', rows: 0, landmarks: 0, truth: false, map: false, all: false };
  private progress: Progress | null = null;
  private pause = FIRST_PAUSE;
  private retryAt = 0;
  private retryTimer = 0;
  private asked = 0;
  private stopping = false;
  private drawTimer = 0;
  /** Since the last drawing: something was sent, the run has grown. */
  private announced = false;
  private grown = false;

  constructor(private readonly page: LivePage) {
    byId('live').hidden = false;
    document.documentElement.classList.add('is-live');
    byId('main').hidden = true;
    byId('footer-note').textContent = 'This page is fed by its own server and loads nothing else.';
    byId('live-retry').addEventListener('click', () => this.connect());
    byId('live-stop').addEventListener('click', () => this.clickStop());
    this.connect();
  }

  private connect(): void {
    clearTimeout(this.retryTimer);
    this.retryAt = 0;
    this.say('Connecting', '');
    const socket = new WebSocket(`ws://${location.host}/live${location.search}`);
    this.socket = socket;
    socket.addEventListener('open', () => {
      this.pause = FIRST_PAUSE;
      socket.send(JSON.stringify({ join: this.have }));
    });
    socket.addEventListener('message', (e) => this.take(JSON.parse(String(e.data)) as Message));
    socket.addEventListener('close', () => { if (socket === this.socket) this.lose(); });
  }

  private ended(): boolean {
    return this.progress !== null && ENDS.includes(this.progress.stage) &&
      (this.have.all || this.progress.stage === 'failed');
  }

  /** The connection is gone: after the end of the run that is how it should be. */
  private lose(): void {
    this.socket = null;
    if (!this.ended()) {
      this.retryAt = Date.now() + this.pause;
      this.pause = Math.min(2 * this.pause, LONGEST_PAUSE);
      this.countDown();
    }
    this.showState();
  }

  private countDown(): void {
    const left = this.retryAt - Date.now();
    if (left <= 0) {
      this.connect();
      return;
    }
    this.showState();
    this.retryTimer = window.setTimeout(() => this.countDown(), Math.min(left, 1000));
  }

  private take(message: Message): void {
    const same = message.run === this.have.run;
    if (!same) {
      this.have = { run: message.run, rows: 0, landmarks: 0, truth: false, map: false, all: false };
      this.stopping = false;
    }
    this.progress = message.progress;
    if (message.data) this.takeRows(message as Message & RawRows);
    if (message.all) {
      this.have.all = true;
      byId('main').hidden = false;
      this.page.all(message.all, same && this.growing !== null);
      this.growing = null;
      this.grown = false;
    }
    this.announced = true;
    this.drawSoon();
  }

  private takeRows(message: Message & RawRows): void {
    const { from, rows, landmarks, known, data } = message;
    if (from === 0) {
      this.growing = new GrowingRun(message);
      byId('main').hidden = false;
      this.announceSummary();
      this.page.begin(this.growing.run);
    } else {
      this.growing?.add(message);
    }
    this.have.rows = rows;
    this.have.landmarks = landmarks ?? this.have.landmarks;
    this.have.truth ||= data.truth !== undefined;
    this.have.map ||= data.map?.sessions !== undefined;
    if (this.growing && known) Object.assign(this.growing.run.summary, known);
    this.grown = true;
  }

  /** What the key figures take from the summary of a run that is over. */
  private announceSummary(): void {
    const run = this.growing?.run, { progress } = this;
    if (!run || !progress) return;
    const last = run.count - 1, { states, errors } = run;
    let nis = 0, dof = 0;
    for (let i = 0; i <= last; i++) {
      nis += states.nis[i];
      dof += states.nis_dof[i];
    }
    Object.assign(run.summary, { frames: run.count, landmarks: states.landmarks[last],
      health: run.healthNames[run.health[last]], nis_per_dof: dof > 0 ? nis / dof : null,
      nees_pose: errors ? mean(errors.nees_pose) : null });
    if (progress.wall > 0) run.summary.realtime_factor = progress.seconds / progress.wall;
  }

  /** A long run, or a slow screen, is drawn less often: scripts take a fifth of the time at most, and
   *  nothing is drawn before the last drawing is on the screen. */
  private drawSoon(): void {
    if (this.drawTimer) return;
    this.drawTimer = window.setTimeout(() => {
      const start = performance.now();
      this.draw();
      const pause = Math.max(BETWEEN_DRAWS, 4 * (performance.now() - start));
      requestAnimationFrame(() => requestAnimationFrame(() => {
        window.setTimeout(() => this.drawAgain(), Math.max(pause, performance.now() - start));
      }));
    }, 0);
  }

  private draw(): void {
    this.announced = false;
    this.showState();
    if (!this.grown || !this.growing) return;
    this.grown = false;
    this.announceSummary();
    this.page.grow();
  }

  private drawAgain(): void {
    this.drawTimer = 0;
    if (this.announced) this.drawSoon();
  }

  private clickStop(): void {
    if (Date.now() - this.asked < STOP_QUESTION) {
      this.stopping = true;
      this.socket?.send('{"stop": true}');
    } else {
      this.asked = Date.now();
      window.setTimeout(() => this.showState(), STOP_QUESTION + 50);
    }
    this.showState();
  }

  private showState(): void {
    const { progress, socket } = this;
    if (this.retryAt > 0) {
      this.say('Connection lost, trying again', 'lost');
    } else if (progress) {
      const gone = socket === null ? ' – the server has ended, this page keeps what it shows' : '';
      const why = progress.message ? `: ${progress.message}` : '';
      this.say(STAGES[progress.stage] + why + gone, progress.stage);
    }
    byId('live-retry').hidden = this.retryAt === 0;
    byId('live-wait').textContent = this.retryAt > 0
      ? `in ${Math.max(1, Math.ceil((this.retryAt - Date.now()) / 1000))} s` : '';
    if (progress) this.showProgress(progress);
    this.showStop();
  }

  private showStop(): void {
    const button = byId<HTMLButtonElement>('live-stop');
    const goes = this.progress?.stage === 'waiting' || this.progress?.stage === 'running';
    const may = this.progress?.stoppable !== false;
    button.hidden = !goes || !may || this.retryAt > 0 || this.socket === null;
    button.disabled = this.stopping;
    const asks = Date.now() - this.asked < STOP_QUESTION;
    button.textContent = this.stopping ? 'Stopping' : asks ? 'Really stop?' : 'Stop the run';
  }

  private showProgress({ stage, frames, of, seconds, wall }: Progress): void {
    const bar = byId<HTMLProgressElement>('live-progress'), numbers = byId('live-numbers');
    bar.hidden = of === 0 || ENDS.includes(stage);
    bar.max = Math.max(1, of);
    bar.value = frames;
    const parts = [of ? `${grouped(frames)} of ${grouped(of)} frames` : frames && `${grouped(frames)} frames`,
      seconds > 0 && `${fixed(seconds, 1)} s`,
      wall > 0 && seconds > 0 && `${number(seconds / wall, 2)} × real time`];
    numbers.textContent = parts.filter(Boolean).join('  ·  ');
  }

  /** A screen reader announces when it changes. */
  private say(text: string, kind: string): void {
    const state = byId('live-state');
    if (state.textContent !== text) state.textContent = text;
    byId('live').dataset.kind = kind;
  }
}
