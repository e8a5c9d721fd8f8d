"""The plots of a run, by matplotlib."""

from __future__ import annotations

from typing import Any, Mapping, Optional

import numpy

from ._optional import optional

_ESTIMATE, _TRUTH = "#0068bd", "#8a8f98"
_AXES = (("x", "#c0392b"), ("y", "#2e8b57"), ("z", "#0068bd"))


def plot(run: Any, truth: Optional[Mapping[str, Any]] = None) -> Any:
    """As Run.plot()."""
    # A figure of its own, without pyplot: nothing keeps it, and no window opens. A notebook shows what a cell returns.
    figure_module = optional("matplotlib.figure", "matplotlib")
    figure = figure_module.Figure(figsize=(11, 5), layout="constrained")
    known = truth is not None or run.has_truth
    errors = run.errors(truth) if known else None
    grid = figure.add_gridspec(3 if known else 2, 2)
    _path(figure.add_subplot(grid[:, 0]), run, errors)
    if errors is not None:
        seconds = 1e-9 * (errors["time"] - errors["time"][0])
        _errors(figure.add_subplot(grid[0, 1]), seconds, errors["position_error"], errors["position_sigma"],
                "position error [m]")
        _errors(figure.add_subplot(grid[1, 1]), seconds, numpy.degrees(errors["attitude_error"]),
                numpy.degrees(errors["attitude_sigma"]), "attitude error [deg]")
        _nees(figure.add_subplot(grid[2, 1]), seconds, errors["nees_pose"])
    else:
        _sigmas(figure, grid, run)
    figure.suptitle(repr(run)[1:-1])
    return figure


def _path(axes: Any, run: Any, errors: Any) -> None:
    if errors is not None:
        axes.plot(*errors["truth_position"][:, :2].T, color=_TRUTH, label="truth, aligned")
    axes.plot(*run.states["position"][:, :2].T, color=_ESTIMATE, label="estimate")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.legend(loc="best")


def _errors(axes: Any, seconds: Any, error: Any, sigma: Any, label: str) -> None:
    for k, (name, colour) in enumerate(_AXES):
        axes.plot(seconds, error[:, k], color=colour, linewidth=1, label=name)
        for sign in (-3, 3):
            axes.plot(seconds, sign * sigma[:, k], color=colour, linewidth=0.7, linestyle=":")
    axes.set(ylabel=label)
    axes.legend(loc="upper left", ncols=3, fontsize="small", title="dotted: +-3 sigma", title_fontsize="small",
                framealpha=0.6)


def _nees(axes: Any, seconds: Any, nees: Any) -> None:
    axes.plot(seconds, nees, color=_ESTIMATE, linewidth=1)
    axes.axhline(6, color=_TRUTH, linewidth=1)
    axes.set(xlabel="time since the first estimate [s]", ylabel="NEES of the pose\n(consistent: 6)", yscale="log")


def _sigmas(figure: Any, grid: Any, run: Any) -> None:
    time, covariance = run.states["time"], run.states["pose_covariance"]
    seconds = 1e-9 * (time - time[0]) if len(time) else time
    sigma = numpy.sqrt(numpy.maximum(numpy.diagonal(covariance, axis1=1, axis2=2), 0))
    for row, (part, label) in enumerate(((sigma[:, 3:], "sigma of the position [m]"),
                                         (numpy.degrees(sigma[:, :3]), "sigma of the attitude [deg]"))):
        axes = figure.add_subplot(grid[row, 1])
        for k, (name, colour) in enumerate(_AXES):
            axes.plot(seconds, part[:, k], color=colour, linewidth=1, label=name)
        axes.set(xlabel="time since the first estimate [s]", ylabel=label)
        axes.legend(loc="upper left", ncols=3, fontsize="small")
