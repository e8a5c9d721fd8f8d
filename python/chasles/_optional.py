"""Packages that only some functions need."""

import importlib


def optional(name, extra):
    """The module of that name. Raises ImportError that says how to install it."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        if error.name is None or error.name.partition(".")[0] != name.partition(".")[0]:
            raise
        raise ImportError(
            f"{name}: found no such package; expected it for this function: pip install chasles[{extra}]",
            name=error.name) from error
