"""The laboratory: ideas written in Python that run in the filter, and studies that compare them.

    class Body:                                            # an error chart in twenty lines
        def retract(self, x, xi, dpoints): ...
        def local(self, x, y): ...
        def motion_block(self, x): ...

    chasles.register_chart("body", Body())
    study = chasles.monte_carlo("hallway", {"body": {"chart": "body"}, "ours": {}}, runs=10)
    print(study.table)
"""

from __future__ import annotations

import copy
import html
import os
from typing import TYPE_CHECKING, Any, Callable, Mapping

from . import _core
from ._laboratory import laboratory
from ._optional import optional
from ._page import Page
from ._core import ChartState, FirstSight, register_chart as _register_chart
from ._core import register_depth_rule as _register_depth_rule

if TYPE_CHECKING:
    from ._run import Run

__all__ = ["ChartState", "Comparison", "FirstSight", "Study", "register_chart", "register_depth_rule"]


def register_chart(name: str, chart: Any) -> None:
    """Makes an error chart that is written in Python known to the setting `chart`, in this process.

    chart has the methods

        retract(x, xi, dpoints) -> ChartState     the state x moved by an error
        local(x, y) -> (xi, dpoints)              the error that leads from x to y
        motion_block(x) -> (9, 9)                 T's block for [rotation, position, velocity]
        landmark_block(p_world) -> (3, 3)         T's block for (landmark, rotation); optional

    where x, y are ChartState (R, p, v, points), xi is (9,) of [theta, dp, dv] and dpoints (N, 3). T is the derivative
    of local(x, .) by the reference errors (R = Exp(theta) R_hat, the rest additive); docs/charts.md has the theory.
    Biases and landmarks in inverse depth are not part of it. The filter calls the methods also for single past poses,
    with v = 0 and no points.

    The invariants of a chart are checked at random states first. UsageError says which one does not hold."""
    _register_chart(name, chart)


def register_depth_rule(name: str, rule: Callable[[FirstSight], tuple[float, float] | None]) -> None:
    """Makes a rule for the depth of undelayed landmarks known to the setting `depth_rule`, in this process.

    rule(sight) takes a FirstSight (pixel, ray, camera, world_T_camera, points, inverse) and returns (mean, sigma) of
    the depth along the camera's z axis [m], or of the inverse depth [1/m] where sight.inverse, or None for no landmark
    now. It holds for init="fixed-depth", and where the state has fewer than min_landmarks."""
    _register_depth_rule(name, rule)


class Study(Page):
    """The same runs of a scene through several filters."""

    def __init__(self, folder: str, summary: dict[str, Any]) -> None:
        self.folder = folder
        self._temporary: Any = None  # a folder that lives as long as this
        self.table: str = summary.pop("table")
        """The tables of NEES and errors, as text."""
        self._summary = summary

    @property
    def summary(self) -> dict[str, Any]:
        """summary.json of the study as a dictionary of the caller's own; `filters` has the figures of each filter."""
        return copy.deepcopy(self._summary)

    @property
    def figures(self) -> dict[str, dict[str, Any]]:
        """{filter: figures}: nees_pose_per_dof, position_error_m, ate_posyaw_m, band, diverged, ..."""
        return {one["filter"]: one for one in self.summary["filters"]}

    def curves(self, name: str) -> dict[str, Any]:
        """The means over all runs for each second of this filter, {column: (N,)}: position_error_m, nees_pose, ..."""
        import numpy

        rows: Any = numpy.genfromtxt(os.path.join(self.folder, "curves.csv"), delimiter=",", names=True, dtype=None,
                                     encoding="utf-8")
        rows = rows[rows["filter"] == name]
        if not len(rows):
            raise _core.UsageError(f"curves: no filter '{name}'; there are {', '.join(self.figures)}")
        return {column: rows[column] for column in rows.dtype.names if column != "filter"}

    def to_dataframe(self) -> Any:
        """The figures as a pandas DataFrame, a row for each filter."""
        return optional("pandas", "pandas").DataFrame(self.summary["filters"]).set_index("filter")

    def page(self) -> str:
        """The HTML page of the study, as text."""
        text: str = laboratory().study_page(self.folder)
        return text

    def __repr__(self) -> str:
        return f"<chasles.Study of {self.summary['runs']} runs: {', '.join(self.figures)}>"

    def __str__(self) -> str:
        return self.table


class Comparison(Page):
    """One recording through several estimators."""

    def __init__(self, runs: dict[str, Run]) -> None:
        self.runs = runs
        """{name: Run}"""

    _COLUMNS = ("ate_m", "ate_posyaw_m", "nees_pose", "nees_position", "nees_attitude")

    @property
    def figures(self) -> dict[str, dict[str, Any]]:
        """{name: summary}, as Run.summary."""
        return {name: run.summary for name, run in self.runs.items()}

    def to_dataframe(self) -> Any:
        """The figures against the truth as a pandas DataFrame, a row for each estimator."""
        pandas = optional("pandas", "pandas")
        rows = {name: {column: summary.get(column) for column in self._COLUMNS}
                for name, summary in self.figures.items()}
        return pandas.DataFrame.from_dict(rows, orient="index")

    def page(self) -> str:
        """The HTML page with all runs, as text."""
        return _core.page([(name, run._core) for name, run in self.runs.items()])

    def _repr_html_(self) -> str:
        heads = "".join(f"<th>{column}</th>" for column in self._COLUMNS)
        rows = ""
        for name, summary in self.figures.items():
            values = (summary.get(column) for column in self._COLUMNS)
            cells = "".join(f"<td>{'' if value is None else f'{value:.3g}'}</td>" for value in values)
            rows += f"<tr><td style='text-align:left'>{html.escape(name)}</td>{cells}</tr>"
        return (f"<table><tr><th></th>{heads}</tr>{rows}</table>"
                "<small>comparison.show('compared.html') writes the page with all runs</small>")

    def __repr__(self) -> str:
        return f"<chasles.Comparison of {', '.join(self.runs)}>"
