"""A recording of arrays."""

from __future__ import annotations

import os
from typing import Any, Callable, List, Mapping, Optional, Sequence, Union

import numpy
from numpy.typing import NDArray

from . import _core

Array = NDArray[Any]
Image = Union[Array, str, "os.PathLike[str]", None]
Frame = Union[Image, Sequence[Image]]


def from_arrays(*, imu_time: Any, angular_rate: Any, specific_force: Any, image_time: Any,
                images: Union[Sequence[Frame], Array, Callable[[int], Frame]],
                cameras: Union[_core.Camera, Sequence[_core.Camera]], imu_noise: Optional[_core.ImuNoise] = None,
                truth: Union[Mapping[str, Any], None] = None, truth_level: Optional[bool] = None,
                name: str = "arrays") -> _core.Recording:
    """A recording of what is in memory. Times are (N,) ints [ns] or floats [s], on one clock, and rise.

    imu_time (N,), angular_rate (N, 3) [rad/s], specific_force (N, 3) [m/s^2]: in IMU axes. image_time (M,). images: of
    each frame one image, or a list with one for each camera; an image is an array (height, width) of uint8, the path of
    a file, or None. They are a sequence, an array (M, height, width) or (M, cameras, height, width), or a function
    images(i), which is called when a frame is needed, from any thread. cameras: a Camera, or a list of them. imu_noise:
    a run needs it. truth: columns `time`, `position` and, if known, `quaternion` of world_T_imu; truth_level: whether
    its z axis points up, where that is known.

    Raises InputError for shapes that do not fit, times that do not rise and samples that are not finite. An image of
    another size than its camera's is an InputError where it is read."""
    rig = [cameras] if isinstance(cameras, _core.Camera) else list(cameras)
    times = numpy.asarray(image_time)
    if not callable(images) and len(images) != len(times):
        raise _core.InputError(f"from_arrays: found {len(times)} image times and {len(images)} frames of images; expected "
                               "as many")
    at = images if callable(images) else images.__getitem__

    def frame(i: int) -> List[Any]:
        return [_image(one) for one in _of_cameras(at(i), len(rig))]

    given = truth if truth is not None else {"time": numpy.zeros(0, numpy.int64), "position": numpy.zeros((0, 3))}
    return _core.recording_of(name, numpy.asarray(imu_time), angular_rate, specific_force, times, frame, rig, imu_noise,
                              numpy.asarray(given["time"]), given["position"], given.get("quaternion", [[]]), truth_level)


def _of_cameras(frame: Any, cameras: int) -> List[Any]:
    """The images of a frame: one image alone is that of the only camera."""
    if frame is None or isinstance(frame, (str, os.PathLike)) or (isinstance(frame, numpy.ndarray) and frame.ndim == 2):
        return [frame]
    return list(frame)


def _image(one: Any) -> Any:
    return os.fspath(one) if isinstance(one, (str, os.PathLike)) else one
