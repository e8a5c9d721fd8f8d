#!/usr/bin/env python3
"""python3 -m studies.halves [DRAWS [FLIGHTS]]: batch against filter on each recording, averaged over the choice
of tracked points. Both get the same random half of the tracks, DRAWS times (16; flights 6), each time
with other tracks. A pair is a block of the recording; its errors are those of the motion over it,
averaged over the draws. All draws share truth, velocities and scene, so a draw is not a pair. The
script fills the table of studies/batch.md between its markers. It needs numpy and twenty minutes of two
cores. out/halves.jsonl keeps the results: remove it to start again."""

import json
import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from studies.pages import fill
from studies.pairs import PAGE, holm, interval, metres, sign_flips, signed, small, table, verdict
from studies.trajectories import ESTIMATORS, FLIGHTS, OUT, ROOT, ate, compared, cuts, drives, errors

DRAWS = int(sys.argv[1]) if len(sys.argv) > 1 else 16
OF_FLIGHTS = int(sys.argv[2]) if len(sys.argv) > 2 else 6
KEPT = ROOT / "out/halves.jsonl"


def half(name, arguments, seed):
    """Errors of both on a half of the tracks: over each block, and ATE. None if one of them fails."""
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=OUT) as folder:
        try:
            truth, runs = compared(pathlib.Path(folder), name, [*arguments, "--tracks", 0.5, "--tracks-seed", seed])
        except subprocess.CalledProcessError:
            return None
        at = cuts(truth)
        blocks = lambda e: np.linalg.norm(errors(runs[e], truth, at[:-1], at[1:])[1], axis=1).tolist()
        return {"blocks": [blocks(e) for e in ESTIMATORS], "ate": [ate(runs[e].p, truth.p) for e in ESTIMATORS]}


def all_halves(recordings):
    """The results of the draws by recording; finished draws are read from the file."""
    found = {}
    if KEPT.exists():
        for line in KEPT.read_text().splitlines():
            kept = json.loads(line)
            found[kept["recording"], kept["seed"]] = kept["errors"]
    missing = [(name, arguments, seed) for name, arguments, draws in recordings for seed in range(1, draws + 1) if (name, seed) not in found]
    KEPT.parent.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(2) as pool, KEPT.open("a") as kept:
        for (name, _, seed), of in zip(missing, pool.map(lambda m: half(*m), missing)):
            found[name, seed] = of
            kept.write(json.dumps({"recording": name, "seed": seed, "errors": of}) + "\n")
            kept.flush()
    return {name: [found[name, seed] for seed in range(1, draws + 1)] for name, _, draws in recordings}


class Row:
    """Errors over the blocks, (filter, batch), mean over the draws; ATEs of the draws."""

    def __init__(self, name, draws):
        self.name, self.failed = name, sum(d is None for d in draws)
        draws = [d for d in draws if d is not None]
        self.pairs = np.mean([d["blocks"] for d in draws], axis=0).T
        self.ates = np.array([d["ate"] for d in draws])
        self.differences = self.pairs[:, 1] - self.pairs[:, 0]
        self.p = sign_flips(self.differences)


def line(row, adjusted):
    f, b = row.pairs.mean(axis=0)
    low, high = interval(row.differences)
    ates, less = row.ates.mean(axis=0), np.mean(row.ates[:, 1] < row.ates[:, 0])
    draws = f"{len(row.ates)}" + (f", {row.failed} failed" if row.failed else "")
    return [row.name, draws, f"{len(row.pairs)}", f"{metres(f)} → {metres(b)}", f"{100 * (b / f - 1):+.0f} %".replace("-", "−"), f"{signed(low)} to {signed(high)}",
            f"{small(row.p)}, {small(adjusted)}", verdict(row.differences.mean(), row.p, adjusted), f"{metres(ates[0])} → {metres(ates[1])}", f"{100 * less:.0f} %"]


def main():
    recordings = [(name, arguments, DRAWS) for name, arguments in drives()] + [(name, arguments, OF_FLIGHTS) for name, arguments, _, _ in FLIGHTS]
    rows = [Row(name, draws) for name, draws in all_halves(recordings).items()]
    adjusted = holm(np.array([r.p for r in rows]))
    header = {"recording": "---", "draws": "---:", "blocks": "---:", "error of a block, filter → batch [m]": "---", "change": "---:", "batch − filter, 95 % interval [m]": "---",
              "p, corrected p": "---", "batch is": "---", "ATE, filter → batch [m]": "---", "draws with lower batch ATE": "---:"}
    fill(PAGE, "halves", table(header, [line(r, a) for r, a in zip(rows, adjusted)]))


main()
