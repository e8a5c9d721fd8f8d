"""Calibration of cameras from corners of a target."""

from __future__ import annotations

import copy
import html
import json
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._arguments import suggests_arguments
from ._views import GivenViews

Array = NDArray[Any]


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
    """Root mean square error of the corners of each half by the other [px]; NaN with an IMU, where it is not measured."""


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
        """The content of cameras.json, or of imu-cameras.json (docs/calibration.md), as a dictionary of the caller's own."""
        return copy.deepcopy(self._report)

    @property
    def cameras(self) -> list[_core.Camera]:
        """Without an IMU their cam_T_imu is cam_T_cam0; with one they have the readout time, too."""
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
        rows, cameras = self._report["parameters"], self._report["cameras"]
        if "halves_px" not in cameras[0]:
            return None
        return Halves(_column(rows, "halves_difference"), _column(rows, "halves_sigma"), _column(cameras, "halves_px"),
                      _column(cameras, "halves_sigma_px"), float(self._report.get("held_out_rms_px", numpy.nan)))

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
        width = 1 + max(len(row["name"]) for row in self._report["parameters"])
        rows = [f"{row['name']:<{width}}{row['value']:>14.6g}{row['sigma']:>12.3g} {row['unit']}"
                for row in self._report["parameters"]]
        return "\n".join([*heads, f"{'parameter':<{width}}{'value':>14}{'sigma':>12}", *rows, *self.remarks])

    def __repr__(self) -> str:
        errors = ", ".join(f"{rms:.3f}" for rms in self.rms)
        return f"<chasles.{type(self).__name__}: {', '.join(self.lenses)}, errors {errors} px>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def _column(rows: Sequence[dict[str, Any]], name: str) -> Array:
    return numpy.array([row[name] for row in rows], dtype=float)


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
    given = GivenViews("calibrate_cameras", corners, views, sizes, lenses, start, bend)
    text, cameras, seen, errors = _core.calibrate_cameras(*given.arguments)
    return CamerasCalibration(json.loads(text), cameras, seen, errors)
