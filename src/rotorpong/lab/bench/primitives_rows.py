"""Rows about motor primitives: how exactly they move, and how fast that is worked out.

The oracle of a roll-out is Eq. (4) solved by DOP853, that of a fit the demonstration itself,
between its samples, too. Times are for three coordinates and 20 bases.
"""

import functools

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.primitives import Dmp, Flight, State, fit_dmp, integrate_dmp
from rotorpong.primitives.batch import Batch, States
from rotorpong.primitives.limits import Limits, report_limits, with_limits
from rotorpong.primitives.sampling import sample_times

RATE = 1000.0  # samples per second of a single roll-out
BATCH_SAMPLES = 240  # of each motion of a batch
PRIMITIVES, GOALS = 10, 1000  # of a batch
NOISE = 0.002  # m, of a demonstration seen by a camera
REPEATS = 20  # of short work, in one timing
TRIALS = 50
MICRO = 1e6

TIMES = np.linspace(0.0, 1.0, 80)  # s, of the demonstration


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure and return the rows."""
    return (*_exactness(quick=quick), *_fits(), *_speeds(quick=quick), *_batches(quick=quick))


def stroke(x: Float[ndarray, "n"]) -> Float[ndarray, "n 3"]:
    """Return a back-swing and a stroke that ends in motion, m, at fractions of a second."""
    forward = 0.3 * x**3 - 0.15 * np.sin(np.pi * x) ** 2 * (1 - x)
    left = 0.1 * x**2 - 0.05 * np.sin(2 * np.pi * x) ** 2
    up = 0.3 * x**4 + 0.7 * x**5 - 0.2 * x**3
    return np.stack([forward, left, up], axis=-1)


def trials(count: int) -> list[tuple[State, State, float]]:
    """Return random starts, goals and durations, these of whole milliseconds."""
    rng = np.random.default_rng(0)
    made = []
    for _ in range(count):
        start = State(rng.uniform(-0.3, 0.3, 3), rng.uniform(-0.5, 0.5, 3))
        goal = State(rng.uniform(-0.3, 0.3, 3), rng.uniform(-0.5, 0.5, 3))
        made.append((start, goal, round(rng.uniform(0.5, 1.6), 3)))
    return made


@functools.cache
def demonstrated() -> Dmp:
    """Return the primitive of the stroke."""
    return fit_dmp(TIMES, stroke(TIMES))


def roll_out_seconds(*, quick: bool) -> float:
    """Return what one roll-out at 1 kHz with a random goal and duration takes, s."""
    asked = [(*one, sample_times(one[2], RATE)) for one in trials(REPEATS)]
    dmp = demonstrated()
    return cpu_seconds(lambda: [dmp.roll_out(*one) for one in asked], quick=quick) / REPEATS


def reproduction_error(dmp: Dmp, *, fine: int = 1001) -> float:
    """Return the RMS distance from the stroke when its own primitive repeats it, m."""
    ends, x = dmp.ends, np.linspace(0.0, 1.0, fine)
    if ends is None:
        raise ValueError("a primitive that was not fitted")
    start, goal = (State(ends.position[i], ends.velocity[i]) for i in (0, 1))
    missed = dmp.roll_out(start, goal, 1.0, x).position - stroke(x)
    return float(np.sqrt(np.mean(missed**2)))


def _exactness(*, quick: bool) -> tuple[Row, ...]:
    dmp = demonstrated()
    gaps, ends, jumps = [], [], []
    for start, goal, duration in trials(3 if quick else TRIALS):
        times = np.linspace(0.0, duration, 41)
        ours = dmp.roll_out(start, goal, duration, times)
        reference = integrate_dmp(dmp, start, goal, duration, times)
        gaps.append(
            (_gap(ours.position, reference.position), _gap(ours.velocity, reference.velocity))
        )
        ends.append(
            (_gap(ours.position[-1], goal.position), _gap(ours.velocity[-1], goal.velocity))
        )
        jumps.append(_jump(Flight.begin(dmp, start, goal, duration), start, 0.4 * duration))
    (gap, gap_rate), (end, end_rate), (jump, jump_rate) = (
        np.max(errors, axis=0) for errors in (gaps, ends, jumps)
    )
    return (
        Row("motion: position against DOP853", float(gap), "m", 1e-7, "less"),
        Row("motion: velocity against DOP853", float(gap_rate), "m/s", 1e-6, "less"),
        Row("motion: position at its end against the goal", float(end), "m", 1e-9, "less"),
        Row("motion: velocity at its end against the goal", float(end_rate), "m/s", 1e-9, "less"),
        Row("turning to another goal and arrival: jump", float(jump), "m", 1e-12, "less"),
        Row(
            "turning to another goal and arrival: jump of velocity",
            float(jump_rate),
            "m/s",
            1e-12,
            "less",
        ),
    )


def _gap(ours: ndarray, theirs: ndarray) -> float:
    return float(np.abs(ours - theirs).max())


def _jump(flight: Flight, goal: State, time: float) -> tuple[float, float]:
    turned = flight.regoal(time, goal, 1.3 * flight.arrival)
    before, after = (one.at(np.array([time])) for one in (flight, turned))
    return _gap(after.position, before.position), _gap(after.velocity, before.velocity)


def _fits() -> tuple[Row, ...]:
    noise = NOISE * np.random.default_rng(1).normal(size=(len(TIMES), 3))
    noisy = fit_dmp(TIMES, stroke(TIMES) + noise)
    paper = fit_dmp(TIMES, stroke(TIMES), method="lwr")
    mm = 1000.0
    return (
        Row(
            "clean demonstration, RMS", mm * reproduction_error(demonstrated()), "mm", 0.05, "less"
        ),
        Row(
            "demonstration with 2 mm of noise, RMS", mm * reproduction_error(noisy), "mm", 2, "less"
        ),
        Row("clean demonstration, the paper's fit, RMS", mm * reproduction_error(paper), "mm"),
    )


def _speeds(*, quick: bool) -> tuple[Row, ...]:
    dmp, path = demonstrated(), stroke(TIMES)
    start, goal, duration = trials(1)[0]
    flight, limits = Flight.begin(dmp, start, goal, duration), Limits(2.0, 8.0)
    works = {
        "fit of 80 samples": lambda: fit_dmp(TIMES, path),
        "turn to another goal": lambda: flight.regoal(0.2, start, 1.5),
        "exact peaks of speed and acceleration": lambda: report_limits(
            dmp, start, goal, duration, limits
        ),
        "fastest duration within limits": lambda: with_limits(dmp, start, goal, 0.3, limits),
    }
    single = Row(
        "roll-out at 1 kHz, random duration",
        MICRO * roll_out_seconds(quick=quick),
        "us",
        100.0,
        "less",
    )
    return (
        single,
        *(Row(name, MICRO * cpu_seconds(work, quick=quick), "us") for name, work in works.items()),
    )


def _batches(*, quick: bool) -> tuple[Row, ...]:
    """Time a batch that is written over again and again."""
    rng = np.random.default_rng(0)
    dmps = [Dmp(30.0 * rng.normal(size=(20, 3))) for _ in range(PRIMITIVES)]
    batch = Batch.of(dmps, samples=BATCH_SAMPLES)
    goals = States(rng.uniform(-0.3, 0.3, (GOALS, 3)), rng.uniform(-0.5, 0.5, (GOALS, 3)))
    durations = rng.uniform(0.5, 1.6, GOALS)
    start = trials(1)[0][0]
    memory = batch.roll_out(start, goals, durations)
    works = (
        ("positions", lambda: batch.roll_out(start, goals, durations, derivatives=0, out=memory)),
        ("positions and velocities", lambda: batch.roll_out(start, goals, durations, out=memory)),
        ("peak speed only", lambda: batch.peaks(start, goals, durations)),
    )
    targets = {"positions": 0.6, "peak speed only": 1.5}
    return tuple(
        Row(
            f"batch, {BATCH_SAMPLES} samples each: {name}",
            MICRO * cpu_seconds(work, quick=quick) / (PRIMITIVES * GOALS),
            "us",
            targets.get(name),
            "less",
        )
        for name, work in works
    )
