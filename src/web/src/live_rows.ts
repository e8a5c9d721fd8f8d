// A run that grows: rows are added to its columns, which then are as decodeRun() would have made them.
import { type Column, type Columns, decodeColumns, extremes } from './data';
import { decodeRun, eulerAngles, type RawRun, type Run } from './runs';
import { grownMap } from './saved_map';

/** Rows that the server adds. The first `skip` rows of the data are those of the run's first state. */
export interface RawRows {
  from: number;
  rows: number;
  skip: number;
  data: RawRun;
  bounds?: Record<string, number>;
}

const ofSameKind = (column: Column, room: number): Column => {
  if (column instanceof Float64Array) return new Float64Array(room);
  return column instanceof Int32Array ? new Int32Array(room) : new Float32Array(room);
};

/** Columns with room behind, seen through views that are as long as their rows. */
class Growing {
  readonly columns: Columns = {};
  private readonly room = new Map<string, Column>();

  /** Adds the rows that follow the first `skip`; `rows` is how many there are then. What has no
   *  number for a row is unknown there. */
  add(added: Columns, skip: number, before: number, rows: number): void {
    for (const name of new Set([...Object.keys(this.columns), ...Object.keys(added)])) {
      const column = this.withRoom(name, this.columns[name] ?? added[name], rows);
      if (!this.columns[name]) column.fill(NaN, 0, before);
      if (added[name]) column.set(added[name].subarray(skip), before);
      else column.fill(NaN, before, rows);
      this.columns[name] = column.subarray(0, rows);
    }
  }

  private withRoom(name: string, like: Column, rows: number): Column {
    const held = this.room.get(name);
    if (held && held.length >= rows) return held;
    const wider = ofSameKind(like, Math.max(256, 2 * rows));
    if (held) wider.set(held);
    this.room.set(name, wider);
    return wider;
  }
}

export class GrowingRun {
  readonly run: Run;
  private readonly states = new Growing();
  private readonly errors = new Growing();
  private readonly euler = new Growing();
  private readonly stages = new Growing();
  private readonly extra: Growing[];

  constructor(first: RawRows) {
    this.run = { ...decodeRun(first.data, first.bounds ?? {}), count: 0, opening: undefined };
    this.extra = this.run.extra.map(() => new Growing());
    this.run.healthNames = [];
    this.add(first);
  }

  add({ data, skip, rows }: RawRows): void {
    const { run } = this, before = run.count;
    const states = decodeColumns(data.states);
    this.keepHealthNames(states, data.health_names);
    this.states.add(states, skip, before, rows);
    this.euler.add(eulerAngles(states), skip, before, rows);
    if (data.errors || run.errors) this.errors.add(decodeColumns(data.errors), skip, before, rows);
    this.stages.add(decodeColumns(Object.fromEntries((data.stages ?? []).entries())), skip, before, rows);
    data.extra.forEach((raw, k) => this.extra[k]?.add(decodeColumns(raw), skip, before, rows));
    run.count = rows;
    this.show(data);
  }

  /** The page's run has the columns that have grown, and what else came. */
  private show(data: RawRun): void {
    const { run } = this, { columns } = this.states;
    Object.assign(run, { states: columns, t: columns.t, health: columns.health });
    run.euler = this.euler.columns as Run['euler'];
    run.extra = this.extra.map(({ columns: c }) => ({ value: c.value, sigma: c.sigma }));
    run.stages = run.stageNames.map((_, k) => this.stages.columns[k]);
    if (Object.keys(this.errors.columns).length) run.errors = this.errors.columns;
    if (data.truth) run.truth = decodeColumns(data.truth);
    if (data.nees_coordinates) run.neesCoordinates = data.nees_coordinates;
    if (data.map) run.savedMap = grownMap(run.savedMap, data.map);
    if (data.landmarks) {
      run.landmarks = decodeColumns(data.landmarks);
      run.mapTime = extremes(run.landmarks.last)[1];
      run.landmarksLeftOut = data.landmarks_left_out ?? 0;
    }
  }

  /** Each piece counts the names of health on its own. */
  private keepHealthNames(states: Columns, names: string[]): void {
    const { healthNames } = this.run;
    for (const name of names) if (!healthNames.includes(name)) healthNames.push(name);
    states.health = states.health.map((h) => healthNames.indexOf(names[h]));
  }
}
