"""The compiled laboratory: simulation, studies and the command. Runs of recordings do without it."""

from __future__ import annotations

import types

from ._one_line import wrap


def laboratory() -> types.ModuleType:
    """The module _lab, which is loaded where it is first needed."""
    from . import _lab

    wrap(_lab)
    return _lab
