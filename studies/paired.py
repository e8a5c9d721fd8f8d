#!/usr/bin/env python3
"""python3 -m studies.paired: tests on every scene and recording whether the batch's error is below the filter's,
and with what confidence. It fills the table of studies/batch.md between its markers. In a simulated scene
a pair is a run, and its error is the ATE. In a recording a pair is a block, and its error is that of
the motion over the block. p comes from random signs of the differences, with Holm's correction for the
number of rows. The script needs numpy and half an hour of processor time. out/runs keeps the runs:
remove it to start again."""

import json
import math

import numpy as np

from studies.pages import fill
from studies.pairs import DRAWS, PAGE, holm, interval, metres, sign_flips, signed, small, table, verdict
from studies.trajectories import DRIVE, EUROC, FLIGHTS, OUT, ate, chasles, cuts, drives, errors, runs_of, walks

# Least squares, because there are no outliers (studies/convergence.md).
EXACT = ["--set", "batch.loss=none", "--set", "batch.gate=0"]
PIECE = OUT / "V1_02-30-40s.tum"  # for the scene trajectory: a quadrotor in the middle of its flight
SCENES = {
    "turntable": ["--scene-set", "revolutions=0.3"],
    "hallway": ["--scene-set", "hall_length=12", "--scene-set", "hall_width=8", "--scene-set", "sections=1"],
    "walk": ["--scene-set", "walk_duration=24"],
    "trajectory": ["--path", PIECE],
}
RUNS = 100
STREETS = 15


class Row:
    """Paired errors of both and their ATEs; also log(batch / filter) of the ATEs with random signs of the block errors."""

    def __init__(self, name, kind, shares, pairs, ates, log_ratios=None):
        self.name, self.kind, self.shares, self.pairs, self.ates, self.log_ratios = name, kind, shares, np.array(pairs), ates, log_ratios
        self.differences = self.pairs[:, 1] - self.pairs[:, 0]
        self.p = sign_flips(self.differences)
        self.log_error = 0.5 * math.log(np.mean(self.pairs[:, 1] ** 2) / np.mean(self.pairs[:, 0] ** 2))


def write_piece():
    """Poses of V1_02 every 20 ms, from 30 s to 40 s after its first."""
    OUT.mkdir(parents=True, exist_ok=True)
    rows = np.loadtxt(EUROC / "imu_gt/V1_02_medium_gt.csv.gz", delimiter=",", usecols=range(8))
    seconds = (rows[:, 0] - rows[0, 0]) * 1e-9
    kept = ((seconds >= 30) & (seconds <= 40)).nonzero()[0][::4]
    np.savetxt(PIECE, np.column_stack([seconds, rows[:, 1:4], rows[:, 5:8], rows[:, 4]])[kept], fmt="%.9f")


def scene(name, arguments):
    folder = OUT / f"{name}-{RUNS}"
    OUT.mkdir(parents=True, exist_ok=True)
    chasles("montecarlo", name, *arguments, "--runs", RUNS, "--workers", 1, "--charts", "right-sen3",
            "--estimators", "filter,batch", *EXACT, "--resume", "-o", folder)
    found = {}
    for line in (folder / "trials.jsonl").read_text().splitlines():
        t = json.loads(line)
        found[t["run"], t["filter"].endswith("+batch")] = t["ate_posyaw_m"]
    pairs = [(found[run, False], found[run, True]) for run in range(RUNS)]
    return Row(f"{name}, {RUNS} runs", "scene", name, pairs, np.mean(pairs, axis=0))


def streets():
    pairs = []
    for seed in range(1, STREETS + 1):
        recording = OUT / f"street-{seed}"
        if not recording.exists():
            OUT.mkdir(parents=True, exist_ok=True)
            chasles("simulate", "street", "--set", "route=R", "--set", "block_length=60", "--set", "block_width=60", "--seed", seed, "-o", recording)
        truth, runs = runs_of(f"street-{seed}-run", [recording])
        pairs.append([ate(runs[e].p, truth.p) for e in ("filter", "batch")])
    return Row(f"street, {STREETS} runs", "scene", "street", pairs, np.mean(pairs, axis=0))


def recording(name, arguments, kind, shares, adds_up):
    truth, runs = runs_of(name, arguments)
    at = cuts(truth)
    blocks = {e: errors(runs[e], truth, at[:-1], at[1:]) for e in runs}
    pairs = np.stack([np.linalg.norm(blocks[e][1], axis=1) for e in ("filter", "batch")], axis=1)
    ates = [ate(runs[e].p, truth.p) for e in ("filter", "batch")]
    if not adds_up:
        return Row(name, kind, shares, pairs, ates)
    signs = np.random.default_rng(1).choice([-1, 1], (DRAWS, len(at) - 1))
    drawn = {e: ate(walks(truth, at, *blocks[e], signs), truth.p[at]) for e in runs}
    return Row(name, kind, shares, pairs, ates, np.log(drawn["batch"] / drawn["filter"]))


def line(row, adjusted):
    f, b = row.pairs.mean(axis=0)
    low, high = interval(row.differences)
    better = "-" if row.log_ratios is None else f"{100 * np.mean(row.log_ratios < 0):.0f} %"
    return [row.name, str(len(row.pairs)), f"{metres(f)} → {metres(b)}", f"{signed(low)} to {signed(high)}", f"{small(row.p)}, {small(adjusted)}",
            verdict(row.differences.mean(), row.p, adjusted), f"{metres(row.ates[0])} → {metres(row.ates[1])}", better]


def rows_table(rows):
    adjusted = holm(np.array([row.p for row in rows]))
    header = {"scene or recording": "---", "pairs": "---:", "error of a pair, filter → batch [m]": "---", "batch − filter, 95 % interval [m]": "---",
              "p, corrected p": "---", "batch is": "---", "ATE, filter → batch [m]": "---",
              "sign draws with lower batch ATE": "---:"}
    return table(header, [line(r, a) for r, a in zip(rows, adjusted)])


def pooled(rows, title, of):
    """Averages the rows of one drive, or of one flight, before the statistics."""
    groups = {}
    for row in rows:
        groups.setdefault(row.shares, []).append(of(row))
    logs = np.array([np.mean(g) for g in groups.values()])
    low, high = interval(logs)
    return [title, str(len(logs)), f"{math.exp(logs.mean()):.3f}", f"{math.exp(low):.3f} to {math.exp(high):.3f}", f"{sum(logs > 0)}", small(sign_flips(logs))]


def pools(rows):
    error = lambda r: r.log_error
    ratio = lambda r: math.log(r.ates[1] / r.ates[0])
    drawn = lambda r: r.log_ratios.mean()
    recordings, real = [r for r in rows if r.kind != "scene"], [r for r in rows if r.kind == "drive"]
    header = {"figure": "---", "drives, flights": "---:", "batch / filter": "---:", "95 % interval": "---:", "of them above 1": "---:", "p": "---:"}
    return table(header, [pooled(real, "drives: RMS error over a block", error), pooled(real, "drives: ATE", ratio),
                          pooled(real, "drives: ATE, mean over the sign draws", drawn), pooled(recordings, "drives and flights: RMS error over a block", error),
                          pooled(recordings, "drives and flights: ATE", ratio)])


def neighbours(rows):
    """The correlation of a block's difference with the next one's, over all recordings."""
    centred = [r.differences - r.differences.mean() for r in rows if r.kind != "scene"]
    scaled = [d / d.std() for d in centred]
    n = sum(len(d) - 1 for d in scaled)
    return sum((d[1:] * d[:-1]).sum() for d in scaled) / n, 1 / math.sqrt(n)


def main():
    write_piece()
    rows = [scene(name, arguments) for name, arguments in SCENES.items()]
    rows.append(streets())
    rows += [recording(name, arguments, "drive", DRIVE.get(name, name), True) for name, arguments in drives()]
    rows += [recording(name, arguments, "flight", shares, adds_up) for name, arguments, shares, adds_up in FLIGHTS]
    correlation, error = neighbours(rows)
    fill(PAGE, "paired", "\n\n".join([rows_table(rows), pools(rows), f"Correlation of the differences of neighbouring blocks, over all recordings: {correlation:+.2f} ± {error:.2f}."]))


main()
