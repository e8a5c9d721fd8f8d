"""Views of a target that are arguments of a calibration, checked."""

from __future__ import annotations

import dataclasses
from typing import Any, List, Sequence, Tuple

import numpy
from numpy.typing import NDArray

from . import _core
from ._one_line import found

Array = NDArray[Any]


@dataclasses.dataclass(frozen=True)
class _View:
    time: Any
    camera: int
    ids: List[int]
    pixels: Array


class GivenViews:
    """The arguments of calibrate_cameras(), in the form that the core takes; `call` names the function in errors."""

    def __init__(self, call: str, corners: Any, views: Sequence[Any], sizes: Any, lenses: Any, start: Any,
                 bend: bool) -> None:
        self._call = call
        points = self.finite(corners, "corners", 3)
        if bend and len(points) and numpy.ptp(points[:, 2]) > 0:
            raise self.error(f"corners: found a target that is not flat, with z from {points[:, 2].min():g} to "
                             f"{points[:, 2].max():g} m; expected bend=False")
        image_sizes = self._sizes(sizes)
        given = [self._view(i, view, len(points), len(image_sizes)) for i, view in enumerate(views)]
        self._check_times(given)
        self.arguments = (points, [view.time for view in given], [view.camera for view in given],
                          [view.ids for view in given], [view.pixels for view in given], image_sizes,
                          self._for_each(lenses, len(image_sizes)), self._start(start, image_sizes), bool(bend))

    def error(self, sentence: str) -> _core.InputError:
        return _core.InputError(f"{self._call}: {sentence}")

    def finite(self, values: Any, name: str, columns: int) -> Array:
        try:
            array = numpy.asarray(values, dtype=float)
        except (TypeError, ValueError):
            array = None
        if array is None or array.ndim != 2 or array.shape[1] != columns:
            raise self.error(f"{name}: found {found(values if array is None else array)}, expected an array "
                                   f"(N, {columns}) of numbers")
        if not numpy.isfinite(array).all():
            row = int(numpy.argmin(numpy.isfinite(array).all(axis=1)))
            raise self.error(f"{name}: found {array[row].tolist()} in row {row}, expected finite numbers")
        return array

    def _whole(self, values: Any, name: str, columns: int) -> Array:
        array = numpy.asarray(values)
        if array.ndim != columns or (array.size and not numpy.issubdtype(array.dtype, numpy.integer)):
            expected = "whole numbers" if columns == 1 else "(width, height) of each camera"
            raise self.error(f"{name}: found {found(values)}, expected {expected}")
        return array.astype(numpy.int64)

    def _sizes(self, sizes: Any) -> List[Tuple[int, int]]:
        array = self._whole(sizes, "sizes", 2)
        if array.shape[0] == 0 or array.shape[1] != 2 or array.min() < 1 or array.max() > 100_000:
            raise self.error(f"sizes: found {found(sizes)}, expected (width, height) of each camera, from 1 to "
                                   "100000 px")
        return [(int(width), int(height)) for width, height in array]

    def _view(self, i: int, view: Any, corners: int, cameras: int) -> _View:
        name = f"views[{i}]"
        try:
            time, camera, ids, pixels = view
        except (TypeError, ValueError):
            raise self.error(f"{name}: found {found(view)}, expected (time, camera, ids, pixels)") from None
        if isinstance(time, bool) or not isinstance(time, (int, float, numpy.integer, numpy.floating)) or not numpy.isfinite(time):
            raise self.error(f"{name}: time: found {found(time)}, expected an int [ns] or a finite float [s]")
        if isinstance(camera, bool) or not isinstance(camera, (int, numpy.integer)) or not 0 <= camera < cameras:
            raise self.error(f"{name}: camera: found {found(camera)}, expected 0 to {cameras - 1}, as `sizes` has "
                                   "them")
        numbers = self._whole(numpy.ravel(ids), f"{name}: ids", 1)
        where = self.finite(numpy.reshape(pixels, (-1, 2)) if numpy.ndim(pixels) == 3 else pixels, f"{name}: pixels", 2)
        if len(numbers) != len(where):
            raise self.error(f"{name}: found {len(numbers)} ids and {len(where)} pixels, expected as many")
        beyond = numbers[(numbers < 0) | (numbers >= corners)]
        if len(beyond):
            raise self.error(f"{name}: found the id {beyond[0]}, expected 0 to {corners - 1}, a row of corners")
        order = numpy.argsort(numbers, kind="stable")
        twice = numbers[order][1:][numpy.diff(numbers[order]) == 0]
        if len(twice):
            raise self.error(f"{name}: found the id {twice[0]} twice, expected each corner once")
        return _View(time, int(camera), numbers[order].tolist(), where[order])

    def _check_times(self, views: List[_View]) -> None:
        """One view of a camera for each time: cameras of an instant have one pose of the target."""
        first: dict[Any, int] = {}
        for i, view in enumerate(views):
            j = first.setdefault((view.time, view.camera), i)
            if j != i:
                raise self.error(f"found views[{j}] and views[{i}] of camera {view.camera} at the time "
                                       f"{view.time}, expected a time of its own for each image of a camera")

    def _for_each(self, lenses: Any, cameras: int) -> List[str]:
        names = [lenses] * cameras if isinstance(lenses, str) else list(lenses)
        if len(names) != cameras or not all(isinstance(name, str) for name in names):
            raise _core.UsageError(f"{self._call}: lenses: found {found(lenses)}, expected one str, or one for each of {cameras} "
                                   "cameras")
        return names

    def _start(self, start: Any, sizes: List[Tuple[int, int]]) -> List[_core.Camera]:
        cameras = [] if start is None else [start] if isinstance(start, _core.Camera) else list(start)
        if not cameras:
            return []
        if [(camera.width, camera.height) for camera in cameras] != sizes:
            raise self.error(f"start: found cameras of {[(one.width, one.height) for one in cameras]} px, expected "
                                   f"one for each of sizes, {sizes}")
        return cameras
