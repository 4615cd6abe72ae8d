"""Figures and numbers of the lesson: `python docs/lessons/dmp.py`.

Writes six PNGs to `docs/images/lessons/` and prints every number that they show.
"""

import matplotlib as mpl
import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, drawn
from matplotlib.figure import Figure

from rotorpong.primitives import Dmp, Flight, Motion, State, fit_dmp
from rotorpong.primitives.basis import (
    STIFFNESS,
    forcing_features,
    phase,
    responses,
)
from rotorpong.primitives.limits import Limits, report_limits, with_limits

T = np.linspace(0.0, 1.0, 80)
FINE = np.linspace(0.0, 1.0, 1001)
REST = State(np.zeros(2), np.zeros(2))


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (shape_and_target, bells, elsewhere, two_fits, turning, fast_enough):
        print(f"  {drawn(draw, IMAGES)}")


def stroke(t: np.ndarray) -> np.ndarray:
    """Return the demonstration: a back-swing, then forward and up, in motion at the end."""
    return np.stack([0.4 * t**3 - 0.3 * np.sin(np.pi * t) ** 2 * (1 - t), 0.5 * t**4], axis=1)


def shown_again(dmp: Dmp) -> Motion:
    """Return the motion between the ends of the demonstration."""
    ends = dmp.ends
    if ends is None:
        raise SystemExit("a primitive that was not fitted")
    start, goal = (State(ends.position[i], ends.velocity[i]) for i in (0, 1))
    return dmp.roll_out(start, goal, 1.0, FINE)


def shape_and_target(figure: Figure) -> None:
    """The demonstration is a moving target and what is added to it."""
    path, parts = figure.subplots(1, 2)
    dmp = fit_dmp(T, stroke(T))
    whole = shown_again(dmp).position
    target = shown_again(Dmp(0.0 * dmp.weights, ends=dmp.ends)).position
    path.plot(*stroke(T).T, "o", color=GREY, markersize=2.5, label="demonstration")
    path.plot(*whole.T, color=BLUE, label="s, the primitive")
    path.plot(*target.T, "--", color=ORANGE, label="g, the target alone")
    path.set(xlabel="forward, m", ylabel="up, m")
    path.legend(fontsize=8)
    for values, colour, name in (
        (whole, BLUE, "s"),
        (target, ORANGE, "g"),
        (whole - target, GREEN, "s - g"),
    ):
        parts.plot(FINE, values[:, 0], color=colour, label=name)
    parts.set(xlabel="t, s", ylabel="forward, m")
    parts.legend(fontsize=8)
    missed = np.sqrt(np.mean((whole - stroke(FINE)) ** 2))
    print(f"shown again: {1000 * missed:.4f} mm RMS; s - g up to {np.ptp(whole - target):.2f} m")


def bells(figure: Figure) -> None:
    """What one weight pushes, and what the damped system makes of it."""
    push, answer = figure.subplots(1, 2)
    forces = forcing_features(phase(FINE), 10)
    moved = responses(FINE, 10)[0]
    for k in range(10):
        colour = mpl.colormaps["viridis"](k / 10)
        push.plot(FINE, forces[:, k], color=colour, linewidth=1)
        answer.plot(FINE, 1000 * moved[:, k], color=colour, linewidth=1)
    push.set(xlabel="x = t / tau", title="psi(z) z: the push of a weight of 1")
    answer.set(xlabel="x = t / tau", title="Phi(x), 0.001: what it moves")
    for axes in (push, answer):
        axes.title.set_fontsize(9)
    print(f"first push {forces[0, 0]:.3f}, last push {forces[-1, -1]:.4f}")


def elsewhere(figure: Figure) -> None:
    """One shape, other goals and other durations."""
    path, speeds = figure.subplots(1, 2)
    dmp, fit_end = fit_dmp(T, stroke(T)), stroke(T)[-1]
    velocity = np.array([0.6, 0.8])
    for i, (forward, up) in enumerate(((0.4, 0.5), (0.6, 0.3), (0.2, 0.7), (0.0, 0.0))):
        goal = State(np.array([forward, up]), velocity if i < 3 else np.zeros(2))
        motion = dmp.roll_out(REST, goal, 1.0, FINE)
        path.plot(*motion.position.T, color=(BLUE, ORANGE, GREEN, PINK)[i])
        path.plot(*goal.position, "o", color=(BLUE, ORANGE, GREEN, PINK)[i])
    path.set(xlabel="forward, m", ylabel="up, m", title="to other goals, one of them the start")
    for duration, colour in ((0.6, ORANGE), (1.0, BLUE), (1.6, GREEN)):
        motion = dmp.roll_out(REST, State(fit_end, velocity), duration, FINE * duration)
        speed = np.linalg.norm(motion.velocity, axis=1)
        speeds.plot(motion.times, speed, color=colour, label=f"{duration} s")
        print(f"in {duration} s: fastest {speed.max():.2f} m/s, at the end {speed[-1]:.3f} m/s")
    speeds.set(xlabel="t, s", ylabel="speed, m/s", title="in other durations")
    speeds.legend(fontsize=8)
    for axes in (path, speeds):
        axes.title.set_fontsize(9)


def two_fits(figure: Figure) -> None:
    """A noisy demonstration, fitted in position and as the paper does."""
    path, ends = figure.subplots(1, 2)
    rng = np.random.default_rng(0)
    path.plot(*stroke(FINE).T, color=GREY, linewidth=3, alpha=0.5, label="what was meant")
    noises = np.array([0.0, 0.5, 1.0, 2.0, 3.0, 5.0])
    for method, colour in (("position", BLUE), ("lwr", ORANGE)):
        worst = []
        for millimetres in noises:
            tries = []
            for _ in range(20):
                seen = stroke(T) + millimetres / 1000 * rng.normal(size=(80, 2))
                dmp = fit_dmp(T, seen, method=method)
                end = dmp.roll_out(REST, REST, 1.0, np.array([1.0])).position[0]
                tries.append(np.linalg.norm(end))
            worst.append(1000 * np.median(tries))
            if millimetres == 2.0:
                path.plot(*shown_again(dmp).position.T, color=colour, label=f"{method}, 2 mm")
        ends.semilogy(noises, np.maximum(worst, 1e-12), "o-", color=colour, label=method)
        print(f"{method}: median miss of the goal at 2 mm of noise {worst[3]:.1e} mm")
    path.set(xlabel="forward, m", ylabel="up, m")
    ends.set(xlabel="noise of the demonstration, mm", ylabel="miss of the goal, mm")
    path.legend(fontsize=8)
    ends.legend(fontsize=8)


def turning(figure: Figure) -> None:
    """A flight that turns to a later arrival, with the homogeneous term and without."""
    path, rate = figure.subplots(1, 2)
    flight = Flight.begin(fit_dmp(T, stroke(T)), REST, State(stroke(T)[-1], np.zeros(2)), 1.0)
    turned = flight.regoal(0.45, State(np.array([0.7, 0.2]), np.zeros(2)), 1.6)
    before, after = flight.at(0.45 * FINE), turned.at(0.45 + 1.15 * FINE)
    given_up = flight.at(0.45 + 0.55 * FINE)
    path.plot(*given_up.position.T, ":", color=GREY, label="to the old goal")
    path.plot(*before.position.T, color=BLUE)
    path.plot(*after.position.T, color=ORANGE, label="turned")
    path.set(xlabel="forward, m", ylabel="up, m")
    path.legend(fontsize=8)
    faded = STIFFNESS / 2 * (1 - turned.phase_clock) * FINE
    h_rate = turned.echo[1, 0] * (1 - faded) * np.exp(-faded)
    rate.plot(before.times, before.velocity[:, 0], color=BLUE)
    rate.plot(after.times, after.velocity[:, 0], color=ORANGE, label="with h")
    without = after.velocity[:, 0] - turned.pace * h_rate
    rate.plot(after.times, without, "--", color=PINK, linewidth=1, label="without")
    rate.set(xlabel="t, s", ylabel="forward, m/s")
    rate.legend(fontsize=8)
    jump = without[0] - before.velocity[-1, 0]
    print(f"pace {flight.pace:.2f} to {turned.pace:.3f} per second; without h a jump of {jump:.3f}")


def fast_enough(figure: Figure) -> None:
    """Peak speed and acceleration by the duration, and the limits of a drone."""
    speed, push = figure.subplots(1, 2)
    dmp, goal = fit_dmp(T, stroke(T)), State(stroke(T)[-1], np.array([1.2, 1.0]))
    limits = Limits(speed=2.0, acceleration=9.0)
    durations = np.geomspace(0.4, 2.0, 60)
    reports = [report_limits(dmp, REST, goal, float(tau), limits) for tau in durations]
    found = with_limits(dmp, REST, goal, 0.4, limits)
    if found is None:
        raise SystemExit("no duration keeps the limits")
    for axes, peaks, limit, unit in (
        (speed, [r.speed.value for r in reports], 2.0, "m/s"),
        (push, [r.acceleration.value for r in reports], 9.0, "m/s^2"),
    ):
        axes.plot(durations, peaks, color=BLUE)
        axes.axhline(limit, color=ORANGE)
        axes.axvline(found.duration, color=GREEN, linestyle="--")
        axes.set(xlabel="duration, s", ylabel=f"peak, {unit}", ylim=(0.0, 4 * limit))
    print(f"fastest within the limits: {found.duration:.3f} s")


if __name__ == "__main__":
    main()
