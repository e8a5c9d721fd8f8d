#!/usr/bin/env python3
"""python3 -m studies.without_truth [PAIRS [SEEDS]]: what `chasles evaluate --pair` finds. Runs on halves of the tracks
that have no track in common, of simulated scenes (PAIRS noise realisations, 100) and of real recordings
(SEEDS choices of the halves, 4), against the truth that the command does not use. It fills
studies/evaluation.md between its markers. Fifteen minutes of two cores."""

import concurrent.futures
import json
import math
import pathlib
import statistics
import tempfile

from studies.pages import fill, table
from studies.program import DATA, EUROC, LOST, ROOT, Arguments, chasles, count, parser, sets

PAGE = ROOT / "studies/evaluation.md"
MARKERS = {PAGE: ("pairs-simulated", "pairs-real")}
# Whether it reads as consistent: NEES of the pose over its 6 degrees of freedom.
CONSISTENT = 2.0
SCENES: list[tuple[str, str, Arguments]] = [
    ("hallway", "filter", []),
    ("hallway", "`window:20`", ["--estimator", "window:20"]),
    ("hallway", "filter, half of the pixel noise stated", sets("track_sigma=0.5")),
    ("turntable", "filter", []),
]
REAL: list[tuple[str, pathlib.Path, Arguments]] = [
    ("MH_01, one camera", EUROC / "MH_01_easy_17s", ["--cameras", "mono"]),
    ("MH_01, two cameras", EUROC / "MH_01_easy_17s", []),
    ("MH_03, one camera", EUROC / "MH_03_medium_27s_mono", []),
    ("KITTI 00, two cameras", DATA / "kitti_images/00_first_13s", []),
]


class Pair:
    """Two runs: the factor that they show together, and the NEES of each by the truth, over its 6 degrees."""

    def __init__(self, recording: pathlib.Path, arguments: Arguments, seed: int, folder: pathlib.Path) -> None:
        self.nees: list[float] = []
        halves = [folder / "half", folder / "rest"]
        which: tuple[Arguments, Arguments] = ([], ["--tracks-rest"])
        for out, half in zip(halves, which):
            run = chasles("run", recording, "--tracks", 0.5, "--tracks-seed", seed, *half, *arguments, "--threads", 1,
                          "--quiet", "--json", "-o", out, accepted=(0, LOST), silent=True)
            self.nees.append(json.loads(run.stdout)["nees_pose"] / 6)
        found = json.loads(chasles("evaluate", *halves, "--pair", "--json", silent=True).stdout)
        self.factor: float = found["factor"]
        self.overconfident: bool = found["overconfident"]

    def is_consistent(self) -> bool:
        return max(self.nees) <= CONSISTENT

    def true_factor(self) -> float:
        return math.sqrt(statistics.mean(self.nees))


def simulated(scene: str, arguments: Arguments, run: int) -> Pair:
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        chasles("simulate", scene, "--run", run, "--seed", run + 1, "--quiet", "-o", folder / "recording")
        return Pair(folder / "recording", arguments, 1, folder)


def real(recording: pathlib.Path, arguments: Arguments, seed: int) -> Pair:
    with tempfile.TemporaryDirectory() as name:
        return Pair(recording, arguments, seed, pathlib.Path(name))


def of_scene(scene: str, estimator: str, pairs: list[Pair]) -> list[str]:
    good, bad = [p for p in pairs if p.is_consistent()], [p for p in pairs if not p.is_consistent()]

    def found(some: list[Pair]) -> str:
        return f"{sum(p.overconfident for p in some)} of {len(some)}" if some else "-"

    return [scene, estimator, found(good), f"{max(p.factor for p in good):.2f}" if good else "-", found(bad),
            f"{statistics.median(p.factor for p in bad):.1f}" if bad else "-",
            f"{statistics.median(p.true_factor() for p in bad):.1f}" if bad else "-"]


def several(values: list[float]) -> str:
    return ", ".join(f"{v:.2f}" for v in values)


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("pairs", nargs="?", type=count, default=100, metavar="PAIRS")
    arguments.add_argument("seeds", nargs="?", type=count, default=4, metavar="SEEDS")
    chosen = arguments.parse_args()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        rows = [of_scene(scene, estimator, list(pool.map(lambda k: simulated(scene, more, k), range(chosen.pairs))))
                for scene, estimator, more in SCENES]
        seen: list[tuple[str, list[Pair]]] = [
            (name, list(pool.map(lambda k: real(recording, more, k), range(1, chosen.seeds + 1))))
            for name, recording, more in REAL
        ]
    fill(PAGE, "pairs-simulated", table(
        ["scene", "estimator", "named, of consistent pairs", "their largest factor", "named, of the others",
         "their factor, median", "by the truth, median"], rows))
    fill(PAGE, "pairs-real", table(
        ["recording", "factor", "by the truth", "named"],
        [[name, several([p.factor for p in pairs]), several([p.true_factor() for p in pairs]),
          f"{sum(p.overconfident for p in pairs)} of {len(pairs)}"] for name, pairs in seen]))


if __name__ == "__main__":
    main()
