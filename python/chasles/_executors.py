"""Tasks for any executor of concurrent.futures: this machine's processes, Dask, MPI, Ray."""

from __future__ import annotations

import concurrent.futures
import queue
from typing import Any, Callable, Iterable, Iterator

from . import _core

WINDOW = 2048  # tasks that are submitted and have not ended


class TaskResult:
    """What a task returned, and how often it was tried."""

    def __init__(self, item: Any, value: Any, attempts: int) -> None:
        self.item = item
        self.value = value
        self.attempts = attempts


def stream(executor: Any, function: Callable[[Any], Any], items: Iterable[Any], *, attempts: int = 3,
           window: int = WINDOW) -> Iterator[TaskResult]:
    """function(item) for each item in a worker of the executor; the results as they come, in any order. At most
    `window` tasks wait in the executor, so that neither it nor this process holds more. A task whose worker dies is
    submitted again, `attempts` times in all. Raises what the last of them raised; chasles.Error of a task at once; and
    InputError where the executor itself is broken, as a ProcessPoolExecutor is when one of its processes dies."""
    ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
    waiting: dict[Any, tuple[Any, int]] = {}
    rest = iter(items)

    def submit(item: Any, attempt: int) -> None:
        try:
            future = executor.submit(function, item)
        except concurrent.futures.BrokenExecutor as error:
            raise broken(error) from error
        waiting[future] = (item, attempt)
        future.add_done_callback(ended.put)

    def broken(error: BaseException) -> Exception:
        return _core.InputError(f"executor: it is broken ({error}); make a new one, and go on (a batch with resume=True)")

    try:
        for item in rest:
            submit(item, 1)
            if len(waiting) >= window:
                break
        while waiting:
            future = ended.get()
            item, attempt = waiting.pop(future)
            error = future.exception()
            if error is None:
                yield TaskResult(item, future.result(), attempt)
                following = next(rest, waiting)  # `waiting` is no item
                if following is not waiting:
                    submit(following, 1)
            elif isinstance(error, concurrent.futures.BrokenExecutor):
                raise broken(error) from error
            elif isinstance(error, _core.Error) or attempt >= attempts:
                raise error
            else:
                submit(item, attempt + 1)
    finally:
        for future in waiting:
            future.cancel()


class RayExecutor(concurrent.futures.Executor):
    """Tasks as those of Ray, which must be initialised: `chasles.batch(..., executor=RayExecutor())`. options: those
    of ray.remote, such as num_cpus=1."""

    def __init__(self, **options: Any) -> None:
        from ._optional import optional

        ray = optional("ray", "ray")
        self._call = ray.remote(**options)(_call) if options else ray.remote(_call)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "concurrent.futures.Future[Any]":
        future: concurrent.futures.Future[Any] = self._call.remote(fn, args, kwargs).future()
        return future


def _call(function: Callable[..., Any], args: Any, kwargs: Any) -> Any:
    return function(*args, **kwargs)
