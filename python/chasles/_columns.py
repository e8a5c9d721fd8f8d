"""Paths as columns."""

from ._core import UsageError


def path_of(path, name, *needed):
    """The columns of a path: those of a Run's states, or the dictionary itself. Raises UsageError where `time` or a
    needed column is missing."""
    columns = path.states if hasattr(path, "states") else path
    missing = [column for column in ("time", *needed) if column not in columns]
    if missing:
        raise UsageError(f"{name}: found columns {', '.join(columns) or 'none'}; expected a Run, or columns with "
                         f"{', '.join(('time', *needed))}: {', '.join(missing)} is missing")
    return columns
