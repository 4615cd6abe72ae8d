"""Figures and numbers of the lesson: `python docs/lessons/mixture.py`.

Writes five PNGs to `docs/images/lessons/` and prints every number that the page quotes.
"""

import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, drawn
from matplotlib.figure import Figure

from rotorpong.lab.bench.selection_rows import WAYS, hits_of
from rotorpong.learning import BayesianLinearRegression, Mixture, Selection
from rotorpong.primitives import Dmp, State, fit_dmp, mix

GOAL = State(np.array([0.3]), np.array([1.0]))  # m, m/s
STILL = State(np.zeros(1), np.zeros(1))
DURATION = 0.5  # s
TIMES = np.linspace(0.0, DURATION, 200)
SWINGS = (-0.10, 0.0, 0.12)  # m, how far each primitive swings aside on its way
SEEDS = 30
WINDOW = 30  # trials over which a curve is smoothed


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (
        mixture_values, mixture_weights, mixture_motion, mixture_toy, mixture_forgetting,
    ):  # fmt: skip
        print(f"  {drawn(draw, IMAGES)}")


def mixture_values(figure: Figure) -> None:
    """What is believed of a reward, after few and after many serves."""
    rng = np.random.default_rng(0)
    where = np.linspace(-2.5, 2.5, 100)
    queries = np.column_stack([np.ones(100), where])
    value = BayesianLinearRegression.prior(2, noise_sd=0.3)
    seen: list[tuple[float, float]] = []
    for axes, count in zip(figure.subplots(1, 2, sharey=True), (3, 60), strict=True):
        while len(seen) < count:
            side = float(rng.normal(-0.5, 0.5))
            reward = float(np.clip(0.6 - 0.2 * side + 0.15 * rng.normal(), 0.0, 1.0))
            value = value.update(np.array([1.0, side]), reward)
            seen.append((side, reward))
        mean, upper = value.mean(queries), value.upper(queries, 1.0)
        axes.fill_between(where, 2 * mean - upper, upper, color=BLUE, alpha=0.15, linewidth=0)
        axes.plot(where, mean, color=BLUE)
        axes.plot(*np.array(seen).T, "o", color="black", markersize=3)
        axes.set(xlabel="how far to the right the ball is, sd", title=f"after {count} serves")
        far = np.array([1.0, 2.0])
        sd = float(np.sqrt(value.variance(far)))
        print(f"after {count}: V at 2 is {float(value.mean(far)):.2f} +- {sd:.2f}")
    figure.axes[0].set(ylabel="expected reward V", ylim=(-1.0, 2.0))


def mixture_weights(figure: Figure) -> None:
    """The weight of the best of ten, by how much better it is."""
    curve, bars = figure.subplots(1, 2)
    gap = np.linspace(0.0, 1.0, 100)
    for temperature, colour in ((1.0, BLUE), (0.3, GREEN), (0.1, ORANGE)):
        weight = np.exp(gap / temperature) / (np.exp(gap / temperature) + 9.0)
        curve.plot(gap, weight, color=colour, label=f"exp(V / {temperature:g})")
        print(f"temperature {temperature:g}: the best gets {100.0 * weight[-1]:.2f} %")
    curve.set(xlabel="V of the best less V of the nine others", ylabel="weight of the best")
    curve.legend(fontsize=8)
    mixture, one = Mixture.prior(10, 1), np.ones(1)
    for k in range(10):
        mixture = mixture.update(one, 1.0 - 0.1 * k, np.eye(10)[k])
    for shift, rule, colour in (
        (-0.2, Selection("paper"), BLUE), (0.2, Selection("temperature", 0.1), ORANGE),
    ):  # fmt: skip
        bars.bar(np.arange(10) + shift, mixture.select(one, rule), 0.4, color=colour)
    bars.set(xlabel="primitive, the best first", ylabel="weight")


def primitives() -> list[Dmp]:
    """Return motions to one goal that swing aside differently on their way."""
    phase = TIMES / DURATION
    straight = (10.0 - 15.0 * phase + 6.0 * phase**2) * phase**3
    bump = 64.0 * (phase * (1.0 - phase)) ** 3
    paths = [0.3 * straight + swing * bump for swing in SWINGS]
    return [fit_dmp(TIMES, path[:, None]) for path in paths]


def mixture_motion(figure: Figure) -> None:
    """Blends of three primitives: one end, many ways there."""
    place, speed = figure.subplots(1, 2)
    library = primitives()
    for weights, colour, width in (
        ((1, 0, 0), BLUE, 1.0), ((0, 1, 0), GREEN, 1.0), ((0, 0, 1), ORANGE, 1.0),
        ((0.5, 0.3, 0.2), PINK, 2.0),
    ):  # fmt: skip
        blend = mix(library, np.array(weights, float))
        motion = blend.roll_out(STILL, GOAL, DURATION, TIMES)
        place.plot(TIMES, motion.position[:, 0], color=colour, linewidth=width)
        speed.plot(TIMES, motion.velocity[:, 0], color=colour, linewidth=width)
        peak = np.abs(motion.velocity).max()
        print(
            f"{weights}: ends at {motion.position[-1, 0]:.6f} m, "
            f"{motion.velocity[-1, 0]:.6f} m/s; fastest {peak:.2f} m/s"
        )
    place.plot(DURATION, GOAL.position[0], "o", color="black")
    speed.plot(DURATION, GOAL.velocity[0], "o", color="black")
    place.set(xlabel="time, s", ylabel="place, m", title="thick: a blend")
    speed.set(xlabel="time, s", ylabel="speed, m/s")


def mixture_toy(figure: Figure) -> None:
    """Learning curves of rules of selection on the toy of `bench learning`."""
    drawn, blended = figure.subplots(1, 2, sharey=True)
    colours = iter((GREY, BLUE, GREEN, PINK, "black", ORANGE, GREY, ORANGE, PINK))
    kernel = np.ones(WINDOW) / WINDOW
    for way in WAYS:
        hits = np.mean([hits_of(way, seed) for seed in range(SEEDS)], axis=0)
        axes = blended if way.blends else drawn
        name = way.name.removeprefix("one drawn by ").removeprefix("blend by ")
        axes.plot(np.convolve(hits, kernel, "valid"), color=next(colours), label=name)
    for axes, title in ((drawn, "one is chosen"), (blended, "all are blended")):
        axes.set(xlabel="trials", title=title, ylim=(0.3, 0.85))
        axes.legend(fontsize=7)
    drawn.set(ylabel="hit rate")


def mixture_forgetting(figure: Figure) -> None:
    """Forgetting that winds up, and forgetting that leads back to the prior."""
    doubt, follow = figure.subplots(1, 2)
    usual, ours = [], []
    value, seen = BayesianLinearRegression.prior(2), np.array([1.0, 0.0])
    inflated = np.eye(2)
    for _ in range(200):
        value = value.forget(0.95).update(seen, 0.5)
        inflated = inflated / 0.95
        gain = inflated @ seen / (0.3**2 + seen @ inflated @ seen)
        inflated = inflated - np.outer(gain, seen @ inflated)
        usual.append(inflated[1, 1])
        ours.append(value.covariance[1, 1])
    doubt.semilogy(usual, color=PINK, label="P / rho")
    doubt.semilogy(ours, color=BLUE, label="towards the prior")
    doubt.set(xlabel="serves, none of them to the right", ylabel="variance of V to the right")
    doubt.legend(fontsize=8)
    print(f"variance after 200: {usual[-1]:.0f} and {ours[-1]:.2f}")
    rng = np.random.default_rng(0)
    for keep, colour in ((1.0, PINK), (0.95, BLUE)):
        value, told = BayesianLinearRegression.prior(1), []
        for t in range(300):
            reward = (0.8 if t < 150 else 0.3) + 0.1 * rng.normal()
            value = value.forget(keep).update(np.ones(1), float(reward))
            told.append(float(value.weights[0]))
        follow.plot(told, color=colour, label=f"keep = {keep:g}")
        print(f"keep {keep:g}: after the racket broke V falls to {told[-1]:.2f}")
    follow.plot([0, 150, 150, 300], [0.8, 0.8, 0.3, 0.3], "--", color=GREY, linewidth=0.8)
    follow.set(xlabel="serves", ylabel="V")
    follow.legend(fontsize=8)


if __name__ == "__main__":
    main()
