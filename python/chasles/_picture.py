"""What a notebook shows of a run: a few figures, and a drawing as SVG, which needs no other package."""

from __future__ import annotations

import html
from typing import Any

import numpy

from . import _core

_ESTIMATE, _TRUTH = "#0068bd", "#8a8f98"
_MOST_POINTS = 500
_AXES = ("#c0392b", "#2e8b57", "#0068bd")


def picture(run: Any) -> str:
    """A table of figures beside the path from above and the errors of the position with their bounds of 3 sigma."""
    errors = _errors_of(run)
    drawings = [_path(run, errors)] + ([_errors(errors)] if errors is not None else [])
    rows = "".join(f"<tr><td style='text-align:left'>{name}</td><td>{value}</td></tr>" for name, value in _figures(run))
    return (f"<div style='display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start'><table>"
            f"<caption>{html.escape(run.name)}</caption>{rows}</table>{''.join(drawings)}</div>"
            "<small>run.show('run.html') writes the whole page; run.plot() draws with matplotlib</small>")


def _errors_of(run: Any) -> Any:
    if not run.has_truth:
        return None
    try:
        return run.errors()
    except _core.Error:  # the truth is of another time: the estimate is still shown
        return None


def _figures(run: Any) -> list[tuple[str, str]]:
    summary = run.summary
    time = run.states["time"]
    rows = [("estimates", str(len(time))), ("duration", f"{1e-9 * (time[-1] - time[0]):.1f} s" if len(time) else "0 s"),
            ("landmarks", str(len(run.landmarks["id"])))]
    heading = summary.get("attitude_posyaw_deg") is not None and run._core._level
    attitude = (("attitude_posyaw_deg", "attitude, aligned by yaw", "°") if heading else
                ("attitude_deg", "attitude, SE(3)-aligned", "°"))
    for name, label, unit in (("ate_m", "ATE, SE(3)-aligned", " m"), attitude, ("nees_pose", "NEES (consistent: 6)", "")):
        if summary.get(name) is not None:
            rows.append((label, f"{summary[name]:.3g}{unit}"))
    rows.append(("health", html.escape(str(summary.get("health", "unknown")))))
    return rows


def _thin(*columns: Any) -> list[Any]:
    step = max(1, -(-len(columns[0]) // _MOST_POINTS))
    return [numpy.asarray(column)[::step] for column in columns]


def _line(x: Any, y: Any, colour: str, dash: str = "") -> str:
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y) if numpy.isfinite(a) and numpy.isfinite(b))
    return f"<polyline points='{points}' fill='none' stroke='{colour}' stroke-width='1.2' stroke-dasharray='{dash}'/>"


def _svg(width: int, height: int, title: str, content: str) -> str:
    return (f"<svg width='{width}' height='{height}' viewBox='0 0 {width} {height}' role='img' "
            f"style='background:#fff' font-family='sans-serif' font-size='11'>"
            f"<text x='6' y='14' fill='#444'>{title}</text>{content}</svg>")


def _path(run: Any, errors: Any) -> str:
    """From above, x to the right and y up, at one scale."""
    width, height, edge = 300, 260, 24
    paths = [(run.states["position"], _ESTIMATE)]
    if errors is not None:
        paths.insert(0, (errors["truth_position"], _TRUTH))
    everything = numpy.concatenate([path[:, :2] for path, _ in paths])
    everything = everything[numpy.isfinite(everything).all(1)]
    if not len(everything):
        return _svg(width, height, "no position", "")
    low, high = everything.min(0), everything.max(0)
    scale = min((width - 2 * edge) / max(high[0] - low[0], 1e-3), (height - 2 * edge) / max(high[1] - low[1], 1e-3))
    lines = ""
    for path, colour in paths:
        x, y = _thin(path[:, 0], path[:, 1])
        lines += _line(edge + scale * (x - low[0]), height - edge - scale * (y - low[1]), colour)
    truth = f" <tspan fill='{_TRUTH}'>truth</tspan>," if errors is not None else ""
    size = f"{high[0] - low[0]:.3g} m x {high[1] - low[1]:.3g} m"
    return _svg(width, height, f"from above, {size}:{truth} <tspan fill='{_ESTIMATE}'>estimate</tspan>", lines)


def _errors(errors: Any) -> str:
    width, height, edge = 380, 260, 24
    time, error, sigma = _thin(errors["time"], errors["position_error"], errors["position_sigma"])
    bound = max(float(numpy.nanmax(numpy.abs(error), initial=0)), float(numpy.nanmax(3 * sigma, initial=0)), 1e-9)
    x = edge + (width - 2 * edge) * (time - time[0]) / max(int(time[-1] - time[0]), 1)

    def at(value: Any) -> Any:
        return height / 2 - (height / 2 - edge) * value / bound

    lines = _line([edge, width - edge], [height / 2, height / 2], "#ccc")
    for k, colour in enumerate(_AXES):
        lines += _line(x, at(error[:, k]), colour) + _line(x, at(3 * sigma[:, k]), colour, "2 3")
        lines += _line(x, at(-3 * sigma[:, k]), colour, "2 3")
    axes = " ".join(f"<tspan fill='{colour}'>{name}</tspan>" for name, colour in zip("xyz", _AXES))
    return _svg(width, height, f"position error {axes}, dotted +-3 sigma; the height is +-{bound:.2g} m", lines)
