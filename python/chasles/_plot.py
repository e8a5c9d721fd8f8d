"""The plots of a run, by matplotlib."""

from __future__ import annotations

from typing import Any, Callable, List, Mapping, Optional

import numpy

from . import _core
from ._optional import optional

_ESTIMATE, _TRUTH = "#0068bd", "#8a8f98"
_AXES = (("x", "#c0392b"), ("y", "#2e8b57"), ("z", "#0068bd"))
_TIME = "time since the first estimate [s]"


def plot(run: Any, truth: Optional[Mapping[str, Any]] = None) -> Any:
    """As Run.plot()."""
    # A figure of its own, without pyplot: nothing keeps it, and no window opens. A notebook shows what a cell returns.
    figure_module = optional("matplotlib.figure", "matplotlib")
    errors, missing = _errors_of(run, truth)
    panels = _panels(run, errors)
    figure = figure_module.Figure(figsize=(11, 2.6 + 1.4 * max(2, len(panels))), layout="constrained")
    grid = figure.add_gridspec(max(1, len(panels)), 2)
    _path(figure.add_subplot(grid[:, 0]), run, errors)
    first: Any = None
    for row, draw in enumerate(panels):
        axes = figure.add_subplot(grid[row, 1], sharex=first)
        first = first or axes
        draw(axes)
        if row == len(panels) - 1:
            axes.set(xlabel=_TIME)
        else:
            axes.tick_params(labelbottom=False)
    figure.suptitle(repr(run)[1:-1] + (f"\n{missing}" if missing else ""), fontsize="medium", wrap=True)
    return figure


def _errors_of(run: Any, truth: Any) -> tuple[Any, str]:
    """The errors, or none and why: a truth of another time does not hide the estimate."""
    if truth is None and not run.has_truth:
        return None, ""
    try:
        return run.errors(truth), ""
    except _core.InputError as error:
        if truth is not None:
            raise
        return None, str(error).partition(";")[0]


def _panels(run: Any, errors: Any) -> List[Callable[[Any], None]]:
    """What is drawn against time: of a truth of positions alone no attitudes."""
    if errors is None:
        return _sigmas(run)
    time = errors["time"]
    seconds = 1e-9 * (time - time[0])
    panels: List[Callable[[Any], None]] = [
        lambda axes: _errors(axes, seconds, errors["position_error"], errors["position_sigma"], "position error [m]")]
    if numpy.isfinite(errors["attitude_error"]).any():
        panels.append(lambda axes: _errors(axes, seconds, numpy.degrees(errors["attitude_error"]),
                                           numpy.degrees(errors["attitude_sigma"]), "attitude error [deg]"))
    for name, label, freedom in (("nees_pose", "pose", 6), ("nees_position", "position", 3)):
        if numpy.isfinite(errors[name]).any():
            values = errors[name]
            panels.append(lambda axes: _nees(axes, seconds, values, label, freedom))
            break
    return panels


def _path(axes: Any, run: Any, errors: Any) -> None:
    if errors is not None:
        axes.plot(*errors["truth_position"][:, :2].T, color=_TRUTH, label="truth, aligned")
    axes.plot(*run.states["position"][:, :2].T, color=_ESTIMATE, label="estimate")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    _legend(axes, ncols=2)


def _legend(axes: Any, **options: Any) -> None:
    """Above the axes, where it covers no curve."""
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0.1, frameon=False, fontsize="small", **options)


def _errors(axes: Any, seconds: Any, error: Any, sigma: Any, label: str) -> None:
    for k, (name, colour) in enumerate(_AXES):
        axes.plot(seconds, error[:, k], color=colour, linewidth=1, label=name)
        for sign in (-3, 3):
            bound = "+-3 sigma" if k == len(_AXES) - 1 and sign > 0 else None
            axes.plot(seconds, sign * sigma[:, k], color=colour, linewidth=0.7, linestyle=":", label=bound)
    axes.set(ylabel=label)
    _legend(axes, ncols=4)


def _nees(axes: Any, seconds: Any, nees: Any, of: str, freedom: int) -> None:
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator

    axes.plot(seconds, nees, color=_ESTIMATE, linewidth=1, label=f"NEES of the {of}")
    axes.axhline(freedom, color=_TRUTH, linewidth=1, label=f"consistent: {freedom}")
    axes.set(ylabel="NEES", yscale="log")
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_major_formatter(LogFormatterSciNotation())
    axes.minorticks_off()
    _legend(axes, ncols=2)


def _sigmas(run: Any) -> List[Callable[[Any], None]]:
    time, covariance = run.states["time"], run.states["pose_covariance"]
    seconds = 1e-9 * (time - time[0]) if len(time) else time
    sigma = numpy.sqrt(numpy.maximum(numpy.diagonal(covariance, axis1=1, axis2=2), 0))

    def drawn(part: Any, label: str) -> Callable[[Any], None]:
        def draw(axes: Any) -> None:
            for k, (name, colour) in enumerate(_AXES):
                axes.plot(seconds, part[:, k], color=colour, linewidth=1, label=name)
            axes.set(ylabel=label)
            _legend(axes, ncols=3)

        return draw

    return [drawn(sigma[:, 3:], "position sigma [m]"),
            drawn(numpy.degrees(sigma[:, :3]), "attitude sigma [deg]")]
