"""How long work takes: medians over repetitions, after warm-ups, in CPU time of this process.

CPU time is what one core needs, whatever else the machine does. That holds with one thread only:
`single_thread` must come before numpy is imported.
"""

import os
import time
from collections.abc import Callable, MutableMapping
from statistics import median
from typing import Any

LIBRARIES = ("OMP", "OPENBLAS", "MKL", "VECLIB_MAXIMUM", "NUMEXPR", "NUMBA")
WARM_UPS = 2
REPETITIONS = 15
QUICK_REPETITIONS = 3


def single_thread(environment: MutableMapping[str, str]) -> None:
    """Set the thread counts of all numeric libraries to 1."""
    for library in LIBRARIES:
        environment[f"{library}_NUM_THREADS"] = "1"


def is_single_thread() -> bool:
    """Tell whether this process was started with one thread for every numeric library."""
    return all(os.environ.get(f"{library}_NUM_THREADS") == "1" for library in LIBRARIES)


def cpu_seconds(work: Callable[[], Any], *, quick: bool = False) -> float:
    """Return the median CPU time of `work`, s."""
    return _median(work, time.process_time, quick=quick)


def wall_seconds(work: Callable[[], Any], *, quick: bool = False) -> float:
    """Return the median time on the wall of `work`, s: for work that other processes do."""
    return _median(work, time.perf_counter, quick=quick)


def _median(work: Callable[[], Any], clock: Callable[[], float], *, quick: bool) -> float:
    for _ in range(WARM_UPS):
        work()
    durations = []
    for _ in range(QUICK_REPETITIONS if quick else REPETITIONS):
        start = clock()
        work()
        durations.append(clock() - start)
    return median(durations)
