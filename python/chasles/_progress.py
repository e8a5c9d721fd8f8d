"""Progress bars of long calls, by tqdm where it is installed."""

from __future__ import annotations

import contextlib
import sys
from typing import Any, Callable, Iterator, Optional

Advance = Callable[[int, int], None]
_POLLS = 6  # there are 20 in a second


def _in_notebook() -> bool:
    get_ipython = getattr(sys.modules.get("IPython"), "get_ipython", None)
    return get_ipython is not None and type(get_ipython()).__name__ == "ZMQInteractiveShell"


def _bar_class() -> Any:
    """tqdm's own choice between a widget and text; text where the notebook has no widgets, as tqdm would warn."""
    try:
        import tqdm.std
    except ImportError:
        return None
    if _in_notebook():
        try:
            import ipywidgets  # noqa: F401
        except ImportError:
            return tqdm.std.tqdm
    import tqdm.auto

    return tqdm.auto.tqdm


@contextlib.contextmanager
def bar(wanted: Optional[bool], what: str, unit: str, last: str = "") -> Iterator[Optional[Advance]]:
    """A function advance(done, total) that draws the bar, or None for no bar. wanted: True, False, or None: on a
    terminal and in a notebook. last: what goes on after the last unit. Raises ImportError where it is wanted and tqdm is
    not installed."""
    visible = wanted if wanted is not None else (_in_notebook() or sys.stderr.isatty())
    tqdm = _bar_class() if visible else None
    if tqdm is None:
        if wanted:
            raise ImportError("progress: found no package tqdm; expected it for a progress bar: pip install tqdm", name="tqdm")
        yield None
        return
    # A call that ends soon draws nothing.
    with tqdm(desc=what, unit=f" {unit}", leave=False, delay=0 if wanted else 0.5) as drawn:
        polls = 0  # since the last unit

        def advance(done: int, total: int) -> None:
            nonlocal polls
            if total and drawn.total != total:
                if drawn.total:  # of another part of the call
                    drawn.reset(total)
                drawn.total = total
            drawn.update(max(0, done - drawn.n))
            polls = polls + 1 if total and done >= total else 0
            if last and polls == _POLLS:
                drawn.set_postfix_str(last)

        yield advance
