"""Calibration of cameras with their IMU, from corners of a target and from any motion."""

from __future__ import annotations

import copy
import html
import json
import os
from typing import Any, List, Mapping, NamedTuple, Sequence, Tuple, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._arguments import suggests_arguments
from ._calibrate import CamerasCalibration, _column
from ._one_line import found
from ._views import GivenViews

Array = NDArray[Any]
_COLUMNS = ("time", "specific_force", "angular_rate")


class ImuCorrection(NamedTuple):
    """Scales and misalignments of an IMU: I + force times a measured specific force, and I + rate times a measured angular
    rate, are right but for their biases."""

    force: Array
    """(3, 3), lower triangular."""
    rate: Array
    """(3, 3)."""


class ImuCamerasCalibration(CamerasCalibration):
    """Cameras with their IMU, with all that is said of them. `parameters` and `covariance` have of each camera its lens,
    cam_T_imu, the time offset [s] and with rolling=True the readout time [s], then the direction of gravity [rad], the
    IMU's scales and misalignments, and the target's bend."""

    def __init__(self, report: dict[str, Any], cameras: Sequence[_core.Camera], views: dict[str, Array],
                 errors: dict[str, Array], imu_correction: ImuCorrection) -> None:
        super().__init__(report, cameras, views, errors)
        self._imu_correction = imu_correction

    @property
    def cam_T_imu(self) -> Array:
        """(cameras, 4, 4): maps coordinates of the IMU to each camera's [m]."""
        return numpy.array([camera.cam_T_imu for camera in self._cameras])

    @property
    def time_offsets(self) -> Array:
        """Of each camera: its clock + offset = the IMU's clock [s]."""
        return _column(self._report["cameras"], "time_offset_s")

    @property
    def readout_times(self) -> Array:
        """Of each camera, from its first line to after the last one [s]."""
        return _column(self._report["cameras"], "readout_time_s")

    @property
    def gravity(self) -> Array:
        """In the target's frame [m/s^2]."""
        return numpy.array(self._report["gravity_target_m_per_s2"])

    @property
    def accelerometer_bias(self) -> Array:
        """The mean [m/s^2]."""
        return numpy.array(self._report["accelerometer_bias_m_per_s2"])

    @property
    def gyroscope_bias(self) -> Array:
        """The mean [rad/s]."""
        return numpy.array(self._report["gyroscope_bias_rad_per_s"])

    @property
    def imu_correction(self) -> ImuCorrection:
        """Zeros with exact_imu=True."""
        return ImuCorrection(*(matrix.copy() for matrix in self._imu_correction))


@suggests_arguments
def calibrate_imu_cameras(corners: Any, views: Sequence[Tuple[Any, int, Any, Any]], sizes: Any, imu: Mapping[str, Any],
                          lenses: Union[str, Sequence[str]] = "auto", *, noise: _core.ImuNoise, gravity: float = 9.80665,
                          rolling: bool = False, exact_imu: bool = False,
                          start: Union[_core.Camera, Sequence[_core.Camera], None] = None,
                          bend: bool = True) -> ImuCamerasCalibration:
    """Calibrates cameras with their IMU as `chasles calibrate imu-cameras` does, from the corners of a static target by any
    detector.

    corners, views, sizes, lenses, start, bend: as of calibrate_cameras(). imu: the arrays `time` (N,), of int [ns] or float
    [s] as those of the views, `specific_force` (N, 3) [m/s^2] and `angular_rate` (N, 3) [rad/s], samples of instants, as
    `recording.imu` has them. noise: of the IMU. gravity: its magnitude there [m/s^2]. rolling: estimate readout times, also
    where no camera of `start` has one. exact_imu: the IMU has no errors of scales and axes.

    Raises InputError for arrays that cannot be used, with what was found and expected, for an IMU that does not move as the
    cameras do, and where the motion does not determine the parameters; UsageError for a lens that does not exist. Ctrl-C
    ends it."""
    given = GivenViews("calibrate_imu_cameras", corners, views, sizes, lenses, start, bend)
    samples = _core.recording_of_imu(*_samples(given, imu))
    if not isinstance(noise, _core.ImuNoise):
        raise _core.UsageError(f"calibrate_imu_cameras: noise: found {found(noise)}, expected an ImuNoise")
    if isinstance(gravity, bool) or not isinstance(gravity, (int, float)) or not 9.7 <= gravity <= 9.9:
        raise _core.UsageError(f"calibrate_imu_cameras: gravity: found {found(gravity)}, expected 9.7 to 9.9 m/s^2")
    text, cameras, seen, errors, force, rate = _core.calibrate_imu_cameras(
        *given.arguments, samples, noise, float(gravity), bool(rolling), bool(exact_imu))
    return ImuCamerasCalibration(json.loads(text), cameras, seen, errors, ImuCorrection(force, rate))


def _samples(given: GivenViews, imu: Any) -> Tuple[Array, Array, Array]:
    missing = [name for name in _COLUMNS if not isinstance(imu, Mapping) or name not in imu]
    if missing:
        raise given.error(f"imu: found {found(imu)} without '{missing[0]}', expected a dictionary with time, specific_force "
                          "and angular_rate")
    time = numpy.asarray(imu["time"])
    force, rate = (given.finite(imu[name], f"imu: {name}", 3) for name in _COLUMNS[1:])
    if time.ndim != 1 or not len(time) == len(force) == len(rate):
        raise given.error(f"imu: found time {found(time)}, {len(force)} rows of specific_force and {len(rate)} of "
                          "angular_rate, expected as many")
    if time.dtype.kind not in "iuf" or not numpy.isfinite(time).all():
        raise given.error(f"imu: time: found {found(time)}, expected finite numbers")
    early = numpy.flatnonzero(numpy.diff(time) <= 0)
    if len(early):
        raise given.error(f"imu: time: found {time[early[0] + 1]} after {time[early[0]]} in row {early[0] + 1}, expected "
                          "rising times")
    return time, force, rate


class StatedParameters(NamedTuple):
    """What a calibration from motion estimates."""

    names: List[str]
    """"imu_T_cam0_x", "cam0_fx", ..."""
    stated: Array
    """Before [px, m, rad, s]."""
    values: Array
    """In the same units."""
    sigmas: Array


class MotionCalibration:
    """Cameras with their IMU, from any motion. `print(calibration)` is the table of `chasles calibrate imu-cameras`."""

    def __init__(self, report: dict[str, Any], cameras: Sequence[_core.Camera], time_offset: float, text: str) -> None:
        self._report = report
        self._cameras = tuple(cameras)
        self._time_offset = time_offset
        self._text = text

    @property
    def report(self) -> dict[str, Any]:
        """The content of imu-cameras.json, as a dictionary of the caller's own."""
        return copy.deepcopy(self._report)

    @property
    def cameras(self) -> list[_core.Camera]:
        """With cam_T_imu and the lens."""
        return list(self._cameras)

    @property
    def time_offset(self) -> float:
        """The clock of the cameras + offset = the IMU's clock [s]."""
        return self._time_offset

    @property
    def parameters(self) -> StatedParameters:
        rows = self._report["parameters"]
        return StatedParameters([row["name"] for row in rows], _column(rows, "stated"), _column(rows, "estimate"),
                                _column(rows, "sigma"))

    @property
    def remarks(self) -> list[str]:
        return list(self._report["remarks"])

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<chasles.MotionCalibration of {len(self._cameras)} cameras>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self._text)}</pre>"


@suggests_arguments
def calibrate_from_motion(recording: Union[_core.Recording, _core.Path], *, from_nothing: bool = False) -> MotionCalibration:
    """Calibrates cameras with their IMU without a target, as `chasles calibrate imu-cameras` does: by batch estimation of the
    recording (Recording, or a path), with mounting, lenses and clock as states. from_nothing: the mounting that the
    recording states is not used; rotations of the images show it first. Raises as `run`, and InputError where they do not
    show it. Ctrl-C ends it."""
    if not isinstance(recording, _core.Recording):
        recording = _core.read(os.fspath(recording))
    text, cameras, time_offset, table = _core.calibrate_from_motion(recording, bool(from_nothing))
    return MotionCalibration(json.loads(text), cameras, time_offset, table)
