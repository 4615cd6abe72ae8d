"""Tasks shared out to processes that Ctrl-C does not reach and that never outlive their parent.

Ctrl-C goes to every process of a terminal at once. Workers are deaf to it: the parent hears it and
ends them. A worker whose parent is gone, even by kill -9, goes as well. What a task prints goes to
stderr, since stdout may carry the parent's JSON.
"""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context, parent_process
from typing import Any, TypeVar

from rotorpong.conventions import RotorpongError

Task = TypeVar("Task")
Answer = TypeVar("Answer")


def in_workers(
    function: Callable[[Task], Answer],
    tasks: Sequence[Task],
    *,
    workers: int,
    begin: Callable[..., None] | None = None,
    arguments: tuple[Any, ...] = (),
) -> Iterator[Answer]:
    """Yield what `function` returns for each task, in the order of the tasks.

    Args:
        function: of a module, as the workers import it.
        tasks: its arguments, one each.
        workers: processes.
        begin: called with `arguments` in each worker before its first task; None: nothing is.
        arguments: see `begin`.

    Raises:
        RotorpongError: a worker died.
        Exception: what `begin` or `function` raised.
    """
    others = set(active_children())
    pool = ProcessPoolExecutor(workers, get_context("spawn"), _begin, (begin, arguments))
    try:
        with _interrupts_held():
            answers = [pool.submit(_perform, function, task) for task in tasks]
        for answer in answers:
            yield answer.result()
    except BrokenProcessPool as error:
        raise RotorpongError("a worker process died, for want of memory or killed") from error
    except BaseException:
        for worker in set(active_children()) - others:
            worker.terminate()
        raise
    finally:
        pool.shutdown()


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Put Ctrl-C off; processes that are started meanwhile never hear it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


_broken: Exception | None = None  # what `begin` raised in this worker


def _begin(begin: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    """Begin; an error is kept for the first task, as here the pool would only print and break."""
    global _broken
    threading.Thread(target=_leave_with_parent, daemon=True).start()
    sys.stdout = sys.stderr
    try:
        if begin is not None:
            begin(*arguments)
    except Exception as error:  # noqa: BLE001 - whatever it is, the parent shall have it
        _broken = error


def _perform(function: Callable[[Task], Answer], task: Task) -> Answer:
    if _broken is not None:
        raise _broken
    return function(task)


def _leave_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
