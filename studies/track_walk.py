#!/usr/bin/env python3
"""python3 -m studies.track_walk RECORDING RUN...: how the errors of the front end's tracks grow. RUN is
a folder that `chasles run RECORDING --keep-images 1 -o RUN` made. A bundle adjustment with free poses, points and lens
(--truth: the true poses and the stated lens, for rendered recordings) leaves the errors of the tracks. White noise and
a random walk are then fitted to them, with Student's t between tracks, after the projection of each track's own point.
It prints one row per run. It needs numpy and half a minute per run."""

import dataclasses
import math
import pathlib
import re

import numpy as np

from studies.adjustment import Tracks, View, adjust, depths, parallaxes, residuals, triangulate, whitened
from studies.arrays import Array, rotations, tum
from studies.pages import padded_table
from studies.program import Failed, parser, read_json

FEWEST = 8  # observations of a track in the adjustment
FEWEST_IN_FIT = 12  # and in the fit of the noise
LONGEST = 60  # observations of a track in the fit
LEAST_PARALLAX = 0.03  # [rad]
WORST = 1.5  # rms residual of a track that is left out [px]
WALK, WHITE, FREEDOM = 0.2, 0.02, 2.0  # noise assumed in the adjustment [px/sqrt(s), px, 1]
ROUNDS = 4  # of adjustments


@dataclasses.dataclass
class Walk:
    """White noise [px], random walk [px/sqrt(s)] and degrees of freedom of Student's t."""
    white: float
    walk: float
    freedom: float


@dataclasses.dataclass
class Errors:
    """Errors of one track without those that a shift of its point explains: eigenvalues of a unit walk's covariance
    in these coordinates, and the errors along the eigenvectors."""
    spread: Array
    error: Array


def lens_of(recording: pathlib.Path, run: pathlib.Path) -> Array:
    """Intrinsics that the run states, and the distortion in the recording's calibration."""
    files = [recording / "mav0/cam0/sensor.yaml", recording / "calibration.yaml"]
    file = next((f for f in files if f.exists()), None)
    if file is None:
        raise Failed(f"studies: found neither {files[0]} nor {files[1]}, expected the calibration of the recording")
    text = file.read_text()
    model = re.search(r"distortion_model:\s*(\S+)", text)
    if model and model[1] not in ("none", "radial-tangential"):
        raise Failed(f"studies: {file}: found distortion_model {model[1]}, expected none or radial-tangential")
    found = re.search(r"distortion_coefficients:\s*\[(.*?)\]", text, re.S)
    distortion = [float(x) for x in found[1].split(",")] if found else [0.0] * 4
    return np.array([*read_json(run / "summary.json")["cameras"][0]["intrinsics"], *distortion[:4]])


def tracks_of(run: pathlib.Path) -> tuple[Array, Tracks]:
    """Times of the frames [ns], and the tracks of camera 0."""
    file = run / "features.csv"
    if not file.exists():
        raise Failed(f"studies: {file} is missing, expected a run with --keep-images 1")
    rows = np.loadtxt(file, delimiter=",", skiprows=1, usecols=(1, 2, 3, 4))
    times = np.loadtxt(file, delimiter=",", skiprows=1, usecols=0, dtype=np.int64)
    first = rows[:, 0] == 0
    rows, times = rows[first], times[first]
    order = np.lexsort((times, rows[:, 1]))
    frames, frame = np.unique(times[order], return_inverse=True)
    track = np.unique(rows[order, 1], return_inverse=True)[1]
    return frames, Tracks(track, frame, rows[order, 2:])


def poses_at(times: Array, file: pathlib.Path) -> tuple[Array, Array, Array]:
    """Which times [s] the trajectory covers, and rotations and positions of the IMU then, interpolated."""
    rows = tum(file)
    q = rows[:, 4:8].copy()
    flips = np.cumprod(np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1, 1))
    q[1:] *= flips[:, None]
    covered = (times >= rows[0, 0]) & (times <= rows[-1, 0])
    at = [np.interp(times, rows[:, 0], column) for column in [*rows[:, 1:4].T, *q.T]]
    turned = np.array(at[3:]).T
    return covered, rotations(turned / np.linalg.norm(turned, axis=1, keepdims=True)), np.array(at[:3]).T


def start(recording: pathlib.Path, run: pathlib.Path, truth: bool) -> tuple[Array, Tracks, View]:
    """Times of the frames from the first on [s], the tracks with enough observations and parallax, and a first view."""
    times, tracks = tracks_of(run)
    seconds = times * 1e-9  # 1e-7 s is lost, as in the file of the trajectory
    covered, R, p = poses_at(seconds, run / ("truth.tum" if truth else "trajectory_smoothed.tum"))
    imu_T_cam = np.array(read_json(run / "summary.json")["cameras"][0]["imu_T_cam"])
    inside = covered[tracks.frame]
    tracks = Tracks(np.unique(tracks.track[inside], return_inverse=True)[1], tracks.frame[inside],
                    tracks.pixel[inside])
    tracks = tracks.of(np.bincount(tracks.track) >= FEWEST)
    view = View(R @ imu_T_cam[:3, :3], p + R @ imu_T_cam[:3, 3], np.zeros((0, 3)), lens_of(recording, run))
    view.points = triangulate(tracks, view)
    depth, at = depths(tracks, view), tracks.starts()[:-1]
    good = ((parallaxes(tracks, view) > LEAST_PARALLAX) & (np.minimum.reduceat(depth, at) > 0.2)
            & (np.maximum.reduceat(depth, at) < 200))
    view.points = view.points[good]
    return (times - times[0]) * 1e-9, tracks.of(good), view


def track_rms(tracks: Tracks, view: View) -> Array:
    r = residuals(tracks, view)[0]
    return np.sqrt(np.add.reduceat(np.sum(r**2, axis=1), tracks.starts()[:-1]) / 2 / np.bincount(tracks.track))


def factors_of(seconds: Array, tracks: Tracks, view: View) -> list[Array]:
    """Cholesky's factors of each track's covariance: a walk and some white noise, as large as its last residuals say,
    by the weights of Student's t. A few poor tracks would otherwise move the poses, and so all other tracks."""
    r, _, _, by_point = residuals(tracks, view)
    starts, factors = tracks.starts(), []
    for begin, end in zip(starts, starts[1:]):
        t = seconds[tracks.frame[begin:end]]
        factor = np.linalg.cholesky(WALK**2 * np.minimum.outer(t - t[0], t - t[0]) + WHITE**2 * np.eye(end - begin))
        Q, _ = np.linalg.qr(whitened(factor, by_point[begin:end]))
        e = whitened(factor, r[begin:end])[:, 0]
        squares = np.sum(e**2) - np.sum((Q.T @ e) ** 2)
        factors.append(factor * math.sqrt((FREEDOM + squares) / (FREEDOM + len(e) - 3)))
    return factors


def adjusted(seconds: Array, tracks: Tracks, view: View, truth: bool) -> tuple[Tracks, View]:
    """Without the worst tracks, as the last adjustments left them."""
    for _ in range(ROUNDS):
        view = adjust(tracks, view, 2, factors_of(seconds, tracks, view), not truth)
        good = track_rms(tracks, view) < WORST
        tracks = tracks.of(good)
        view.points = view.points[good]
    return tracks, view


def errors_of(seconds: Array, tracks: Tracks, view: View) -> list[Errors]:
    """Of the tracks that are long enough."""
    r, _, _, by_point = residuals(tracks, view)
    starts = tracks.starts()
    out = []
    for begin, end in zip(starts, np.minimum(starts[1:], starts[:-1] + LONGEST)):
        if end - begin < FEWEST_IN_FIT:
            continue
        t = seconds[tracks.frame[begin:end]]
        walk = np.minimum.outer(t - t[0], t - t[0])
        free = np.linalg.qr(by_point[begin:end].reshape(-1, 3), mode="complete")[0][:, 3:]
        spread, axes = np.linalg.eigh(free.T @ np.kron(walk, np.eye(2)) @ free)
        out.append(Errors(np.maximum(spread, 0), axes.T @ free.T @ r[begin:end].reshape(-1)))
    return out


def misfit(errors: list[Errors], walk: Walk) -> float:
    """Minus the log likelihood, but for a constant."""
    total = 0.0
    for of in errors:
        variance = walk.white**2 + walk.walk**2 * of.spread + 1e-8
        d, nu = len(of.error), walk.freedom
        total += (math.lgamma(nu / 2) - math.lgamma((nu + d) / 2) + d / 2 * math.log(nu)
                  + np.sum(np.log(variance)) / 2 + (nu + d) / 2 * math.log1p(np.sum(of.error**2 / variance) / nu))
    return total


def fitted(errors: list[Errors]) -> Walk:
    """The most likely noise, by a search along each parameter with halved steps."""
    best, step = Walk(0.05, 0.3, 3.0), 1.0
    least = misfit(errors, best)
    while step > 0.01:
        found = False
        for name in ("white", "walk", "freedom"):
            for factor in (math.exp(step), math.exp(-step)):
                trial = dataclasses.replace(best, **{name: getattr(best, name) * factor})
                if trial.white > 1e-4 and 0.5 < trial.freedom < 100 and (value := misfit(errors, trial)) < least:
                    best, least, found = trial, value, True
        if not found:
            step /= 2
    return best


def each_walk(errors: list[Errors], white: float) -> Array:
    """The walk of each track by itself [px/sqrt(s)]: with this white noise, the one whose squared errors have their
    expected mean."""
    out = []
    for of in errors:
        low, high = 1e-3, 30.0
        for _ in range(25):
            middle = math.sqrt(low * high)
            more = np.mean(of.error**2 / (white**2 + middle**2 * of.spread + 1e-8)) > 1
            low, high = (middle, high) if more else (low, middle)
        out.append(low)
    return np.array(out)


def measured(recording: pathlib.Path, run: pathlib.Path, truth: bool) -> dict[str, float]:
    seconds, every, view = start(recording, run, truth)
    tracks, view = adjusted(seconds, every, view, truth)
    errors = errors_of(seconds, tracks, view)
    walk = fitted(errors)
    alone = each_walk(errors, walk.white)
    return {"tracks": len(view.points), "length": len(tracks.track) / len(view.points),
            "left out": 1 - len(view.points) / (every.track[-1] + 1), "rms": float(np.sqrt(np.mean(
                residuals(tracks, view)[0]**2))), **dataclasses.asdict(walk), "median": float(np.median(alone)),
            "worst tenth": float(np.quantile(alone, 0.9))}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("recording", type=pathlib.Path)
    arguments.add_argument("runs", nargs="+", type=pathlib.Path)
    arguments.add_argument("--truth", action="store_true", help="true poses and the stated lens")
    given = arguments.parse_args()
    rows = [measured(given.recording, run, given.truth) for run in given.runs]
    print(padded_table(["run", *rows[0]], [[run.name, *(f"{v:.3f}" for v in row.values())]
                                           for run, row in zip(given.runs, rows)]))


if __name__ == "__main__":
    main()
