// Plays the run: the time cursor moves on its own.
import { nearestIndex } from './data';
import { byId } from './format';
import { activeSubject, app, listen, setCursor } from './store';

const ENTIRE_RUN = 20;  // seconds that the whole run takes at the speed 'whole run'

export class Player {
  private readonly button = byId('play');
  private readonly speed = byId<HTMLSelectElement>('speed');
  private playing = false;
  /** Of the run [s], and of the screen [ms]; where the player, not the reader, put the cursor. */
  private time = 0;
  private shownAt = 0;
  private ownCursor = -1;

  constructor() {
    this.button.addEventListener('click', () => (this.playing ? this.stop() : this.start()));
    const slider = byId<HTMLInputElement>('time');
    slider.addEventListener('input', () => setCursor(Number(slider.value)));
    listen('run', () => this.stop());
    listen('cursor', () => {
      // Somebody else moved it: the film goes on from there.
      if (app.cursor !== this.ownCursor) this.time = activeSubject().t[app.cursor];
    });
  }

  /** Seconds of the run in a second. */
  private rate(): number {
    const value = Number(this.speed.value);
    return value > 0 ? value : app.fullSpan[1] / ENTIRE_RUN;
  }

  private start(): void {
    const { t, count } = activeSubject();
    if (count < 2) return;
    if (app.cursor >= count - 1) setCursor(0);
    this.time = t[app.cursor];
    this.shownAt = performance.now();
    this.setPlaying(true);
    requestAnimationFrame((now) => this.step(now));
  }

  private step(now: number): void {
    if (!this.playing) return;
    const { t, count } = activeSubject();
    this.time += this.rate() * Math.max(0, now - this.shownAt) / 1000;
    this.shownAt = now;
    this.ownCursor = nearestIndex(t, this.time);
    setCursor(this.ownCursor);
    if (this.time >= t[count - 1]) this.stop();
    else requestAnimationFrame((next) => this.step(next));
  }

  private stop(): void {
    this.setPlaying(false);
  }

  private setPlaying(playing: boolean): void {
    this.playing = playing;
    this.button.textContent = playing ? '❚❚' : '▶';
    this.button.setAttribute('aria-label', playing ? 'Pause' : 'Play');
  }
}
