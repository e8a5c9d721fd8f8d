"""Packages that only some functions need."""

from __future__ import annotations

import importlib
from typing import Any


def optional(name: str, package: str) -> Any:
    """The module of that name. Raises ImportError that says how to install its package."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        if error.name is None or error.name.partition(".")[0] != name.partition(".")[0]:
            raise
        raise ImportError(
            f"{name}: found no such package; expected it for this function: pip install {package}",
            name=error.name) from error
