#!/usr/bin/env python3
"""python3 -m studies.scale [RUNS]: the scale of one camera. Cuts of four EuRoC flights with the real samples of the IMU
and pixels that are exact to 0.02 px, in filter and batch; and RUNS (100) simulated flights whose tracks have the
noise that the filter assumes, white noise and a random walk. It fills studies/pixels.md between its markers. Ten
minutes of two cores."""

import concurrent.futures
import dataclasses
import json
import pathlib
import statistics
import tempfile

from studies.pages import fill, table
from studies.program import EUROC, LOST, ROOT, Arguments, Json, chasles, count, parser, sets
from studies.scores import matched, scale_to_truth

PAGE = ROOT / "studies/pixels.md"
MARKERS = {PAGE: ("scale-flights", "scale-walks")}
FLIGHTS = [("MH_01_easy", 45, 80), ("MH_03_medium", 20, 47), ("V1_01_easy", 20, 55), ("V2_01_easy", 30, 65)]
CAMERA: Arguments = ["--cameras", EUROC / "MH_01_easy_17s",
                     *sets("cameras=1", "frame_rate=20", "min_range=2", "landmark_nearest=2.5", "landmark_farthest=14")]
STATED = sets("accelerometer_noise_density=0.002", "accelerometer_random_walk=0.003",
              "gyroscope_noise_density=1.6968e-4", "gyroscope_random_walk=1.9393e-5")
# What `chasles run` takes with images.
IMAGES = sets("imu_noise_scale=3", "vibration_noise=1", "guessed_depth_observations=20", "pixel_sigma=0.4")
ONE_PATH: Arguments = [EUROC / "MH_03_medium_27s_mono"]
WALK = ("track_drift=0.75", 0.05)  # px/sqrt(s), and white noise [px]
FILTERS: list[tuple[str, list[str]]] = [
    ("filter, 3 px and 2 px/√s, the default with images", ["track_sigma=3", "track_drift=2", "keep_scale=true"]),
    ("the same without `keep_scale`", ["track_sigma=3", "track_drift=2", "keep_scale=false"]),
    ("filter, 0.3 px", ["track_sigma=0.3", "keep_scale=true"]),
    ("the same without `keep_scale`", ["track_sigma=0.3", "keep_scale=false"]),
]
MAPS: list[tuple[str, list[str]]] = [
    ("default with images", []),
    ("without `keep_scale`", ["keep_scale=false"]),
    ("`min_landmarks` 6", ["min_landmarks=6"]),
    ("`guessed_depth_observations` 0", ["guessed_depth_observations=0"]),
    ("`max_landmarks` 12", ["max_landmarks=12"]),
    ("null-space updates alone: at most 3 landmarks", ["max_landmarks=3", "min_landmarks=0"]),
    ("chart `standard`", ["chart=standard"]),
]


@dataclasses.dataclass
class Result:
    scale: float
    sigma: float | None
    summary: Json


def run(recording: pathlib.Path, *arguments: str | float | pathlib.Path) -> Result:
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        chasles("run", recording, *arguments, "--threads", 1, "--quiet", "-o", folder / "run", accepted=(0, LOST),
                silent=True, timeout=600)
        square, truth = folder / "run.square", folder / "truth.tum"
        chasles("export", folder / "run", "-o", square, "--truth", truth, "--quiet", silent=True)
        rows, true_rows = matched(square, truth)
        summary = json.loads((folder / "run/summary.json").read_text())
    return Result(scale_to_truth(rows[:, 1:4], true_rows[:, 1:4]), summary.get("scale_sigma"), summary)


def plus_minus(result: Result) -> str:
    return f"{result.scale:.3f}" + (f" ± {result.sigma:.3f}" if result.sigma else "")


def flights(work: pathlib.Path) -> str:
    cuts: list[tuple[pathlib.Path, Arguments]] = []
    for name, start, stop in FLIGHTS:
        chasles("simulate", "trajectory", "--path", EUROC / f"imu_gt/{name}_imu.csv.gz", "--real-imu", "--agreed-truth",
                *CAMERA, *sets("visible_landmarks=220", "landmarks_in_view=65", "pixel_sigma=0.02"), *STATED, "--quiet",
                "-o", work / name)
        cuts.append((work / name, ["--start", start, "--stop", stop, *IMAGES]))
    rows = [["batch, 0.3 px", *[plus_minus(run(cut, *more, *sets("track_sigma=0.3"), "--estimator", "batch"))
                                for cut, more in cuts]]]
    for label, settings in FILTERS:
        more = [*settings, "calibrate_time_offset=true"]
        rows.append([label, *[plus_minus(run(cut, *arguments, *sets(*more))) for cut, arguments in cuts]])
    header = {"scale to truth": "---", **{f"{name}, {start} to {stop} s": "---" for name, start, stop in FLIGHTS}}
    return table(list(header), rows, header.values())


def walk(seed: int, work: pathlib.Path) -> pathlib.Path:
    drift, white = WALK
    folder = work / str(seed)
    chasles("simulate", "trajectory", "--path", *ONE_PATH, *CAMERA,
            *sets("visible_landmarks=140", "landmarks_in_view=75", drift, f"pixel_sigma={white}", "imu_rate=200",
                  "accelerometer_noise_density=0.006", "accelerometer_random_walk=0.003",
                  "gyroscope_noise_density=5.1e-4", "gyroscope_random_walk=5.8e-5"),
            "--seed", seed, "--run", seed, "--quiet", "-o", folder)
    return folder


def walks(runs: int, work: pathlib.Path) -> str:
    drift, white = WALK
    assumed = [drift, f"track_sigma={white}", "pixel_sigma=0.4", "keep_scale=true", "guessed_depth_observations=20"]
    rows = []
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        recordings = list(pool.map(lambda seed: walk(seed, work), range(1, runs + 1)))
        for label, settings in MAPS:
            arguments = sets(*assumed, *settings)
            found = list(pool.map(lambda recording: run(recording, *arguments), recordings))
            nees = [[r.summary[f"nees_{what}"] / dof for r in found] for what, dof in (("pose", 6), ("position", 3),
                                                                                       ("attitude", 3))]
            scales = [r.scale for r in found]
            sigma = [r.sigma for r in found if r.sigma]
            rows.append([label, f"{statistics.mean(nees[0]):.2f}, {statistics.median(nees[0]):.2f}",
                         *[f"{statistics.mean(values):.2f}" for values in nees[1:]],
                         f"{statistics.mean(scales):.4f} ± {statistics.stdev(scales):.4f}",
                         f"{statistics.mean(sigma):.4f}" if sigma else "-",
                         f"{statistics.mean(r.summary['ate_m'] for r in found):.4f}"])
    header = {"filter": "---", "NEES/dof, pose (mean, median)": "---:", "position": "---:", "attitude": "---:",
              "scale to truth (mean ± std)": "---:", "its sigma": "---:", "ATE m": "---:"}
    return table(list(header), rows, header.values())


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("runs", nargs="?", type=count, default=100, metavar="RUNS")
    chosen = arguments.parse_args()
    with tempfile.TemporaryDirectory() as name:
        fill(PAGE, "scale-flights", flights(pathlib.Path(name)))
        if chosen.runs:
            fill(PAGE, "scale-walks", walks(chosen.runs, pathlib.Path(name)))


if __name__ == "__main__":
    main()
