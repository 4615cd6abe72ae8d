"""Figures and numbers of the lesson: `python docs/lessons/crkr.py`.

Writes five PNGs to `docs/images/lessons/` and prints every number that the page quotes.
"""

import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, drawn
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotorpong.lab.bench.learning_rows import rmse_cm, throws
from rotorpong.learning import CrKR, NystroemCrKR, tune

WAY = 2.0  # m, from where the ball is first seen to the blade
TYPICAL = 0.35  # s, taken off the times: Eq. (6) wants labels about zero
NOISE = 0.02  # s, of a measured time
HEIGHT = 0.1  # s, how far times are from what is typical
SPEEDS = np.array([4.2, 4.6, 5.1, 5.3, 6.0, 6.1, 6.7, 7.4, 7.6, 7.9])  # m/s
QUERIES = np.linspace(3.0, 10.0, 200)
COUNTS = (5, 10, 20, 50, 100, 170)
POINTS = (8, 12, 18, 25, 50, 100)
MANY = 2000


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (crkr_estimate, crkr_costs, crkr_scales, crkr_throws, crkr_bounded):
        print(f"  {drawn(draw, IMAGES)}")


def measured() -> np.ndarray:
    """Return how long the balls took, less what is typical, as somebody measured it."""
    noise = NOISE * np.random.default_rng(4).standard_normal(len(SPEEDS))
    return WAY / SPEEDS - TYPICAL + noise


def crkr_estimate(figure: Figure) -> None:
    """The estimate as a sum of bells, and how sure it is."""
    bells, band = figure.subplots(1, 2)
    crkr = CrKR(1.0, 0.04, HEIGHT).fit(SPEEDS[:, None], measured())
    each = np.exp(-0.5 * (QUERIES[:, None] - SPEEDS) ** 2) * crkr.dual_coef_
    bells.plot(QUERIES, each, color=GREY, linewidth=0.7)
    bells.plot(QUERIES, each.sum(axis=1), color=BLUE, label="their sum")
    bells.plot(SPEEDS, measured(), "o", color="black", markersize=3)
    bells.set(xlabel="speed of the ball, m/s", ylabel=f"time to the blade - {TYPICAL} s, s")
    bells.legend(fontsize=8)
    _estimate(band, crkr, BLUE, "estimate")
    band.legend(fontsize=8)
    print(f"at 5 m/s: {crkr.predict([[5.0]])[0] + TYPICAL:.3f} s, true {WAY / 5.0:.3f} s")
    print(f"at 20 m/s: {crkr.predict([[20.0]])[0] + TYPICAL:.3f} s, true {WAY / 20.0:.3f} s")


def crkr_costs(figure: Figure) -> None:
    """One sample that is far off, at the cost of a good hit and of a bad one."""
    labels = measured()
    labels[4] += 0.15
    for axes, cost in zip(figure.subplots(1, 2, sharey=True), (1.0, 20.0), strict=True):
        costs = np.ones(len(labels))
        costs[4] = cost
        crkr = CrKR(1.0, 0.04, HEIGHT).fit(SPEEDS[:, None], labels, costs)
        _estimate(axes, crkr, BLUE, f"cost of the odd one: {cost:.0f}")
        axes.plot(SPEEDS[4], labels[4], "o", color=ORANGE)
        axes.legend(fontsize=8)
        print(f"cost {cost:.0f}: at 6 m/s {crkr.predict([[6.0]])[0] + TYPICAL:.3f} s")


def crkr_scales(figure: Figure) -> None:
    """Length scales that are too short, too long, and the most likely one."""
    curve, fits = figure.subplots(1, 2)
    labels, speeds = measured(), SPEEDS[:, None]
    tuned = tune(speeds, labels)
    lam, height = tuned.regularization, tuned.output_scales
    lengths = np.geomspace(0.1, 100.0, 100)
    likelihood = [CrKR(s, lam, height).fit(speeds, labels) for s in lengths]
    curve.semilogx(lengths, [one.log_marginal_likelihood() for one in likelihood], color=BLUE)
    curve.axvline(tuned.length_scales[0], color=ORANGE)
    curve.set(xlabel="length scale, m/s", ylabel="log marginal likelihood")
    best = float(tuned.length_scales[0])
    for length, colour in ((best / 20.0, PINK), (best, ORANGE), (20.0 * best, GREEN)):
        one = CrKR(length, lam).fit(speeds, labels)
        fits.plot(QUERIES, one.predict(QUERIES[:, None]), color=colour, label=f"{length:.2g} m/s")
    fits.plot(SPEEDS, labels, "o", color="black", markersize=3)
    fits.set(xlabel="speed of the ball, m/s", ylim=(-0.2, 0.35))
    fits.legend(fontsize=8)
    print(f"most likely length scale {best:.1f} m/s")
    print(f"noise found: {1000 * height * np.sqrt(lam):.0f} ms, true {1000 * NOISE:.0f} ms")


def crkr_throws(figure: Figure) -> None:
    """Six inputs: learning curves, and which inputs matter."""
    curve, bars = figure.subplots(1, 2)
    for name, colour, parameters in (
        ("1.0 for all, lambda 0.5", PINK, (1.0, 0.5)),
        ("3.0 for all, lambda 0.1", GREEN, (3.0, 0.1)),
    ):
        errors = [rmse_cm(CrKR(*parameters), n) for n in COUNTS]
        curve.loglog(COUNTS, errors, color=colour, label=name)
        print(f"{name}: {errors[-1]:.1f} cm after {COUNTS[-1]}")
    errors = []
    for n in COUNTS:
        samples, labels = throws(n, seed=0)
        tuned = tune(samples, labels - labels.mean(axis=0))
        errors.append(rmse_cm(tuned.crkr(), n))
    curve.loglog(COUNTS, errors, color=BLUE, label="tuned")
    print(f"tuned: {errors[-1]:.2f} cm after {COUNTS[-1]}")
    curve.set(xlabel="throws learnt from", ylabel="error of the hitting point, cm")
    curve.legend(fontsize=8)
    bars.bar(["x", "y", "z", "vx", "vy", "vz"], 1.0 / tuned.length_scales, color=BLUE)
    bars.set(ylabel="1 / length scale", title="what the time and place hang on most")


def crkr_bounded(figure: Figure) -> None:
    """What bounded memory costs."""
    samples, labels = throws(170, seed=0)
    scales = tune(samples, labels - labels.mean(axis=0)).length_scales
    errors, sizes = figure.subplots(1, 2)
    exact = rmse_cm(CrKR(scales, 1e-4), MANY)
    some = [rmse_cm(NystroemCrKR(scales, 1e-4, inducing_points=m), MANY) for m in POINTS]
    errors.loglog(POINTS, some, "o-", color=BLUE, label="inducing points only")
    errors.axhline(exact, color=ORANGE, label=f"all {MANY} samples")
    errors.set(xlabel="inducing points", ylabel="error, cm")
    errors.legend(fontsize=8)
    counts = np.array([100, 1000, 10000, 100000])
    sizes.loglog(counts, 8e-6 * counts**2, color=ORANGE, label="exact: the factor")
    sizes.loglog(counts, np.full(4, 8e-6 * 2 * 400**2), color=BLUE, label="400 points")
    sizes.set(xlabel="samples", ylabel="memory, MB")
    sizes.legend(fontsize=8)
    print(
        f"exact {exact:.2f} cm; "
        + ", ".join(f"{m}: {e:.2f}" for m, e in zip(POINTS, some, strict=True))
    )


def _estimate(axes: Axes, crkr: CrKR, colour: str, name: str) -> None:
    mean, deviation = crkr.predict(QUERIES[:, None], return_std=True)
    axes.fill_between(
        QUERIES, mean - deviation, mean + deviation, color=colour, alpha=0.15, linewidth=0
    )
    axes.plot(QUERIES, mean, color=colour, label=name)
    axes.plot(QUERIES, WAY / QUERIES - TYPICAL, "--", color=GREY, linewidth=0.8, label="truth")
    axes.plot(crkr.X_[:, 0], crkr.y_, "o", color="black", markersize=3)
    axes.set(xlabel="speed of the ball, m/s", ylim=(-0.2, 0.35))


if __name__ == "__main__":
    main()
