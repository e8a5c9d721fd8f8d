"""The functions of the package that have no settings as arguments."""

from __future__ import annotations

import os
import signal
import sys
from typing import Any, Mapping, NoReturn, Optional

from . import _core
from ._arguments import suggests_arguments
from ._run import Run


@suggests_arguments
def read(path: _core.Path, *, start: Optional[float] = None, stop: Optional[float] = None, backwards: bool = False,
         cameras: str = "", truth: Optional[_core.Path] = None, truth_level: str = "auto", pairing: str = "",
         max_truth_gap: Optional[float] = None, truth_time_offset: Optional[float] = None, truth_frame: str = "",
         truth_scale: Optional[float] = None, truth_inverse: bool = False) -> _core.Recording:
    """Reads a recording of any kind that `chasles run` reads (docs/formats.md), cut to [start, stop] seconds since its
    first event. cameras: "mono", "stereo" or "" (all). truth: a TUM file, or a recording with a truth, that replaces the
    recording's truth; truth_level: "yes" or "no" where its z axis points up or does not; pairing: "interpolate" or
    "nearest"; max_truth_gap [s] between its stamps; truth_time_offset [s], added to its times; truth_frame: "imu",
    "cam0" or a file, whose poses it has; truth_scale: metres in its unit; truth_inverse: its poses are imu_T_world
    (docs/evaluation.md). Raises InputError with file, place, what was found and what was
    expected. Ctrl-C ends it."""
    return _core.read(os.fspath(path), start=start, stop=stop, backwards=backwards, cameras=cameras,
                      truth="" if truth is None else os.fspath(truth), truth_level=truth_level, pairing=pairing,
                      max_truth_gap=max_truth_gap, truth_time_offset=truth_time_offset, truth_frame=truth_frame,
                      truth_scale=truth_scale, truth_inverse=truth_inverse)


@suggests_arguments
def read_run(folder: _core.Path) -> Run:
    """Reads a run folder that `chasles run -o` or Run.save wrote."""
    return Run(_core.read_run(os.fspath(folder)))


@suggests_arguments
def evaluate(estimate: Mapping[str, Any], truth: Mapping[str, Any], *, chart: str = "standard",
             level: bool = False) -> dict[str, Optional[float]]:
    """Compares an estimate with the truth and returns the figures of docs/evaluation.md: ate_m, rpe_..., and with
    `pose_covariance` in the estimate the NEES. Both are dictionaries with `time`, `position` (N, 3) and, if known,
    `quaternion` (N, 4), as Run.states and Recording.truth. Figures that do not apply are None.

    chart: the error chart in whose coordinates the NEES is. level: the z axis of the estimate's world points up, as in
    a run with an IMU, so that only heading and position are aligned for it."""
    for name, columns in (("estimate", estimate), ("truth", truth)):
        missing = [column for column in ("time", "position") if column not in columns]
        if missing:
            raise _core.UsageError(f"{name}: expected columns time and position, {', '.join(missing)} is missing")
    no_attitude: list[list[float]] = [[]]
    return _core.evaluate(estimate["time"], estimate["position"], estimate.get("quaternion", no_attitude),
                          truth["time"], truth["position"], truth.get("quaternion", no_attitude),
                          estimate.get("pose_covariance"), chart, level)


@suggests_arguments
def join_imu(gyro_time: Any, angular_rate: Any, accel_time: Any, specific_force: Any) -> dict[str, Any]:
    """The samples of an IMU whose accelerometer and gyroscope are read apart, each with (N,) times and (N, 3) values:
    at the times of the gyroscope, with the accelerometer interpolated. A dictionary with `time`, `angular_rate` and
    `specific_force` for `add_imu`, and `remarks`, sentences on what was joined and left out. InputError for streams
    that cannot be joined."""
    return _core.join_imu(gyro_time, angular_rate, accel_time, specific_force)


def settings(kind: str = "imu") -> dict[str, dict[str, str]]:
    """All settings by name, of runs with an IMU ("imu") or with body velocities ("velocity"), of scenes with an IMU
    ("scene") or of streets ("street"): {name: {"default", "unit", "meaning", "type"}}."""
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
