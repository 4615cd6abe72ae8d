"""How exactly, how fast and how well is learnt where to hit: rows of `bench learning`.

Throws: a ball at the 2.5 m plane, position and velocity roughly those of human serves, flies
without air to a plane 0.5 m before the drone. Learnt is where it passes (right, down) and when,
from exact samples, inputs in standard deviations and labels centred, as the paper's player does.
RMSE is of right and down, over 1000 fresh throws.

Rough labels: products of the same inputs and a sine, with noise; their length scales are so short
that 400 inducing points do not cover the inputs.
"""

import pickle
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import GRAVITY
from rotorpong.drone import BallEstimate
from rotorpong.experience import Attempt
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import cpu_seconds
from rotorpong.learning import BayesianLinearRegression, CrKR, NystroemCrKR, tune
from rotorpong.play.lessons import Lesson
from rotorpong.play.odometer import Path
from rotorpong.play.paper import PaperPlayer

FROM, TO = 2.5, 0.5  # m, depths of the planes
BALL_MEAN = np.array([0.0, 0.0, FROM, 0.0, -1.0, -6.0])  # camera axes: right, down, forward
BALL_SD = np.array([0.3, 0.2, 0.1, 0.3, 0.5, 0.7])
FRESH = 1000
FIXED = {"player's": (3.0, 0.1), "of Silva's library": (1.0, 0.5)}  # length scale, lambda
COUNTS = (10, 50, 170)
LARGE, QUICK_LARGE = 5000, 1000  # samples that the Nystroem features are held against
INDUCING = 400
HITS = 160  # own, beyond 10 demonstrations


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure: half a minute, or a few seconds."""
    return (
        *_exact_rows(),
        *_append_rows(quick=quick),
        *_nystroem_rows(quick=quick),
        *_regression_rows(quick=quick),
        *_tuning_rows(quick=quick),
        _decision_row(quick=quick),
    )


def some_samples(
    n: int, seed: int = 0
) -> tuple[Float[ndarray, "n 6"], Float[ndarray, "n 7"], Float[ndarray, "n"]]:
    """Return standardised inputs, labels as many as a hitting point has, and costs 1 to 20."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(n, 6)), rng.normal(size=(n, 7)), rng.uniform(1.0, 20.0, size=n)


def throws(n: int, seed: int) -> tuple[Float[ndarray, "n 6"], Float[ndarray, "n 3"]]:
    """Return balls in standard deviations, and where (m) and when (s) they pass the plane."""
    standard = np.random.default_rng(seed).normal(size=(n, 6))
    position, velocity = np.split(BALL_MEAN + BALL_SD * standard, 2, axis=1)
    elapsed = (TO - position[:, 2]) / velocity[:, 2]
    passed = position[:, :2] + velocity[:, :2] * elapsed[:, None]
    passed[:, 1] += 0.5 * GRAVITY * elapsed**2
    return standard, np.column_stack([passed, elapsed])


def rmse_cm(estimator: CrKR | NystroemCrKR, n: int, seed: int = 0) -> float:
    """Return the error of right and down after n throws, cm."""
    samples, labels = throws(n, seed)
    fresh, truth = throws(FRESH, seed + 1000)
    mean = labels.mean(axis=0)
    found = estimator.fit(samples, labels - mean).predict(fresh) + mean
    return 100.0 * float(np.sqrt(np.mean(np.sum((found - truth)[:, :2] ** 2, axis=1))))


def _exact_rows() -> list[Row]:
    samples, labels, costs = some_samples(200)
    fresh = some_samples(50, seed=1)[0]
    whole = CrKR(2.0, 0.1).fit(samples, labels, costs)
    grown = CrKR(2.0, 0.1)
    for i in range(200):
        grown.partial_fit(samples[i : i + 1], labels[i : i + 1], costs[i : i + 1])
    pairs = zip(
        whole.predict(fresh, return_std=True), grown.predict(fresh, return_std=True), strict=True
    )
    worst = max(float(np.abs(a - b).max()) for a, b in pairs)
    name = "CrKR, 200 samples one by one against one fit, largest difference"
    return [Row(name, worst, "1", 1e-10, "less")]


def _append_rows(*, quick: bool) -> list[Row]:
    found = []
    for n, target in (
        ((170, None), (1000, 2.5)) if quick else ((170, None), (1000, 2.5), (5000, 80))
    ):
        samples, labels, _ = some_samples(n + 1)
        crkr = CrKR(2.0, 0.1).fit(samples[:n], labels[:n])
        crkr.partial_fit(samples[n:], labels[n:])  # the buffer grows now, not in what is timed
        seconds = cpu_seconds(partial(crkr.partial_fit, samples[n:], labels[n:]), quick=quick)
        found.append(Row(f"CrKR, one sample more at N = {n}", 1e3 * seconds, "ms", target, "less"))
    return found


def _nystroem_rows(*, quick: bool) -> list[Row]:
    n = QUICK_LARGE if quick else LARGE
    scales = tune(*_centred(170)).length_scales
    exact = rmse_cm(CrKR(scales, 1e-4), n)
    nystroem = NystroemCrKR(scales, 1e-4, inducing_points=INDUCING)
    ratio = rmse_cm(nystroem, n) / exact
    rough = _rough_rmse(NystroemCrKR(2.0, 0.01, inducing_points=INDUCING), n)
    rough /= _rough_rmse(CrKR(2.0, 0.01), n)
    one, label = throws(1, seed=5)
    seconds = cpu_seconds(partial(nystroem.partial_fit, one, label), quick=quick)
    name = f"Nystroem CrKR, {INDUCING} inducing points"
    return [
        Row(f"{name}, RMSE over the exact one's at N = {n}", ratio, "1", 1.15, "less"),
        Row(f"{name}, the same of rough labels", rough, "1"),
        Row(f"{name}, one sample more", 1e3 * seconds, "ms", 0.5, "less"),
        Row(f"{name}, memory at N = 10,000 over N = 10", _growth(), "1", 1.001, "less"),
    ]


def _rough_rmse(estimator: CrKR | NystroemCrKR, n: int) -> float:
    rng = np.random.default_rng(0)
    samples, fresh = rng.normal(size=(n, 6)), rng.normal(size=(FRESH, 6))
    labels = _rough(samples) + 0.1 * rng.normal(size=(n, 2))
    error = estimator.fit(samples, labels).predict(fresh) - _rough(fresh)
    return float(np.sqrt(np.mean(error**2)))


def _rough(samples: Float[ndarray, "n 6"]) -> Float[ndarray, "n 2"]:
    a, b, c, d, e, _ = samples.T
    return np.column_stack([np.sin(a) * b + d, c * e])


def _growth() -> float:
    samples, labels, _ = some_samples(10_000)
    nystroem = NystroemCrKR(2.0, 0.1, inducing_points=INDUCING).fit(samples[:10], labels[:10])
    before = len(pickle.dumps(nystroem))
    return len(pickle.dumps(nystroem.partial_fit(samples[10:], labels[10:]))) / before


def _regression_rows(*, quick: bool) -> list[Row]:
    rng = np.random.default_rng(0)
    features, targets = rng.normal(size=(170, 14)), rng.uniform(size=170)
    value = BayesianLinearRegression.prior(14)
    for row, target in zip(features, targets, strict=True):
        value = value.update(row, float(target))
    information = np.eye(14) + features.T @ features / value.noise_sd**2
    weights = np.linalg.solve(information, features.T @ targets / value.noise_sd**2)
    worst = float(np.abs(value.weights - weights).max())
    seconds = cpu_seconds(lambda: [value.update(features[0], 0.5) for _ in range(100)], quick=quick)
    return [
        Row("linear regression, one by one against the batch", worst, "1", 1e-12, "less"),
        Row("linear regression, one observation more, 14 features", 1e4 * seconds, "us"),
    ]


def _tuning_rows(*, quick: bool) -> list[Row]:
    found = []
    for n in COUNTS:
        name = f"throws, RMSE after {n}"
        tuned = rmse_cm(tune(*_centred(n)).crkr(), n)
        found.append(Row(f"{name}, tuned length scales", tuned, "cm"))
        for whose, parameters in FIXED.items():
            found.append(Row(f"{name}, parameters {whose}", rmse_cm(CrKR(*parameters), n), "cm"))
    for n in (170,) if quick else (170, 1000):
        seconds = cpu_seconds(partial(tune, *some_samples(n)), quick=True)
        found.append(Row(f"tuning with N = {n}", seconds, "s"))
    return found


def _centred(n: int) -> tuple[Float[ndarray, "n 6"], Float[ndarray, "n 3"]]:
    samples, labels = throws(n, seed=0)
    return samples, labels - labels.mean(axis=0)


def _decision_row(*, quick: bool) -> Row:
    """Time hitting point, mixture and motion at 30 Hz, after 10 demonstrations and 160 hits."""
    player, rng = PaperPlayer([_lesson(seed) for seed in range(10)]), np.random.default_rng(0)
    for seed in range(10, 10 + HITS):
        hit = _lesson(seed)
        attempt = Attempt(hit.ball, hit.hitting_point, rng.dirichlet(np.ones(10)))
        player.remember(attempt, hit.reward)
    ball, still = _lesson(500).ball, np.zeros(3)
    estimate = BallEstimate(0.0, ball[:3], ball[3:], np.eye(6))
    times = np.arange(0.0, 0.6, 1.0 / 30.0)

    def decide() -> None:
        stroke = player.stroke(estimate, player.hitting_point(ball), still)
        for begin in times:
            stroke.command(float(begin), 1.0 / 30.0)

    name = "whole decision, N = 170, 10 primitives, and all its commands"
    return Row(name, 1e3 * cpu_seconds(decide, quick=quick), "ms", 1.0, "less")


def _lesson(seed: int) -> Lesson:
    """Return a demonstrated hit: half a second, bell-shaped speed, to where a throw passes."""
    standard, passed = throws(1, seed)
    phase = np.linspace(0.0, 1.0, 60)[:, None]
    path = (10.0 - 15.0 * phase + 6.0 * phase**2) * phase**3
    speed = 30.0 * phase**2 * (1.0 - phase) ** 2
    goal, duration = np.append(passed[0, :2], 0.2), float(passed[0, 2])
    motion = Path(duration * phase[:, 0], path * goal, speed * goal / duration)
    return Lesson(BALL_MEAN + BALL_SD * standard[0], motion, 1.0)
