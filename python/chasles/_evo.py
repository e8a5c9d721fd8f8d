"""Trajectories to and from evo."""

from typing import Any, Dict

import numpy as np

from ._columns import path_of
from ._optional import optional

_NANOSECONDS = 1_000_000_000


def to_evo(path: Any, *, frame: str = "world") -> Any:
    """A path as evo's PoseTrajectory3D: of a Run (its states), or columns `time` [ns], `position` (N, 3) and `quaternion`
    (N, 4) x y z w, such as Run.smoothed, Run.truth or Recording.truth. frame: the name of its world in evo's metadata.

    evo's time stamps are float seconds, which round stamps since 1970 to 0.12 us. Raises UsageError for a missing
    column, ImportError without evo."""
    columns = path_of(path, "to_evo", "position", "quaternion")
    trajectory = optional("evo.core.trajectory", "evo")
    time = np.asarray(columns["time"])
    # In two parts: a double has no nanoseconds since 1970, and the sum is rounded once.
    seconds = time // _NANOSECONDS + time % _NANOSECONDS / _NANOSECONDS
    quaternion = np.asarray(columns["quaternion"], dtype=float).reshape(-1, 4)
    return trajectory.PoseTrajectory3D(np.asarray(columns["position"], dtype=float).reshape(-1, 3),
                                       quaternion[:, [3, 0, 1, 2]], seconds, meta={"frame_id": frame})


def from_evo(trajectory: Any) -> Dict[str, Any]:
    """The columns of evo's PoseTrajectory3D, as `chasles.evaluate` takes them: `time` int64 [ns], `position` (N, 3),
    `quaternion` (N, 4) x y z w. Raises TypeError for a path without time stamps."""
    if not hasattr(trajectory, "timestamps"):
        raise TypeError(f"from_evo: found {type(trajectory).__name__}, expected evo's PoseTrajectory3D with time stamps")
    wxyz = np.asarray(trajectory.orientations_quat_wxyz, dtype=float).reshape(-1, 4)
    seconds = np.asarray(trajectory.timestamps, dtype=float)
    whole = np.floor(seconds)
    time = whole.astype(np.int64) * _NANOSECONDS + np.rint((seconds - whole) * _NANOSECONDS).astype(np.int64)
    return {"time": time, "position": np.array(trajectory.positions_xyz, dtype=float).reshape(-1, 3),
            "quaternion": wxyz[:, [1, 2, 3, 0]]}
