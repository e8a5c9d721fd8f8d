"""Calibration of cameras from corners of a target."""

from __future__ import annotations

import copy
import dataclasses
import html
import json
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._arguments import suggests_arguments
from ._one_line import found

Array = NDArray[Any]
_NAME = "calibrate_cameras"


class Parameters(NamedTuple):
    """What a calibration estimates: of each camera focal lengths, principal point and coefficients, after the first
    one also the errors of cam_T_cam0, and the target's bend."""

    names: List[str]
    """"cam0.fx", "cam1.rotation_x", "cam1.position_x", "target.bend_x", ..."""
    values: Array
    """[px, rad, m]. Rotations are those of cam_T_cam0 as rotation vectors."""
    sigmas: Array
    """Standard deviations, in the same units."""


class Halves(NamedTuple):
    """What two halves of the views say, each without the other; alternate pieces of the recording."""

    difference: Array
    """Of each parameter, the second half's minus the first's."""
    sigma: Array
    """Standard deviations of the differences, if sigmas were all there is."""
    pixels: Array
    """Of each camera, root mean square of the difference of the projections over the image [px]."""
    pixels_sigma: Array
    """What the sigmas let expect of it [px]."""
    held_out_rms: float
    """Root mean square error of the corners of each half by the other [px]."""


class CamerasCalibration:
    """Intrinsics and relative poses of cameras, with all that is said of them."""

    def __init__(self, report: dict[str, Any], cameras: Sequence[_core.Camera], views: dict[str, Array],
                 errors: dict[str, Array]) -> None:
        self._report = report
        self._cameras = tuple(cameras)
        self._views = views
        self._errors = errors

    @property
    def report(self) -> dict[str, Any]:
        """The content of cameras.json (docs/calibration.md), as a dictionary of the caller's own."""
        return copy.deepcopy(self._report)

    @property
    def cameras(self) -> list[_core.Camera]:
        """Their cam_T_imu is cam_T_cam0."""
        return list(self._cameras)

    @property
    def lenses(self) -> list[str]:
        """Of each camera, as the argument names them."""
        return [camera["lens"] for camera in self._report["cameras"]]

    @property
    def cam_T_cam0(self) -> Array:
        """(cameras, 4, 4): maps coordinates of the first camera to each camera's [m]."""
        return numpy.array([camera["cam_T_cam0"] for camera in self._report["cameras"]], dtype=float)

    @property
    def parameters(self) -> Parameters:
        rows = self._report["parameters"]
        return Parameters([row["name"] for row in rows], _column(rows, "value"), _column(rows, "sigma"))

    @property
    def covariance(self) -> Array:
        """Of the parameters, in their order."""
        return numpy.array(self._report["covariance"])

    @property
    def rms(self) -> Array:
        """Of each camera, root mean square of its corners' errors, along u and v together [px]."""
        return _column(self._report["cameras"], "rms_px")

    @property
    def pixel_sigma(self) -> float:
        """Standard deviation of a corner's u or v, robust [px]."""
        return float(self._report["pixel_sigma_px"])

    @property
    def correlation_factor(self) -> float:
        """By how much the variances are larger than those of errors that are independent from corner to corner."""
        return float(self._report["correlation_factor"])

    @property
    def halves(self) -> Optional[Halves]:
        """None where a half has too few views; a remark says so."""
        if "held_out_rms_px" not in self._report:
            return None
        rows, cameras = self._report["parameters"], self._report["cameras"]
        return Halves(_column(rows, "halves_difference"), _column(rows, "halves_sigma"), _column(cameras, "halves_px"),
                      _column(cameras, "halves_sigma_px"), float(self._report["held_out_rms_px"]))

    @property
    def views(self) -> dict[str, Array]:
        """The views that were used, by time and camera: time (V,) [ns], camera (V,), rms (V,) [px], cam_T_target
        (V, 4, 4) [m]."""
        return copy.deepcopy(self._views)

    @property
    def errors(self) -> dict[str, Array]:
        """Of each corner in the views: view (K,), the row of `views`; id (K,); pixel (K, 2) and error (K, 2), measured
        minus projected [px]."""
        return copy.deepcopy(self._errors)

    @property
    def remarks(self) -> list[str]:
        """Views that the others contradict, views that would make the result better, and the rest; one sentence each."""
        return [sentence for kind in ("suspicious", "missing", "remarks") for sentence in self._report[kind]]

    def projection_uncertainty(self, camera: int = 0) -> dict[str, Array]:
        """How far a direction may be from the pixel that the calibration gives it, over a grid of the image: pixel
        (N, 2), sigma_px (N,) along the worse axis [px], sigma_rad (N,) [rad]. A turn of the camera is left out."""
        cameras = self._report["cameras"]
        if not 0 <= camera < len(cameras):
            raise _core.UsageError(f"projection_uncertainty: camera: found {camera}, expected 0 to {len(cameras) - 1}")
        grid = numpy.array(cameras[camera]["projection"]["grid"], dtype=float).reshape(-1, 4)
        return {"pixel": grid[:, :2].copy(), "sigma_px": grid[:, 2].copy(), "sigma_rad": grid[:, 3].copy()}

    def __str__(self) -> str:
        heads = [f"cam{c}: {camera['lens']}, {camera['views']} views, {camera['corners']} corners, "
                 f"error {camera['rms_px']:.3f} px" for c, camera in enumerate(self._report["cameras"])]
        rows = [f"{row['name']:<20}{row['value']:>14.6g}{row['sigma']:>12.3g} {row['unit']}"
                for row in self._report["parameters"]]
        return "\n".join([*heads, f"{'parameter':<20}{'value':>14}{'sigma':>12}", *rows, *self.remarks])

    def __repr__(self) -> str:
        errors = ", ".join(f"{rms:.3f}" for rms in self.rms)
        return f"<chasles.CamerasCalibration: {', '.join(self.lenses)}, errors {errors} px>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def _column(rows: Sequence[dict[str, Any]], name: str) -> Array:
    return numpy.array([row[name] for row in rows], dtype=float)


@dataclasses.dataclass(frozen=True)
class _View:
    time: Any
    camera: int
    ids: List[int]
    pixels: Array


@suggests_arguments
def calibrate_cameras(corners: Any, views: Sequence[Tuple[Any, int, Any, Any]], sizes: Any,
                      lenses: Union[str, Sequence[str]] = "auto", *,
                      start: Union[_core.Camera, Sequence[_core.Camera], None] = None,
                      bend: bool = True) -> CamerasCalibration:
    """Calibrates cameras as `chasles calibrate cameras` does, from the corners of any detector.

    corners (N, 3): of the target, in its frame [m], whose z axis may point to the cameras or away. views: (time, camera, ids (K,), pixels (K, 2)) for each image; time
    an int [ns] or a float [s], one time for all cameras that see the target at an instant; ids are rows of `corners`;
    the centre of the first pixel is (0, 0), as with OpenCV. sizes: (width, height) of the images, for each camera.
    lenses: for all cameras, or a list with one for each: "radtan", "radtan:8" with eight coefficients, several with
    commas between them, of which views that took no part choose the best, or "auto" for the common ones. start: a
    Camera, or one for each, where the search begins, instead of from nothing. bend: estimate, too, by how much the
    middle of a flat target stands out.

    Raises InputError for views and corners that cannot be used, with what was found and expected, and where the views
    do not determine the parameters; UsageError for a lens that does not exist. Ctrl-C ends it."""
    points = _finite(corners, "corners", 3)
    if bend and len(points) and numpy.ptp(points[:, 2]) > 0:
        raise _core.InputError(f"{_NAME}: corners: found a target that is not flat, with z from {points[:, 2].min():g} to "
                               f"{points[:, 2].max():g} m; expected bend=False")
    image_sizes = _sizes(sizes)
    given = [_view(i, view, len(points), len(image_sizes)) for i, view in enumerate(views)]
    _check_times(given)
    text, cameras, seen, errors = _core.calibrate_cameras(
        points, [view.time for view in given], [view.camera for view in given], [view.ids for view in given],
        [view.pixels for view in given], image_sizes, _for_each(lenses, len(image_sizes)),
        _start(start, image_sizes), bool(bend))
    return CamerasCalibration(json.loads(text), cameras, seen, errors)


def _finite(values: Any, name: str, columns: int) -> Array:
    try:
        array = numpy.asarray(values, dtype=float)
    except (TypeError, ValueError):
        array = None
    if array is None or array.ndim != 2 or array.shape[1] != columns:
        raise _core.InputError(f"{_NAME}: {name}: found {found(values if array is None else array)}, expected an array "
                               f"(N, {columns}) of numbers")
    if not numpy.isfinite(array).all():
        row = int(numpy.argmin(numpy.isfinite(array).all(axis=1)))
        raise _core.InputError(f"{_NAME}: {name}: found {array[row].tolist()} in row {row}, expected finite numbers")
    return array


def _whole(values: Any, name: str, columns: int) -> Array:
    array = numpy.asarray(values)
    if array.ndim != columns or (array.size and not numpy.issubdtype(array.dtype, numpy.integer)):
        expected = "whole numbers" if columns == 1 else "(width, height) of each camera"
        raise _core.InputError(f"{_NAME}: {name}: found {found(values)}, expected {expected}")
    return array.astype(numpy.int64)


def _sizes(sizes: Any) -> List[Tuple[int, int]]:
    array = _whole(sizes, "sizes", 2)
    if array.shape[0] == 0 or array.shape[1] != 2 or array.min() < 1 or array.max() > 100_000:
        raise _core.InputError(f"{_NAME}: sizes: found {found(sizes)}, expected (width, height) of each camera, from 1 to "
                               "100000 px")
    return [(int(width), int(height)) for width, height in array]


def _view(i: int, view: Any, corners: int, cameras: int) -> _View:
    name = f"views[{i}]"
    try:
        time, camera, ids, pixels = view
    except (TypeError, ValueError):
        raise _core.InputError(f"{_NAME}: {name}: found {found(view)}, expected (time, camera, ids, pixels)") from None
    if isinstance(time, bool) or not isinstance(time, (int, float, numpy.integer, numpy.floating)) or not numpy.isfinite(time):
        raise _core.InputError(f"{_NAME}: {name}: time: found {found(time)}, expected an int [ns] or a finite float [s]")
    if isinstance(camera, bool) or not isinstance(camera, (int, numpy.integer)) or not 0 <= camera < cameras:
        raise _core.InputError(f"{_NAME}: {name}: camera: found {found(camera)}, expected 0 to {cameras - 1}, as `sizes` has "
                               "them")
    numbers = _whole(numpy.ravel(ids), f"{name}: ids", 1)
    where = _finite(numpy.reshape(pixels, (-1, 2)) if numpy.ndim(pixels) == 3 else pixels, f"{name}: pixels", 2)
    if len(numbers) != len(where):
        raise _core.InputError(f"{_NAME}: {name}: found {len(numbers)} ids and {len(where)} pixels, expected as many")
    beyond = numbers[(numbers < 0) | (numbers >= corners)]
    if len(beyond):
        raise _core.InputError(f"{_NAME}: {name}: found the id {beyond[0]}, expected 0 to {corners - 1}, a row of corners")
    order = numpy.argsort(numbers, kind="stable")
    twice = numbers[order][1:][numpy.diff(numbers[order]) == 0]
    if len(twice):
        raise _core.InputError(f"{_NAME}: {name}: found the id {twice[0]} twice, expected each corner once")
    return _View(time, int(camera), numbers[order].tolist(), where[order])


def _check_times(views: List[_View]) -> None:
    """One view of a camera for each time: cameras of an instant have one pose of the target."""
    first: dict[Any, int] = {}
    for i, view in enumerate(views):
        j = first.setdefault((view.time, view.camera), i)
        if j != i:
            raise _core.InputError(f"{_NAME}: found views[{j}] and views[{i}] of camera {view.camera} at the time "
                                   f"{view.time}, expected a time of its own for each image of a camera")


def _for_each(lenses: Any, cameras: int) -> List[str]:
    names = [lenses] * cameras if isinstance(lenses, str) else list(lenses)
    if len(names) != cameras or not all(isinstance(name, str) for name in names):
        raise _core.UsageError(f"{_NAME}: lenses: found {found(lenses)}, expected one str, or one for each of {cameras} "
                               "cameras")
    return names


def _start(start: Any, sizes: List[Tuple[int, int]]) -> List[_core.Camera]:
    cameras = [] if start is None else [start] if isinstance(start, _core.Camera) else list(start)
    if not cameras:
        return []
    if [(camera.width, camera.height) for camera in cameras] != sizes:
        raise _core.InputError(f"{_NAME}: start: found cameras of {[(one.width, one.height) for one in cameras]} px, expected "
                               f"one for each of sizes, {sizes}")
    return cameras
