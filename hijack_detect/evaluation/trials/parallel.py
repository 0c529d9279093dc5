"""Runs a function over many flights, on several cores."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Protocol, TypeVar


class Named(Protocol):
    """Something with a name, such as a case."""

    @property
    def name(self) -> str:
        """What it is called in reports."""
        ...


@dataclass(frozen=True)
class Failure:
    """An item that the function refused."""

    name: str
    reason: str


Item = TypeVar("Item", bound=Named)
Result = TypeVar("Result")


def map_cases(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    jobs: int = 1,
    on_done: Callable[[int], None] | None = None,
) -> list[Result | Failure]:
    """Apply a function to every item; the results are in the order of the items.

    An item for which the function raises ValueError or OSError (a bag that cannot be read, a
    scenario outside its flight) becomes a Failure. Anything else is a defect and stops the run.

    Args:
        function: What to do; with several jobs it must be importable, as items and results
            must be picklable, because they go to other processes.
        items: The items.
        jobs: How many processes; with 1 everything runs in this one.
        on_done: Called after each item with the number of items that are done.
    """
    tell = on_done or (lambda done: None)
    if jobs <= 1 or len(items) <= 1:
        results: list[Result | Failure] = []
        for item in items:
            results.append(_attempt(function, item))
            tell(len(results))
        return results
    # A fork would copy the threads' locks of this process, but not the threads that hold them.
    context = multiprocessing.get_context("spawn")
    found: dict[int, Result | Failure] = {}
    pool = ProcessPoolExecutor(min(jobs, len(items)), context, _begin_worker)
    try:
        futures = {pool.submit(_attempt, function, item): i for i, item in enumerate(items)}
        for future in as_completed(futures):
            found[futures[future]] = future.result()
            tell(len(found))
    finally:
        pool.shutdown(cancel_futures=True)
    return [found[index] for index in range(len(items))]


def _attempt(function: Callable[[Item], Result], item: Item) -> Result | Failure:
    try:
        return function(item)
    except (ValueError, OSError) as error:
        return Failure(item.name, str(error))


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, and end with it, also when it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
