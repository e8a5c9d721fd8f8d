"""The results of a run."""

from __future__ import annotations

import copy
import functools
import json
import os
from typing import Any, Dict, Literal, Mapping, Optional

import numpy

from . import _core
from ._columns import arrays_of, path_of
from ._page import Page

_NS = 1_000_000_000


class Columns(Dict[str, Any]):
    """Columns by name. `velocity_x_sigma`, a name of earlier versions, is `sigma_velocity_x`."""

    chart = "standard"
    """The error chart of the run."""
    level = False
    """Whether the z axis of its world points up."""

    def __missing__(self, name: str) -> Any:
        if name.endswith("_sigma") and f"sigma_{name[:-6]}" in self:
            return self[f"sigma_{name[:-6]}"]
        raise KeyError(f"{name}; there are {', '.join(self)}")


def _read_only(columns: Mapping[str, Any]) -> Dict[str, Any]:
    """The columns as arrays that cannot be changed."""
    arrays = {name: numpy.asarray(values) for name, values in columns.items()}
    for array in arrays.values():
        array.setflags(write=False)
    return arrays


class Run(Page):
    """The results of a run: arrays, figures, a picture, and the page. The arrays are read-only (`copy()` makes one that is
    not), and each dictionary is the caller's own: no change of it changes the run."""

    def __init__(self, core: _core.Run) -> None:
        self._core = core

    @property
    def name(self) -> str:
        """The recording's name."""
        return self._core.name

    @functools.cached_property
    def _summary(self) -> dict[str, Any]:
        summary: dict[str, Any] = json.loads(self._core._summary)
        if "remarks" in summary:
            summary["remarks"] = [_core.in_python(one) for one in summary["remarks"]]
        return summary

    @functools.cached_property
    def _columns(self) -> dict[str, dict[str, Any]]:
        core = self._core
        return {name: _read_only(one) for name, one in (
            ("states", core.states), ("smoothed", core.smoothed), ("in_map", core.in_map), ("landmarks", core.landmarks),
            ("truth", core.truth))}

    def _own(self, name: str) -> Columns:
        columns = Columns(self._columns[name])
        columns.chart, columns.level = self._summary.get("chart", "standard"), self._core._level
        return columns

    @property
    def summary(self) -> dict[str, Any]:
        """The figures of summary.json (docs/command-line.md) as a dictionary of the caller's own."""
        return copy.deepcopy(self._summary)

    @property
    def states(self) -> dict[str, Any]:
        """The estimates of all frames, a dictionary of columns: `time` (N,) int64 [ns], `position` (N, 3), `quaternion`
        (N, 4), `pose_covariance` (N, 6, 6), the other states and their sigmas by the names of states.csv (`velocity_x`,
        `sigma_velocity_x`, ...), `nis`, `nis_dof`, counts, and `health` (N,) of str."""
        return self._own("states")

    @property
    def smoothed(self) -> dict[str, Any]:
        """The path given all measurements: `time`, `position`, `quaternion`, `pose_covariance`; empty where unknown."""
        return self._own("smoothed")

    def states_at(self, times: Any, *, smoothed: bool = False, longest_gap: float = 0.2) -> dict[str, Any]:
        """The states at these times, in any order: (M,) ints [ns] or floats [s]. The columns are those of `states` without
        the figures of frames, or with smoothed=True those of `smoothed`, and `known` (M,) of bool.

        At the time of a state it is that state. Between two that are at most longest_gap [s] apart, positions and other
        states are interpolated linearly, and rotations on the geodesic. Covariances and squares of sigmas are
        interpolated linearly, too, which is an upper bound for the error of the neighbours, whatever its correlation, and
        does not have that of the interpolation. Elsewhere (outside the path, in gaps, where the run was lost) `known` is
        False, and the row is the nearest state. Raises UsageError for a run without that path."""
        path = "smoothed" if smoothed else "states"
        if not 0 < longest_gap <= 3600:
            raise _core.UsageError(f"longest_gap: found {longest_gap} s, expected above 0 and at most 3600")
        if not len(self._columns[path]["time"]):
            raise _core.UsageError(f"states_at: the run '{self.name}' has no {path}"
                                   + (", expected one of a filter with exact_map" if smoothed else ""))
        rows = Columns(self._core._states_at(numpy.asarray(times), smoothed, longest_gap))
        for name in ("nis", "nis_dof", "observations", "used", "rejected", "added", "in_state", "landmarks"):
            rows.pop(name, None)
        rows.chart, rows.level = self._summary.get("chart", "standard"), self._core._level
        return rows

    @property
    def in_map(self) -> dict[str, Any]:
        """The poses in the frame of the map that was given, from the frame on in which the run found its place."""
        return self._own("in_map")

    @property
    def landmarks(self) -> dict[str, Any]:
        """`id` (N,), `position` (N, 3), `covariance` (N, 3, 3), `observations` (N,)."""
        return self._own("landmarks")

    @property
    def truth(self) -> dict[str, Any]:
        """`time`, `position`, `quaternion` in the truth's own world; empty where unknown. A truth of positions alone has
        no `quaternion`."""
        truth = self._own("truth")
        if not self._summary.get("truth_attitudes", True):
            del truth["quaternion"]
        return truth

    @property
    def has_truth(self) -> bool:
        """Whether the recording has a truth."""
        return len(self._columns["truth"]["time"]) > 0

    def to_dataframe(self) -> Any:
        """The states as a pandas DataFrame, a row for each estimate, with the columns of states.csv but the covariances:
        `time_ns`, `x` to `qw`, `sigma_rx` to `sigma_z`, ... Before them: `frame`, the number of the frame in the
        recording; `seconds` since the first estimate; `image_time_ns`, the frame's time as the cameras stamp it. `frame`
        is missing (pandas.NA) for a run that was read from a folder. Raises ImportError without pandas."""
        from ._optional import optional

        pandas = optional("pandas", "pandas")
        states = self.states
        time = states["time"]
        columns: dict[str, Any] = {"frame": self._frames(pandas),
                                   "seconds": (time - time[0]) / _NS if len(time) else numpy.zeros(0),
                                   "image_time_ns": self._image_times(), "time_ns": time}
        for k, axis in enumerate("xyz"):
            columns[axis] = states["position"][:, k]
        for k, axis in enumerate("xyzw"):
            columns[f"q{axis}"] = states["quaternion"][:, k]
        sigmas = numpy.sqrt(numpy.maximum(numpy.diagonal(states["pose_covariance"], axis1=1, axis2=2), 0))
        for k, axis in enumerate(("rx", "ry", "rz", "x", "y", "z")):
            columns[f"sigma_{axis}"] = sigmas[:, k]
        others = [name for name in states if name not in ("time", "position", "quaternion", "pose_covariance")]
        extra = others[:others.index("nis")]
        of_sigmas = [name for name in extra if name.startswith("sigma_")]
        for name in [name for name in extra if name not in of_sigmas] + of_sigmas + others[len(extra):]:
            columns[name] = states[name]
        return pandas.DataFrame(columns)

    def _image_times(self) -> Any:
        """The times of the estimates on the cameras' clock: those of the frames where they are known."""
        time = self.states["time"]
        offset = self.states.get("time_offset")
        shifted = time if offset is None else time - numpy.rint(numpy.asarray(offset) * _NS).astype(numpy.int64)
        frames = self._core._frame_times
        return frames[_nearest(frames, shifted)] if len(frames) else shifted

    def _frames(self, pandas: Any) -> Any:
        frames = self._core._frame_times
        if not len(frames):
            return pandas.array([pandas.NA] * len(self.states["time"]), dtype="Int64")
        return pandas.array(numpy.searchsorted(frames, self._image_times()), dtype="Int64")

    def evaluate(self, truth: Mapping[str, Any] | None = None, *,
                 truth_errors: Literal["auto", "none"] = "none") -> dict[str, Any]:
        """The errors against a truth (that of the recording, if none is given): `chasles.evaluate(run, truth)`."""
        from ._functions import evaluate

        return evaluate(self, self.truth if truth is None else truth, truth_errors=truth_errors)

    def errors(self, truth: Optional[Mapping[str, Any]] = None) -> dict[str, Any]:
        """The errors of the estimates for which there is a truth, frame by frame (N of them), as the page shows them:

        `state` (N,): the row of `states`; `time` (N,) int64 [ns]; `position`, `quaternion`: the estimate;
        `truth_position` (N, 3), `truth_quaternion` (N, 4): the truth in the world of the estimate, aligned by the first
        pose (with an IMU by its position and heading);
        `position_error` (N, 3) [m], `attitude_error` (N, 3) [rad]: truth minus estimate in world axes, R = Exp(theta)
        R_hat, p = p_hat + dp; `position_sigma`, `attitude_sigma` (N, 3): their standard deviations, so that the bounds are
        +-3 sigma;
        `nees_pose` (6 for a consistent filter), `nees_position` (3), `nees_attitude` (3): (N,), in the coordinates of the
        run's chart, NaN where a covariance is singular, as at a first frame whose position and heading define the world: use
        numpy.nanmean; attitudes and `nees_pose` are NaN for a truth of positions alone;
        `world_T_truth` (4, 4): the alignment; `world_T_truth_fit`: that of the ATE, the best rigid fit.

        truth: another one, columns as `truth` has them. Raises UsageError without a truth, InputError where too little of
        it is of the time of the run."""
        nothing = {"time": numpy.zeros(0, numpy.int64), "position": numpy.zeros((0, 3))}
        columns = nothing if truth is None else path_of(truth, "truth", "position")
        attitudes = "quaternion" in (self.truth if truth is None else columns)
        time, position, quaternion = arrays_of(columns, "truth")
        return _core.errors(self._core, time, position, quaternion, self._summary.get("chart", "standard"), attitudes)

    def plot(self, truth: Optional[Mapping[str, Any]] = None) -> Any:
        """A matplotlib Figure: the path from above, with the truth aligned, and the errors with their bounds of 3 sigma;
        without a truth the sigmas alone. Raises ImportError without matplotlib."""
        from ._plot import plot

        return plot(self, truth)

    def save(self, folder: _core.Path) -> None:
        """Writes the run folder that `chasles run -o` writes, without timings."""
        self._core.save(os.fspath(folder))

    def page(self) -> str:
        """The HTML page of the run, self-contained, as text."""
        return self._core.page()

    def _repr_html_(self) -> str:
        from ._picture import picture

        return picture(self)

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError("Run: cannot be pickled or copied; expected its folder: run.save(folder) there, and "
                        "chasles.read_run(folder) here")

    def __repr__(self) -> str:
        ate = self._summary.get("ate_m")
        error = "" if ate is None else f", ATE {ate:.3f} m"
        return f"<chasles.Run '{self.name}': {len(self.states['time'])} estimates{error}>"


def _nearest(sorted_times: Any, times: Any) -> Any:
    """For each time the index of the nearest one."""
    after = numpy.clip(numpy.searchsorted(sorted_times, times), 1, max(1, len(sorted_times) - 1))
    after = numpy.minimum(after, len(sorted_times) - 1)
    before = numpy.maximum(after - 1, 0)
    return numpy.where(times - sorted_times[before] <= sorted_times[after] - times, before, after)
