"""A recording of arrays."""

from __future__ import annotations

import os
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._columns import arrays_of, is_path, path_of
from ._one_line import found

Array = NDArray[Any]
Image = Union[Array, str, "os.PathLike[str]", None]
Frame = Union[Image, Sequence[Image]]


def from_arrays(*, imu_time: Any, angular_rate: Any, specific_force: Any, image_time: Any,
                images: Union[Sequence[Frame], Array, Callable[[int], Frame]],
                cameras: Union[_core.Camera, Sequence[_core.Camera]], imu_noise: Optional[_core.ImuNoise] = None,
                truth: Union[Mapping[str, Any], str, "os.PathLike[str]", None] = None, truth_level: Optional[bool] = None,
                name: str = "arrays") -> _core.Recording:
    """A recording of what is in memory. Times are (N,) ints [ns] or floats [s], on one clock, and rise.

    imu_time (N,), angular_rate (N, 3) [rad/s], specific_force (N, 3) [m/s^2]: in IMU axes. image_time (M,). images: of
    each frame one image, or a list with one for each camera; an image is an array (height, width) of uint8, an image of
    Pillow, whose colours become grey as those of files, the path of a file, or None. They are a sequence, an array (M, height, width) or (M, cameras, height, width), or a function
    images(i), which is called when a frame is needed, from any thread. cameras: a Camera, or a list of them. imu_noise:
    a run needs it. truth: columns `time`, `position` and, if known, `quaternion` of world_T_imu, or the path of a file
    as `chasles.read` takes it; truth_level: whether its z axis points up, where that is known.

    Raises InputError for shapes that do not fit, times that do not rise, rates that no sensor has (microseconds as ints)
    and numbers that are not finite. An image of another size than its camera's is an InputError where it is read; of a
    sequence, the first frame is examined at once."""
    rig = _rig(cameras)
    times = numpy.asarray(image_time)
    if not callable(images) and not hasattr(images, "__getitem__"):
        raise _core.UsageError(f"from_arrays: images: found {found(images)}, expected a sequence, an array, or a function "
                               "of the frame's number")
    if times.ndim == 1 and not callable(images) and len(images) != len(times):
        raise _core.InputError(f"from_arrays: found {len(times)} image times and {len(images)} frames of images; expected "
                               "as many")
    at = images if callable(images) else images.__getitem__

    def frame(i: int) -> List[Any]:
        return [_image(one) for one in _of_cameras(at(i), len(rig))]

    file = os.fspath(truth) if isinstance(truth, (str, os.PathLike)) else ""
    return _core.recording_of(name, numpy.asarray(imu_time), angular_rate, specific_force, times, frame,
                              not callable(images), rig, imu_noise, *_truth(None if file else truth), truth_level, file)


def _rig(cameras: Any) -> List[_core.Camera]:
    rig = [cameras] if isinstance(cameras, _core.Camera) else list(cameras) if hasattr(cameras, "__iter__") else [cameras]
    for one in rig:
        if not isinstance(one, _core.Camera):
            raise TypeError(f"from_arrays: cameras: found {found(one)}, expected a Camera, or a list of them")
    return rig


def _truth(truth: Any) -> Tuple[Any, Any, Any]:
    given = truth if truth is not None else {"time": numpy.zeros(0, numpy.int64), "position": numpy.zeros((0, 3))}
    try:
        return arrays_of(path_of(given, "truth", "position"), "truth")
    except _core.UsageError as error:
        raise _core.InputError(f"from_arrays: {error}, or the path of a file") from None


def _of_cameras(frame: Any, cameras: int) -> List[Any]:
    """The images of a frame: one image alone is that of the only camera."""
    if isinstance(frame, numpy.ndarray):
        return list(frame) if frame.ndim >= 3 and frame.shape[0] == cameras else [frame]
    return list(frame) if hasattr(frame, "__iter__") and not isinstance(frame, (str, bytes)) else [frame]


def _image(one: Any) -> Any:
    return os.fspath(one) if is_path(one) else one
