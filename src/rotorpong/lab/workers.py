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
    begin: Callable[..., None],
    arguments: tuple[Any, ...],
) -> Iterator[Answer]:
    """Yield what `function` returns for each task, in the order of the tasks.

    Args:
        function: of a module, as the workers import it.
        tasks: its arguments, one each.
        workers: processes.
        begin: called with `arguments` in each worker before its first task.
        arguments: see `begin`.

    Raises:
        RotorpongError: a worker died.
    """
    others = set(active_children())
    pool = ProcessPoolExecutor(workers, get_context("spawn"), _begin, (begin, arguments))
    try:
        with _interrupts_held():
            answers = [pool.submit(function, task) for task in tasks]
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


def _begin(begin: Callable[..., None], arguments: tuple[Any, ...]) -> None:
    threading.Thread(target=_leave_with_parent, daemon=True).start()
    sys.stdout = sys.stderr
    begin(*arguments)


def _leave_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
