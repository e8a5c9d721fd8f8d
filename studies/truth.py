#!/usr/bin/env python3
"""python3 -m studies.truth: estimates the error of the truth of the KITTI recordings. One estimate integrates only
the velocities, with the attitude of the truth. The other uses only the stereo tracks: a batch with
very large velocity noise. Their errors are independent of each other. Their differences from the truth
have the error of the truth in common, so the mean product of the differences is its mean square. The
script evaluates horizontal motions over the blocks of studies/paired.py and fills the table of
studies/batch.md between its markers. It needs numpy and some minutes. out/runs keeps the runs: remove it
to start again."""

import math

import numpy as np

from studies.pages import fill
from studies.pairs import PAGE, metres, table
from studies.trajectories import OUT, Trajectory, chasles, cuts, drives, errors, matched, mean_and_error, run_folder, runs_of

PIXELS_ALONE = ["velocity_sigma=20", "rate_sigma=2", "velocity_walk=3", "rate_walk=1"]
FEWEST_TRACKS = 20  # per frame: three or four tracks alone do not determine the motion
LOST = 10  # ratio of the errors of tracks and velocities above which the tracks are not used (a motorway)


def pixels_alone(name, arguments):
    folder = run_folder(OUT, name, "pixels")
    if not (folder / "trajectory.tum").exists():
        chasles("run", *arguments, "--estimator", "batch", *[a for s in PIXELS_ALONE for a in ("--set", s)], "-o", folder)
    return np.loadtxt(folder / "trajectory.tum")


def velocities_alone(reckoned, truth):
    """The steps of the dead reckoning, each from the truth's attitude on."""
    steps = reckoned.steps(np.arange(len(reckoned.t) - 1), np.arange(1, len(reckoned.t)))[1]
    p = np.cumsum(np.vstack([np.zeros(3), (truth.R[:-1] @ steps[:, :, None])[:, :, 0]]), axis=0)
    alone = Trajectory(np.column_stack([truth.t, p, np.zeros_like(p), np.ones(len(p))]))
    alone.R = truth.R
    return alone


def line(name, arguments):
    runs_of(name, arguments)
    folder = run_folder(OUT, name, "filter")
    tables = [np.loadtxt(folder / f"{of}.tum") for of in ("trajectory", "dead_reckoning", "truth")]
    batch = np.loadtxt(run_folder(OUT, name, "batch") / "trajectory.tum")
    pixels = pixels_alone(name, arguments)
    runs = matched([tables[0], batch, pixels, *tables[1:]])
    truth = runs.pop()
    runs[-1] = velocities_alone(runs[-1], truth)
    at = cuts(truth)
    of = [errors(run, truth, at[:-1], at[1:])[1][:, :2] for run in runs]
    root = lambda e: math.sqrt(np.mean(np.sum(e**2, axis=1)))
    if root(of[2]) > LOST * root(of[3]):
        return None
    mean, error = mean_and_error(np.sum(of[2] * of[3], axis=1))
    of_square = lambda square: metres(math.sqrt(square)) if square > 0 else "0"
    own = f"{of_square(mean)} ({of_square(mean - 2 * error)} to {of_square(mean + 2 * error)})"
    return [name, metres(root(of[3])), metres(root(of[2])), own, metres(root(of[0])), metres(root(of[1]))]


def tracks_a_frame(name):
    rows = np.genfromtxt(run_folder(OUT, name, "filter") / "states.csv", delimiter=",", names=True)
    return rows["observations"].mean()


def main():
    lines = []
    for name, arguments in drives():
        runs_of(name, arguments)
        # Not applicable to velocities with added noise (2020), and to 20 landmarks in a room.
        if name.startswith("ece276a_2020") or name.endswith("dataset3") or tracks_a_frame(name) < FEWEST_TRACKS:
            continue
        found = line(name, arguments)
        if found:
            lines.append(found)
    header = {"drive": "---", "velocities alone [m]": "---:", "tracks alone [m]": "---:", "error of the truth (± 2 standard errors) [m]": "---", "filter [m]": "---:", "batch [m]": "---:"}
    fill(PAGE, "truth", table(header, lines))


main()
