"""The noise of an IMU, measured from its samples."""

from __future__ import annotations

import copy
import html
import json
import os
import pathlib
from typing import Any, Mapping, Optional, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._arguments import suggests_arguments


class NoiseCalibration:
    """Noise densities, bias instabilities and random walks of an IMU, with sigmas or limits. `print(calibration)` is the
    table of `chasles calibrate noise`."""

    def __init__(self, report: str, text: str, yaml: str, table: str,
                 allan: dict[str, dict[str, NDArray[numpy.float64]]]) -> None:
        self._json = report
        self._text = text
        self._yaml = yaml
        self._table = table
        self._allan = allan
        self._report: dict[str, Any] = json.loads(report)

    @property
    def report(self) -> dict[str, Any]:
        """What `chasles calibrate noise --json` prints, as a dictionary of the caller's own."""
        return copy.deepcopy(self._report)

    @property
    def allan(self) -> dict[str, dict[str, NDArray[numpy.float64]]]:
        """{"accelerometer_x": {"tau" [s], "deviation", "low", "high", "fit", "dof", "differences"}, ...}: overlapping
        Allan deviations in m/s^2 and rad/s, with 95 % intervals, and those of the fit. Empty without a standstill."""
        return copy.deepcopy(self._allan)

    @property
    def imu_noise(self) -> Optional[_core.ImuNoise]:
        """As Recording.from_arrays and Slam take it: root mean squares of the axes. A walk that is not shown has its
        limit. None from a motion alone, which shows no walk."""
        values = {}
        for sensor in ("accelerometer", "gyroscope"):
            for key in ("noise_density", "random_walk"):
                if self._report[sensor][key] is None:
                    return None
                values[f"{sensor}_{key}"] = self._report[sensor][key]["value"]
        return _core.ImuNoise(**values)

    @property
    def remarks(self) -> list[str]:
        """Sentences on what limits the result."""
        return list(self._report["remarks"])

    def save(self, folder: Union[str, os.PathLike[str]]) -> None:
        """Writes noise.json, imu.yaml (of Kalibr and of recordings) and allan.csv."""
        path = pathlib.Path(folder)
        path.mkdir(parents=True, exist_ok=True)
        (path / "noise.json").write_text(json.dumps(self._report, indent=2) + "\n", encoding="utf-8")
        (path / "imu.yaml").write_text(self._yaml, encoding="utf-8")
        (path / "allan.csv").write_text(self._table, encoding="utf-8")

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<chasles.NoiseCalibration of '{self._report['recording']}'>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self._text)}</pre>"


@suggests_arguments
def calibrate_noise(recording: Union[_core.Recording, _core.Path, Mapping[str, Any]], *, start: Optional[float] = None,
                    stop: Optional[float] = None, standstill: bool = False) -> NoiseCalibration:
    """Measures the noise of an IMU, as `chasles calibrate noise` does (docs/calibration.md), and returns a
    NoiseCalibration. recording: a Recording, the path of one or of a table of samples, or a dictionary with the arrays
    `time`, `specific_force` and `angular_rate`, as `recording.imu` and `join_imu` have it. start, stop: seconds since the
    first event. standstill: all of it is one, also where the samples scatter as in a motion. InputError where the samples
    show no noise."""
    if isinstance(recording, Mapping):
        missing = [name for name in ("time", "specific_force", "angular_rate") if name not in recording]
        if missing:
            raise _core.UsageError(f"calibrate_noise: the dictionary has no '{missing[0]}', expected time, specific_force "
                                   "and angular_rate")
        samples = _core.recording_of_imu(numpy.asarray(recording["time"]), recording["specific_force"],
                                         recording["angular_rate"])
    elif isinstance(recording, _core.Recording):
        samples = recording
    else:
        samples = _core.read_for_imu(os.fspath(recording))
    return NoiseCalibration(*_core.calibrate_noise(samples, start, stop, standstill))
