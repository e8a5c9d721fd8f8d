"""Paths as columns."""

from __future__ import annotations

import os
from typing import Any, Mapping, Tuple

import numpy

from ._core import InputError, Recording, UsageError
from ._one_line import found

NO_ATTITUDE: list[list[float]] = [[]]


def path_of(path: Any, name: str, *needed: str) -> Mapping[str, Any]:
    """The columns of a path: those of a Run's states, of a Recording's truth, or the dictionary itself. Raises
    UsageError where it is none of them, and where `time` or a needed column is missing."""
    if isinstance(path, Recording):
        columns: Any = path.truth
    else:
        columns = path.states if hasattr(path, "states") else path
    wanted = ", ".join(("time", *needed))
    if not isinstance(columns, Mapping):
        kind = "a DataFrame" if hasattr(columns, "to_records") else found(columns)
        raise UsageError(f"{name}: found {kind}; expected a Run, or a dictionary of columns {wanted}")
    missing = [column for column in ("time", *needed) if column not in columns]
    if missing:
        raise UsageError(f"{name}: found columns {', '.join(map(str, columns)) or 'none'}; expected a Run, or columns with "
                         f"{wanted}: {', '.join(missing)} is missing")
    return columns


def arrays_of(columns: Mapping[str, Any], name: str) -> Tuple[Any, Any, Any]:
    """Time, position and quaternion, the last one (1, 0) where unknown. Raises InputError for what are no numbers."""
    return (numpy.asarray(columns["time"]), _numbers(columns["position"], f"{name}: position"),
            _numbers(columns.get("quaternion", NO_ATTITUDE), f"{name}: quaternion"))


def _numbers(values: Any, name: str) -> Any:
    try:
        array = numpy.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: found {found(values)}, expected numbers, a row for each time") from None
    if array.ndim != 2:
        raise InputError(f"{name}: found {found(array)}, expected two dimensions, a row for each time")
    return array


def is_path(one: Any) -> bool:
    """Of a file."""
    return isinstance(one, (str, os.PathLike))
