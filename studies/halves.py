#!/usr/bin/env python3
"""python3 -m studies.halves [DRAWS [FLIGHTS]]: batch against filter on each recording, averaged over the choice
of tracked points. Both get the same random half of the tracks, DRAWS times (16; flights 6), each time
with other tracks. A pair is a block of the recording; its errors are those of the motion over it,
averaged over the draws. All draws share truth, velocities and scene, so a draw is not a pair. The
script fills the table of studies/batch.md between its markers. It needs numpy and twenty minutes of two
cores. out/halves.jsonl keeps the results: remove it to start again."""

import json
import pathlib
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from studies.arrays import Array
from studies.kitti import drives
from studies.pages import fill
from studies.pairs import PAGE, holm, interval, metres, sign_flips, signed, small, table, verdict
from studies.program import ROOT, Arguments, Failed, Json, count, parser, read_json_lines
from studies.trajectories import ESTIMATORS, FLIGHTS, OUT, ate, compared, cuts, errors

MARKERS = {PAGE: ("halves",)}
KEPT = ROOT / "out/halves.jsonl"


def half(name: str, arguments: Arguments, seed: int) -> Json | None:
    """Errors of both on a half of the tracks: over each block, and ATE. None if one of them fails."""
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=OUT) as folder:
        try:
            truth, runs = compared(pathlib.Path(folder), name, [*arguments, "--tracks", 0.5, "--tracks-seed", seed])
        except Failed:
            return None
        at = cuts(truth)
        blocks: list[Array] = [np.linalg.norm(errors(runs[e], truth, at[:-1], at[1:])[1], axis=1) for e in ESTIMATORS]
        return {"blocks": [of.tolist() for of in blocks], "ate": [ate(runs[e].p, truth.p) for e in ESTIMATORS]}


def all_halves(recordings: list[tuple[str, Arguments, int]]) -> dict[str, list[Json | None]]:
    """The results of the draws by recording; finished draws are read from the file."""
    found: dict[tuple[str, int], Json | None] = {}
    if KEPT.exists():
        for kept in read_json_lines(KEPT):
            found[kept["recording"], kept["seed"]] = kept["errors"]
    missing = [(name, arguments, seed) for name, arguments, draws in recordings for seed in range(1, draws + 1)
               if (name, seed) not in found]
    KEPT.parent.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(2) as pool, KEPT.open("a") as file:
        for (name, _, seed), of in zip(missing, pool.map(lambda m: half(*m), missing)):
            found[name, seed] = of
            file.write(json.dumps({"recording": name, "seed": seed, "errors": of}) + "\n")
            file.flush()
    return {name: [found[name, seed] for seed in range(1, draws + 1)] for name, _, draws in recordings}


class Row:
    """Errors over the blocks, (filter, batch), mean over the draws; ATEs of the draws."""

    def __init__(self, name: str, draws: list[Json | None]) -> None:
        self.name, self.failed = name, sum(d is None for d in draws)
        good = [d for d in draws if d is not None]
        self.pairs: Array = np.mean([d["blocks"] for d in good], axis=0).T
        self.ates = np.array([d["ate"] for d in good])
        self.differences = self.pairs[:, 1] - self.pairs[:, 0]
        self.p = sign_flips(self.differences)


def line(row: Row, adjusted: float) -> list[str]:
    f, b = row.pairs.mean(axis=0)
    low, high = interval(row.differences)
    ates, less = row.ates.mean(axis=0), np.mean(row.ates[:, 1] < row.ates[:, 0])
    draws = f"{len(row.ates)}" + (f", {row.failed} failed" if row.failed else "")
    return [
        row.name, draws, f"{len(row.pairs)}", f"{metres(f)} → {metres(b)}",
        f"{100 * (b / f - 1):+.0f} %".replace("-", "−"), f"{signed(low)} to {signed(high)}",
        f"{small(row.p)}, {small(adjusted)}", verdict(row.differences.mean(), row.p, adjusted),
        f"{metres(ates[0])} → {metres(ates[1])}", f"{100 * less:.0f} %"
    ]


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("draws", nargs="?", type=count, default=16, metavar="DRAWS")
    arguments.add_argument("flights", nargs="?", type=count, default=6, metavar="FLIGHTS", help="draws of a flight")
    chosen = arguments.parse_args()
    recordings = [(name, run, chosen.draws) for name, run in drives()]
    recordings += [(name, run, chosen.flights) for name, run, _, _ in FLIGHTS]
    rows = [Row(name, draws) for name, draws in all_halves(recordings).items()]
    adjusted = holm(np.array([r.p for r in rows]))
    header = {"recording": "---", "draws": "---:", "blocks": "---:", "error of a block, filter → batch [m]": "---",
              "change": "---:", "batch − filter, 95 % interval [m]": "---", "p, corrected p": "---", "batch is": "---",
              "ATE, filter → batch [m]": "---", "draws with lower batch ATE": "---:"}
    fill(PAGE, "halves", table(header, [line(r, a) for r, a in zip(rows, adjusted)]))


if __name__ == "__main__":
    main()
