"""Visual-inertial SLAM with an extended Kalman filter that states its uncertainty.

    import chasles

    recording = chasles.simulate("hallway")          # or chasles.read("MH_01")
    run = chasles.run(recording, chart="right-sen3")
    print(run.summary["ate_m"], run.states["position"].shape)
    run.show("run.html")

Times are int64 nanoseconds; where a time is an argument, an int is in nanoseconds and a float in
seconds. Lengths are in metres, angles in radians. `a_T_b` maps coordinates of frame b to frame a.
Quaternions are x y z w. Covariances of poses are of [theta; dp] in world axes: R = Exp(theta) R_hat,
p = p_hat + dp. All arrays are numpy's, and copies.
"""

from __future__ import annotations

import functools
import json
import os
import signal
import sys
from typing import Any, Mapping, NoReturn

from ._core import (
    Camera,
    DivergedError,
    Error,
    Estimate,
    ImuNoise,
    InputError,
    NotInitialisedError,
    PredictedState,
    RealtimeSlam,
    Recording,
    Slam,
    UsageError,
    __version__,
)
from . import _core
from ._page import Page

__all__ = [
    "Camera", "ChartState", "Comparison", "DivergedError", "Error", "Estimate", "FirstSight", "ImuNoise", "InputError",
    "NotInitialisedError", "PredictedState", "RealtimeSlam", "Recording", "Run", "Slam", "Study", "UsageError",
    "command", "compare", "evaluate", "join_imu",
    "monte_carlo", "read", "read_run", "register_chart", "register_depth_rule", "run", "settings", "simulate",
]


class Run(Page):
    """The results of a run: arrays, figures, and the page."""

    def __init__(self, core: _core.Run) -> None:
        self._core = core

    @property
    def name(self) -> str:
        """The recording's name."""
        return self._core.name

    @functools.cached_property
    def summary(self) -> dict[str, Any]:
        """The figures of summary.json (docs/command-line.md) as a dictionary."""
        summary: dict[str, Any] = json.loads(self._core._summary)
        return summary

    @functools.cached_property
    def states(self) -> dict[str, Any]:
        """The estimates of all frames, a dictionary of columns: `time` (N,) int64 [ns], `position` (N, 3), `quaternion`
        (N, 4), `pose_covariance` (N, 6, 6), the other states and their sigmas by name (`velocity_x`,
        `velocity_x_sigma`, ...), `nis`, `nis_dof`, counts, and `health`."""
        return self._core.states

    @functools.cached_property
    def smoothed(self) -> dict[str, Any]:
        """The path given all measurements: `time`, `position`, `quaternion`, `pose_covariance`; empty where unknown."""
        return self._core.smoothed

    @functools.cached_property
    def in_map(self) -> dict[str, Any]:
        """The poses in the frame of the map that was given, from the frame on in which the run found its place."""
        return self._core.in_map

    @functools.cached_property
    def landmarks(self) -> dict[str, Any]:
        """`id` (N,), `position` (N, 3), `covariance` (N, 3, 3), `observations` (N,)."""
        return self._core.landmarks

    @functools.cached_property
    def truth(self) -> dict[str, Any]:
        """`time`, `position`, `quaternion` in the truth's own world; empty where unknown."""
        return self._core.truth

    def to_dataframe(self) -> Any:
        """The states as a pandas DataFrame, a row for each frame, without covariances."""
        import pandas

        columns = {}
        for name, values in self.states.items():
            if name == "pose_covariance":
                continue
            if getattr(values, "ndim", 1) == 2:
                for k, axis in enumerate("xyzw"[: values.shape[1]]):
                    columns[f"{name}_{axis}"] = values[:, k]
            else:
                columns[name] = values
        return pandas.DataFrame(columns)

    def evaluate(self, truth: Mapping[str, Any] | None = None) -> dict[str, float | None]:
        """The errors against a truth (that of the recording, if none is given), as `chasles.evaluate` has them."""
        chart = self.summary.get("chart", "standard")
        return evaluate(self.states, self.truth if truth is None else truth, chart=chart, level=self._core._level)

    def save(self, folder: _core.Path) -> None:
        """Writes the run folder that `chasles run -o` writes, without timings."""
        self._core.save(os.fspath(folder))

    def page(self) -> str:
        """The HTML page of the run, self-contained, as text."""
        return self._core.page()

    def __repr__(self) -> str:
        ate = self.summary.get("ate_m")
        error = "" if ate is None else f", ATE {ate:.3f} m"
        return f"<chasles.Run '{self.name}': {len(self.states['time'])} estimates{error}>"


def read(path: _core.Path, *, start: float | None = None, stop: float | None = None, backwards: bool = False,
         cameras: str = "", truth: _core.Path | None = None) -> Recording:
    """Reads a recording of any kind that `chasles run` reads (docs/formats.md), cut to [start, stop] seconds since its
    first event. cameras: "mono", "stereo" or "" (all). truth: a TUM file that replaces the recording's truth. Raises
    InputError with file, place, what was found and what was expected."""
    return _core.read(os.fspath(path), start=start, stop=stop, backwards=backwards, cameras=cameras,
                      truth="" if truth is None else os.fspath(truth))


def join_imu(gyro_time: Any, angular_rate: Any, accel_time: Any, specific_force: Any) -> dict[str, Any]:
    """The samples of an IMU whose accelerometer and gyroscope are read apart, each with (N,) times and (N, 3) values:
    at the times of the gyroscope, with the accelerometer interpolated. A dictionary with `time`, `angular_rate` and
    `specific_force` for `add_imu`, and `remarks`, sentences on what was joined and left out. InputError for streams
    that cannot be joined."""
    return _core.join_imu(gyro_time, angular_rate, accel_time, specific_force)


def simulate(scene: str = "hallway", *, run: int = 0, images: bool = False, **settings: Any) -> Recording:
    """A simulated recording: tracks, or rendered images with images=True. Equal scenes with another run have other
    noise. Settings by name, as `chasles simulate --help` lists them."""
    return _core.simulate(scene, run=run, images=images, **settings)


def run(recording: Recording | _core.Path, *, estimator: str = "filter", threads: int = 3, begin: str = "auto",
        map: _core.Path | None = None, save_map: _core.Path | None = None, keep_images: int | None = None,
        mode: str | None = None, config: _core.Path | None = None, **settings: Any) -> Run:
    """Runs an estimator over a recording (Recording, or a path) as `chasles run` does, to the bit, and returns a Run.

    estimator: "filter", "window:N" or "batch". map, save_map: files of maps (docs/recognition.md). begin: "auto", or
    "truth". Settings by name, as settings() lists them; those with a prefix as a dictionary: start={"heading": 0}.
    Raises UsageError for a setting that does not exist, with the nearest one, or that cannot be used;
    NotInitialisedError where the run never started, with the conditions that are not met. Where the map cannot be
    saved, the Run is the attribute `run` of the error. Ctrl-C ends it with KeyboardInterrupt. Other threads run
    meanwhile."""
    path = ""
    if not isinstance(recording, Recording):
        path = os.fspath(recording)
        recording = read(path)
    given: dict[str, Any] = {"map": map, "save_map": save_map, "keep_images": keep_images, "mode": mode,
                             "config": config}
    given = {name: value for name, value in given.items() if value is not None}
    for name in ("map", "save_map", "config"):
        if name in given:
            given[name] = os.fspath(given[name])
    finished = Run(_core.run(recording, path, estimator=estimator, threads=threads, begin=begin, **given, **settings))
    try:
        finished._core._check_map()
    except Error as error:
        error.run = finished
        raise
    return finished


def read_run(folder: _core.Path) -> Run:
    """Reads a run folder that `chasles run -o` or Run.save wrote."""
    return Run(_core.read_run(os.fspath(folder)))


def evaluate(estimate: Mapping[str, Any], truth: Mapping[str, Any], *, chart: str = "standard",
             level: bool = False) -> dict[str, float | None]:
    """Compares an estimate with the truth and returns the figures of docs/evaluation.md: ate_m, rpe_..., and with
    `pose_covariance` in the estimate the NEES. Both are dictionaries with `time`, `position` (N, 3) and, if known,
    `quaternion` (N, 4), as Run.states and Recording.truth. Figures that do not apply are None.

    chart: the error chart in whose coordinates the NEES is. level: the z axis of the estimate's world points up, as in
    a run with an IMU, so that only heading and position are aligned for it."""
    for name, columns in (("estimate", estimate), ("truth", truth)):
        missing = [column for column in ("time", "position") if column not in columns]
        if missing:
            raise UsageError(f"{name}: expected columns time and position, {', '.join(missing)} is missing")
    no_attitude: list[list[float]] = [[]]
    return _core.evaluate(estimate["time"], estimate["position"], estimate.get("quaternion", no_attitude),
                          truth["time"], truth["position"], truth.get("quaternion", no_attitude),
                          estimate.get("pose_covariance"), chart, level)


def settings(kind: str = "imu") -> dict[str, dict[str, str]]:
    """All settings by name, of runs with an IMU ("imu") or with body velocities ("velocity"):
    {name: {"default", "unit", "meaning"}}."""
    return _core.settings(kind)


def command(*arguments: object) -> int:
    """Runs the command `chasles` in this process: command("check", "MH_01"). Returns its exit code."""
    return _core.command([str(argument) for argument in arguments])


def main() -> NoReturn:
    """The console script `chasles`: signals do what they do to the command of the build. Python would only note
    Ctrl-C until the command ends, and ignores a closed pipe."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.exit(_core.command(sys.argv[1:]))


from .lab import (  # noqa: E402  (it uses Run and run)
    ChartState,
    Comparison,
    FirstSight,
    Study,
    compare,
    monte_carlo,
    register_chart,
    register_depth_rule,
)
