"""Objects that cannot be pickled or copied say what to do instead."""

from __future__ import annotations

from typing import Any

from . import _core


def _reject(one: type, instead: str) -> None:
    def __reduce_ex__(self: Any, protocol: Any) -> Any:
        raise TypeError(f"{one.__name__}: cannot be pickled or copied; expected {instead}")

    setattr(one, "__reduce_ex__", __reduce_ex__)


_reject(_core.Recording, "its path, which another process reads by chasles.read(path), or its arrays")
_reject(_core.Slam, "one of its own in each process")
_reject(_core.RealtimeSlam, "one of its own in each process")
_reject(_core.Estimate, "its arrays, such as estimate.world_T_imu")
_reject(_core.PredictedState, "its arrays, such as world_T_imu")
_reject(_core.Run, "its folder: run.save(folder) there, and chasles.read_run(folder) here")
