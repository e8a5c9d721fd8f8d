"""Names of arguments that do not exist."""

from __future__ import annotations

import difflib
import functools
import inspect
from typing import Any, Callable, TypeVar

from . import _core

F = TypeVar("F", bound=Callable[..., Any])


def suggests_arguments(function: F) -> F:
    """For a function without settings: an argument that it does not have is a UsageError with the nearest one."""
    parameters = inspect.signature(function).parameters
    names = [name for name, one in parameters.items() if one.kind is not one.POSITIONAL_ONLY]

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name in kwargs:
            if name not in parameters:
                raise _core.UsageError(f"{function.__name__}: unknown argument '{name}'{nearest(name, names)}; expected "
                                       f"{', '.join(names)}")
        return function(*args, **kwargs)

    return checked  # type: ignore[return-value]


def nearest(name: str, known: list[str]) -> str:
    found = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f"; did you mean '{found[0]}'?" if found else ""
