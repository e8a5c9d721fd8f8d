"""Objects that cannot be pickled or copied say what to do instead."""

from __future__ import annotations

from typing import Any

from . import _core


def _refuse(one: type, instead: str) -> None:
    def __reduce_ex__(self: Any, protocol: Any) -> Any:
        raise TypeError(f"{one.__name__}: cannot be pickled or copied; expected {instead}")

    setattr(one, "__reduce_ex__", __reduce_ex__)


_refuse(_core.Recording, "its path, which another process reads by chasles.read(path), or its arrays")
_refuse(_core.Slam, "one of its own in each process")
_refuse(_core.RealtimeSlam, "one of its own in each process")
_refuse(_core.Estimate, "its arrays, such as estimate.world_T_imu")
_refuse(_core.PredictedState, "its arrays, such as world_T_imu")
_refuse(_core.Run, "its folder: run.save(folder) there, and chasles.read_run(folder) here")
