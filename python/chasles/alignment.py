"""The transformation between the worlds of an estimate and of its truth (docs/evaluation.md, section 2)."""

from typing import Any, Dict

from . import _core
from ._columns import arrays_of, path_of

__all__ = ["align"]


def align(estimate: Any, truth: Any, alignment: str = "SE(3)") -> Dict[str, Any]:
    """Aligns an estimate with the truth, both a Run or columns as `chasles.evaluate` takes them. Returns a dictionary:
    `truth_T_estimate` (4, 4) and `scale` with p_truth = scale * R * p_estimate + p, `rank` (2: the positions determine
    the rotation), `matched`, and the errors after the alignment, `ate_m` and `attitude_deg` (root mean squares).

    alignment: "SE(3)", "Sim(3)", "position + yaw", "first pose", "first position + yaw" or "none". Raises UsageError for
    another, InputError for fewer than three pairs."""
    estimate, truth = path_of(estimate, "estimate", "position"), path_of(truth, "truth", "position")
    return _core.align(*arrays_of(estimate, "estimate"), *arrays_of(truth, "truth"), alignment)
