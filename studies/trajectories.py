"""Runs of `chasles` against their truth, for studies/drift.py and studies/paired.py: motions over time
spans, and the effect of a run's block errors on its ATE. Needs numpy. out/runs keeps the runs: remove
it to start again."""

import math
import os
import pathlib
import re
import subprocess

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data"))
OUT = ROOT / "out/runs"
ESTIMATORS = ["filter", "batch"]
BLOCK, BLOCKS = 5, 10  # of a recording: longest block [s], least number of blocks
EUROC = DATA / "euroc"
# Name, arguments of `run`, recording that it shares with others, and whether its errors accumulate
# along the path (not with a board that is always in view).
FLIGHTS = [
    *[(f"AprilGrid, {cameras}", [EUROC / "imu_april", "--config", "studies/configs/euroc.yaml", "--begin", "truth", "--cameras", cameras], "AprilGrid", False)
      for cameras in ("stereo", "mono")],
    *[(f"MH_01, 17 s, {cameras}{way}", [EUROC / "MH_01_easy_17s", "--cameras", cameras, *(["--backwards"] if way else [])], "MH_01", True)
      for cameras in ("stereo", "mono") for way in ("", " backwards")],
    ("MH_01, 184 s, KLT tracks", [EUROC / "imu_gt/MH_01_easy_klt_tracks_cam0.csv.gz"], "MH_01", True),
]
# The ECE276A archives contain no truth.
TRUTH = {
    "ece276a_2018/0020": "0020_gt_imu_stars.tum",
    "ece276a_2018/0027": "0027_gt_imu_stars.tum",
    "ece276a_2018/0042": "0042_gt_imu_stars.tum",
    "ece276a_2020/0022": "0022_pseudogt_orbslam3_imu.tum",
    "ece276a_2020/0027": "0027_gt_imu_stars.tum",
}


# Recordings of the same drive: 15 recordings show 12 drives. Tests of significance count a drive once.
DRIVE = {
    "ece276a_2018/0027": "2011_09_30_drive_0027", "ece276a_2020/0027": "2011_09_30_drive_0027", "stars/2011_09_30_drive_0027": "2011_09_30_drive_0027",
    "ece276a_2018/0042": "2011_10_03_drive_0042", "stars/2011_10_03_drive_0042": "2011_10_03_drive_0042",
}


def chasles(*arguments):
    subprocess.run([str(a) for a in (CHASLES, *arguments, "--quiet")], check=True, stdout=subprocess.DEVNULL, cwd=ROOT)


def drives():
    """The KITTI tracks: name and arguments of `run`."""
    folder = DATA / "kitti_tracks"
    for recording in sorted(folder.glob("ece276a_*/*.npz")) + sorted(folder.glob("stars/*.mat")):
        name = f"{recording.parent.name}/{recording.stem.replace('_sync_KLT', '')}"
        yield name, [recording, *(["--truth", folder / "ground_truth" / TRUTH[name]] if name in TRUTH else [])]


def rotations(q):
    x, y, z, w = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    R = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return np.moveaxis(np.array(R), 2, 0)


class Trajectory:
    def __init__(self, rows):
        self.t, self.p, self.R = rows[:, 0], rows[:, 1:4], rotations(rows[:, 4:8])

    def steps(self, begin, end):
        """The motions from rows `begin` to rows `end`, in the axes of the first."""
        at = np.swapaxes(self.R[begin], 1, 2)
        return at @ self.R[end], (at @ (self.p[end] - self.p[begin])[:, :, None])[:, :, 0]


def nearest(times, wanted):
    after = np.clip(np.searchsorted(times, wanted), 1, len(times) - 1)
    return after - (wanted - times[after - 1] < times[after] - wanted)


def matched(tables):
    """The rows of all tables at the times of the first table that each of them has: the nearest
    row, at most half a spacing away."""
    wanted, rows = tables[0][:, 0], []
    keep = np.ones(len(wanted), bool)
    for table in tables:
        at = nearest(table[:, 0], wanted)
        spacing = min(np.median(np.diff(table[:, 0])), np.median(np.diff(wanted)))
        keep &= np.abs(table[at, 0] - wanted) <= spacing / 2
        rows.append(at)
    return [Trajectory(table[at[keep]]) for table, at in zip(tables, rows)]


def runs_of(name, arguments):
    """The truth, and the recording's run with each estimator, at the same times."""
    return compared(OUT, name, arguments)


def run_folder(where, name, estimator):
    return where / re.sub(r"\W+", "-", f"{name}-{estimator}")


def compared(where, name, arguments):
    """The same, with the run folders in `where`; runs that exist are not repeated."""
    folders = {e: run_folder(where, name, e) for e in ESTIMATORS}
    for estimator, folder in folders.items():
        if not (folder / "trajectory.tum").exists():
            where.mkdir(parents=True, exist_ok=True)
            chasles("run", *arguments, "--estimator", estimator, "-o", folder)
    tables = [np.loadtxt(folders[e] / "trajectory.tum") for e in ESTIMATORS]
    filter_run, batch, truth = matched([*tables, np.loadtxt(folders["filter"] / "truth.tum")])
    return truth, {"filter": filter_run, "batch": batch}


def cuts(truth):
    """The rows that divide a recording into blocks."""
    duration = truth.t[-1] - truth.t[0]
    count = max(BLOCKS, math.floor(duration / BLOCK))
    return np.searchsorted(truth.t, truth.t[0] + np.arange(count + 1) * min(BLOCK, duration / BLOCKS) - 1e-6).clip(max=len(truth.t) - 1)


def angle(R):
    return np.arccos(np.clip((np.trace(R, axis1=1, axis2=2) - 1) / 2, -1, 1))


def errors(estimate, truth, begin, end):
    """Differences in rotation and translation between the estimated and the true motions."""
    (R, p), (R_true, p_true) = estimate.steps(begin, end), truth.steps(begin, end)
    return np.swapaxes(R_true, 1, 2) @ R, p - p_true


def ate(p, p_true):
    """The ATE of many trajectories (..., points, 3) at once, after SE(3) alignment."""
    a, b = p - p.mean(-2, keepdims=True), p_true - p_true.mean(-2, keepdims=True)
    U, _, Vt = np.linalg.svd(np.swapaxes(b - np.zeros_like(a), -1, -2) @ a)
    U[..., 2] *= np.linalg.det(U @ Vt)[..., None]
    return np.sqrt(np.mean(np.sum((a @ np.swapaxes(U @ Vt, -1, -2) - b) ** 2, axis=-1), axis=-1))


def walks(truth, at, R_error, p_error, signs):
    """Positions of the true blocks, each with its error, or with the inverse error if the draw's
    sign is negative: draws, blocks + 1, 3."""
    R_true, p_true = truth.steps(at[:-1], at[1:])
    draws = len(signs)
    R, p = np.broadcast_to(np.eye(3), (draws, 3, 3)), np.zeros((draws, 3))
    positions = [p]
    for i, sign in enumerate(signs.T):
        p = p + (R @ (p_true[i] + sign[:, None] * p_error[i])[:, :, None])[:, :, 0]
        R = R @ np.where(sign[:, None, None] > 0, R_true[i] @ R_error[i], R_true[i] @ R_error[i].T)
        positions.append(p)
    return np.stack(positions, axis=1)


def by_drive(names, values):
    """The values of recordings, averaged over those of the same drive."""
    groups = {}
    for name, value in zip(names, values):
        groups.setdefault(DRIVE.get(name, name), []).append(value)
    return np.array([np.mean(group) for group in groups.values()])


def mean_and_error(values):
    return np.mean(values), np.std(values, ddof=1) / math.sqrt(len(values))
