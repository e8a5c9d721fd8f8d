"""The functions of the package that have no settings as arguments."""

from __future__ import annotations

import json
import os
import signal
import sys
from typing import Any, Literal, Mapping, NoReturn, Optional, Sequence, Union

import numpy

from . import _core
from ._arguments import suggests_arguments
from ._columns import arrays_of, path_of
from ._laboratory import laboratory
from ._one_line import found
from ._run import Run


_INTERRUPTED = 130


@suggests_arguments
def read(path: _core.Path, *, start: Optional[float] = None, stop: Optional[float] = None, backwards: bool = False,
         cameras: Union[str, Sequence[int]] = "", truth: Optional[_core.Path] = None,
         truth_level: Union[str, bool] = "auto", pairing: str = "",
         max_truth_gap: Optional[float] = None, truth_time_offset: Union[float, Literal["auto"], None] = None,
         truth_frame: str = "",
         truth_scale: Optional[float] = None, truth_inverse: bool = False) -> _core.Recording:
    """Reads a recording of any kind that `chasles run` reads (docs/formats.md), cut to [start, stop] seconds
    since its first event. cameras: "mono", "stereo", "" (all) or their numbers in the order of their use,
    as [0, 2, 3]. truth: a TUM file, or a recording with a truth, that replaces the recording's truth;
    truth_level: True or "yes", False or "no" where its z axis points up or does not; pairing: "interpolate" or
    "nearest"; max_truth_gap [s] between its stamps; truth_time_offset [s], added to its times, or "auto" where
    its motion against the estimate's shows it;
    truth_frame: "imu", "cam0" or a file, whose poses it has; truth_scale: metres in its unit; truth_inverse:
    its poses are imu_T_world (docs/evaluation.md). Raises InputError with file, place, what was found and what
    was expected. Ctrl-C ends it."""
    return _core.read(os.fspath(path), start=start, stop=stop, backwards=backwards, cameras=_choice(cameras),
                      truth="" if truth is None else os.fspath(truth), truth_level=_level(truth_level), pairing=pairing,
                      max_truth_gap=max_truth_gap, truth_time_offset=_offset(truth_time_offset),
                      truth_frame=os.fspath(truth_frame),
                      truth_scale=truth_scale, truth_inverse=truth_inverse)


def _choice(cameras: Any) -> str:
    if isinstance(cameras, str):
        return cameras
    numbers = list(cameras) if hasattr(cameras, "__iter__") else [cameras]
    if not numbers or not all(isinstance(n, (int, numpy.integer)) and not isinstance(n, bool) for n in numbers):
        raise TypeError(f"read: cameras: found {cameras!r}, expected 'mono', 'stereo', '' (all) or a list of numbers")
    return ",".join(str(n) for n in numbers)


def _level(truth_level: Any) -> Any:
    return ("yes" if truth_level else "no") if isinstance(truth_level, bool) else truth_level


def _offset(seconds: Any) -> str:
    if seconds is None or seconds == "auto":
        return seconds or ""
    if isinstance(seconds, (int, float, numpy.number)) and not isinstance(seconds, bool) and numpy.isfinite(seconds):
        return repr(float(seconds))
    raise _core.UsageError(f"truth_time_offset: found {found(seconds)}, expected a finite number of seconds, or 'auto'")


@suggests_arguments
def read_run(folder: _core.Path) -> Run:
    """Reads a run folder that `chasles run -o` or Run.save wrote."""
    return Run(_core.read_run(os.fspath(folder)))


@suggests_arguments
def evaluate(estimate: Union[Run, Mapping[str, Any]], truth: Union[_core.Recording, Run, Mapping[str, Any]], *,
             chart: Optional[str] = None, level: Optional[bool] = None,
             truth_errors: Literal["auto", "none"] = "none") -> dict[str, Any]:
    """Compares an estimate with the truth and returns the figures of docs/evaluation.md: ate_m, rpe_..., and with
    `pose_covariance` in the estimate the NEES. Both are dictionaries with `time`, `position` (N, 3) and, if known,
    `quaternion` (N, 4), as Run.states and Recording.truth; or a Run, whose states count, and a Recording, whose truth
    does. Figures that do not apply are None.

    chart: the error chart in whose coordinates the NEES is. level: the z axis of the estimate's world points up, as in
    a run with an IMU, so that only heading and position are aligned for it. Their defaults are those of the run where
    the estimate is a Run or its columns, and otherwise "standard" and False. truth_errors: "auto" estimates constant
    errors of the truth, as `chasles evaluate --truth-errors auto`; the figure `truth_errors` is then its dictionary.
    UsageError where covariances or attitudes are missing."""
    of_estimate = path_of(estimate, "estimate", "position")
    of_truth = path_of(truth, "truth", "position")
    charts = _core.chart_names()
    if chart is not None and chart not in charts:
        raise _core.UsageError(f"evaluate: chart: found {found(chart)}, expected one of {', '.join(charts)}")
    if truth_errors not in ("auto", "none"):
        raise _core.UsageError(f"evaluate: truth_errors: found {found(truth_errors)}, expected 'auto' or 'none'")
    arguments = (*arrays_of(of_estimate, "estimate"), *arrays_of(of_truth, "truth"), of_estimate.get("pose_covariance"),
                 getattr(of_estimate, "chart", "standard") if chart is None else chart,
                 getattr(of_estimate, "level", False) if level is None else level)
    figures: dict[str, Any] = _core.evaluate(*arguments)
    if truth_errors == "auto":
        figures["truth_errors"] = json.loads(_core.truth_errors(*arguments))
    return figures


@suggests_arguments
def join_imu(gyro_time: Any, angular_rate: Any, accel_time: Any, specific_force: Any) -> dict[str, Any]:
    """The samples of an IMU whose accelerometer and gyroscope are read apart, each with (N,) times and (N, 3) values:
    at the times of the gyroscope, with the accelerometer interpolated. A dictionary with `time`, `angular_rate` and
    `specific_force` for `add_imu`, and `remarks`, sentences on what was joined and left out. InputError for streams
    that cannot be joined."""
    return _core.join_imu(numpy.asarray(gyro_time), angular_rate, numpy.asarray(accel_time), specific_force)


def settings(kind: str = "imu") -> dict[str, dict[str, str]]:
    """All settings by name, of runs with an IMU ("imu") or with body velocities ("velocity"), of scenes with an IMU
    ("scene") or of streets ("street"): {name: {"default", "unit", "meaning", "type"}}."""
    if kind not in ("scene", "street"):
        return _core.settings(kind)
    of_scenes: dict[str, dict[str, str]] = laboratory().settings(kind)
    return of_scenes


def command(*arguments: object) -> int:
    """Runs the command `chasles` in this process: command("check", "MH_01"). Returns its exit code. Ctrl-C ends it with
    KeyboardInterrupt."""
    code: int = laboratory().command([str(argument) for argument in arguments])
    if code == _INTERRUPTED:  # the command had its own handler of the signal, and finished its files
        raise KeyboardInterrupt
    return code


def main() -> NoReturn:
    """The console script `chasles`: signals do what they do to the command of the build. Python would only note
    Ctrl-C until the command ends, and ignores a closed pipe."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.exit(laboratory().command(sys.argv[1:]))
