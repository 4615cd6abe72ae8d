"""Figures and numbers of the lesson: `python docs/lessons/control.py`.

Writes six PNGs to `docs/images/lessons/` and prints every number that they show.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from lesson_figures import BLUE, GREEN, GREY, IMAGES, ORANGE, PINK, drawn
from matplotlib.figure import Figure

from rotorpong.control.closed_loop import gains
from rotorpong.control.identification import Identification, step_answer
from rotorpong.control.plant import Axis, plant_of
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.physics.vehicle import NOISE_FREE_CASCADE, TICK, TumGazebo, Vehicle

TAU = 0.4  # s, the lag of both drones
H = 1.0 / 30.0  # s, for which a command is held
FAR, LONG = 0.4, 0.8  # m, s: the stroke
STEP = 0.2  # m/s
PUSHED = 0.1  # m
CALM = TumGazebo(NOISE_FREE_CASCADE)
STILL = replace(ARDRONE2, noise=replace(ARDRONE2.noise, velocity_white=0.0, velocity_bias=0.0))
Motion = tuple[np.ndarray, np.ndarray]


def main() -> None:
    """Draw all figures and print all numbers."""
    for draw in (
        control_step, control_late, control_held, control_delay, control_learnt, control_limits,
    ):  # fmt: skip
        print(f"  {drawn(draw, IMAGES)}")


def stroke(t: np.ndarray, far: float = FAR, long: float = LONG) -> Motion:
    """Return position and velocity of the laziest motion from rest to rest."""
    x = np.clip(t / long, 0.0, 1.0)
    return far * x**3 * (10 - 15 * x + 6 * x**2), far / long * 30 * x**2 * (1 - x) ** 2


def fly(axis: Axis, commands: np.ndarray, interval: float, ticks: int = 1) -> np.ndarray:
    """Return (p, v) at every instant of a drone that hears held commands; `ticks` in each."""
    phi, gamma = axis.transition(interval / ticks)
    states = [np.zeros(2)]
    for command in np.repeat(commands, ticks):
        states.append(phi @ states[-1] + gamma * command)
    return np.array(states)


def control_step(figure: Figure) -> None:
    """What drones make of a step, and how far they stay behind it."""
    speed, behind = figure.subplots(1, 2)
    for vehicle, colour in ((CALM, BLUE), (STILL, ORANGE)):
        t, path, velocity = stepped(vehicle)
        axis = plant_of(vehicle).axes[2]
        since = np.maximum(t - axis.dead_time, 0.0)
        model = STEP * step_answer(axis.answer_at(axis.lag), since[:, None])[0][:, 0]
        missing = 100 * (STEP * t - path)
        speed.plot(t, velocity, color=colour, label=vehicle.name)
        speed.plot(t, model, ":", color="black", linewidth=1)
        behind.plot(t, missing, color=colour)
        pull = np.gradient(velocity, TICK)
        known = 100 * (axis.lag * velocity + axis.bend * pull + STEP * (t - since))
        behind.plot(t, known, ":", color="black", linewidth=1)
        print(f"{vehicle.name}: {missing[-1]:.1f} cm behind, {known[-1]:.1f} by its constants")
    speed.axhline(STEP, color=GREY, linestyle="--", linewidth=0.8)
    speed.set(xlabel="time since the step, s", ylabel="velocity, m/s (dotted: model)")
    speed.legend(fontsize=8)
    behind.set(xlabel="time since the step, s", ylabel="behind what it was told, cm")


def stepped(vehicle: Vehicle) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, way forward and velocity of a simulated drone that is told `STEP`."""
    state = vehicle.start(np.zeros(3), np.random.default_rng(0))
    command = np.array([STEP, 0.0, 0.0, 0.0])
    _, track = vehicle.advance(state, command, ticks=2000, new_command=True)
    t = TICK * np.arange(len(track.position))
    return t, track.position[:, 0], track.velocity[:, 0]


def control_late(figure: Figure) -> None:
    """A stroke flown open loop and with feed-forward, and what is sent."""
    path, sent = figure.subplots(1, 2)
    t, fine = H * np.arange(25), H / 10 * np.arange(241)
    p, v = stroke(t)
    path.plot(fine, 100 * stroke(fine)[0], color=GREY, linewidth=3, alpha=0.5, label="meant")
    for name, commands, colour in (
        ("open loop: v", np.diff(p) / H, PINK),
        ("feed-forward: v + tau v'", np.diff(p + TAU * v) / H, BLUE),
    ):
        flown = fly(Axis(TAU), commands, H, 10)[:, 0]
        path.plot(fine, 100 * flown, color=colour, label=name)
        sent.step(t, np.append(commands, commands[-1]), where="post", color=colour)
        off = 100 * (stroke(fine)[0] - flown)
        print(f"{name}: {off[-1]:.2f} cm short at the end, up to {np.abs(off).max():.2f}")
    path.set(xlabel="time, s", ylabel="place, cm")
    path.legend(fontsize=8)
    sent.set(xlabel="time, s", ylabel="command, m/s")


def control_held(figure: Figure) -> None:
    """Ways to make held commands of a motion, and what they miss by the command rate."""
    shown, curve = figure.subplots(1, 2)
    fine, rates = np.linspace(0.0, LONG, 801), np.array([10, 20, 30, 50, 100, 200])
    shown.plot(fine, wanted(fine), color=GREY, linewidth=3, alpha=0.5, label="v + tau v'")
    for (name, recipe), colour in zip(RECIPES.items(), (PINK, GREEN, BLUE), strict=True):
        commands = recipe(LONG / 8)
        edges = LONG / 8 * np.arange(9)
        if name != "as it is in the middle":
            shown.step(edges, np.append(commands, commands[-1]), where="post", color=colour)
        worst = [100 * missed(recipe, 1.0 / rate) for rate in rates]
        curve.loglog(rates, worst, "o-", color=colour, markersize=3, label=name)
        print(f"{name}: {worst[2]:.3f} cm at 30 Hz, {worst[-1]:.4f} cm at 200 Hz")
    shown.set(xlabel="time, s", ylabel="command, m/s", title="held for 0.1 s each")
    curve.set(xlabel="commands per second", ylabel="largest error, cm")
    curve.set_xticks(rates, [f"{rate}" for rate in rates])
    curve.minorticks_off()
    curve.legend(fontsize=8)
    shown.title.set_fontsize(9)


def wanted(t: np.ndarray) -> np.ndarray:
    """Return v + tau v' of the stroke."""
    x = np.clip(t / LONG, 0.0, 1.0)
    pull = FAR / LONG**2 * 60 * x * (1 - x) * (1 - 2 * x)
    return stroke(t)[1] + TAU * pull


def at_once(interval: float) -> np.ndarray:
    """Return v + tau v' as it is when each command is sent."""
    return wanted(interval * np.arange(round(LONG / interval)))


def in_the_middle(interval: float) -> np.ndarray:
    """Return v + tau v' as it is in the middle of each interval."""
    return wanted(interval * (np.arange(round(LONG / interval)) + 0.5))


def averaged(interval: float) -> np.ndarray:
    """Return the mean of v + tau v' over each interval."""
    p, v = stroke(interval * np.arange(round(LONG / interval) + 1))
    return np.diff(p + TAU * v) / interval


RECIPES: dict[str, Callable[[float], np.ndarray]] = {
    "as it is when sent": at_once,
    "as it is in the middle": in_the_middle,
    "mean over the interval": averaged,
}


def missed(recipe: Callable[[float], np.ndarray], interval: float) -> float:
    """Return the largest error of a stroke flown by held commands, m."""
    ticks = max(round(interval / 0.001), 10)
    flown = fly(Axis(TAU), recipe(interval), interval, ticks)[:, 0]
    t = interval / ticks * np.arange(len(flown))
    return float(np.abs(flown - stroke(t)[0]).max())


def control_delay(figure: Figure) -> None:
    """A drone that was pushed aside comes back, by what it sees and by what it foresees."""
    path, left = figure.subplots(1, 2)
    t = H * np.arange(61)
    for late, colour in ((3, BLUE), (6, ORANGE)):
        for foresees, line in ((False, ":"), (True, "-")):
            words = "foreseen" if foresees else "as seen"
            back = 100 * returned(late, foresees=foresees, count=60)
            path.plot(t, back, line, color=colour, label=f"{1000 * late * H:.0f} ms late, {words}")
    path.set(xlabel="time, s", ylabel="aside, cm", ylim=(-15, 15))
    path.legend(fontsize=7, ncols=2, loc="lower center")
    delays = np.arange(10)
    for foresees, colour, words in ((False, PINK, "as seen"), (True, GREEN, "foreseen")):
        most = [
            100 * np.abs(returned(late, foresees=foresees, count=90)[late + 30 :]).max()
            for late in delays.tolist()
        ]
        left.semilogy(1000 * H * delays, most, "o-", color=colour, markersize=3, label=words)
        print(f"{words}, cm at {1000 * H:.0f} ms more each: " + " ".join(f"{m:.2g}" for m in most))
    left.axhline(100 * PUSHED, color=GREY, linestyle="--", linewidth=0.8)
    left.set(xlabel="dead time, ms", ylabel="still aside 1 s after it acts, cm")
    left.legend(fontsize=8)


def returned(late: int, *, foresees: bool, count: int) -> np.ndarray:
    """Return where a drone is whose commands act `late` intervals after they were sent."""
    (phi, gamma), gain = Axis(TAU).transition(H), gains(Axis(TAU), H)
    state, on_their_way, path = np.array([PUSHED, 0.0]), [0.0] * late, [PUSHED]
    for _ in range(count):
        believed = state
        for command in on_their_way if foresees else ():
            believed = phi @ believed + gamma * command
        on_their_way.append(float(-gain @ believed))
        state = phi @ state + gamma * on_their_way.pop(0)
        path.append(float(state[0]))
    return np.array(path)


def control_learnt(figure: Figure) -> None:
    """What a wrong lag costs, and how a flight tells what it is."""
    cost, known = figure.subplots(1, 2)
    lags, t = np.linspace(0.3, 0.5, 41), H * np.arange(25)
    p, v = stroke(t)
    told = np.diff(p + TAU * v) / H
    short = [100 * np.abs(fly(Axis(lag), told, H)[:, 0] - p).mean() for lag in lags]
    cost.plot(lags, short, color=BLUE)
    cost.set(xlabel="the drone's lag, s (0.4 is believed)", ylabel="mean error of the stroke, cm")
    print(f"lag 0.5, believed 0.4: {short[-1]:.2f} cm")
    for lag, colour in ((0.34, GREEN), (0.46, ORANGE)):
        times, mean, sd = learnt(lag)
        known.fill_between(times, mean - sd, mean + sd, color=colour, alpha=0.2, linewidth=0)
        known.plot(times, mean, color=colour)
        known.axhline(lag, color=colour, linestyle="--", linewidth=0.8)
        print(f"lag {lag}: after {times[-1]:.0f} s {mean[-1]:.3f} +- {sd[-1]:.3f} s")
    known.set(xlabel="time flown, s", ylabel="lag, s: known, and true (dashed)")


def learnt(lag: float, strokes: int = 10) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time (s), lag and its standard deviation of a drone that swings to and fro."""
    rng, plant = np.random.default_rng(0), replace(plant_of(CALM), axes=(Axis(TAU),) * 3)
    known = Identification.prior(plant)
    told = [0.4 * (-1.0) ** (k // 15) * (k % 30 != 29) for k in range(15 * strokes)]
    speeds = fly(Axis(lag), np.array(told), H, 7)[:, 1]
    sent, found = [], [(0.0, known.mean[0, 1], known.sd[0, 1])]
    for k, command in enumerate(told):
        sent.append([H * k, command, 0.0, 0.0])
        times = H * k + H / 7 * np.arange(1, 8)
        seen = np.zeros((7, 3))
        seen[:, 0] = speeds[7 * k + 1 : 7 * k + 8] + plant.velocity_white * rng.normal(size=7)
        known = known.updated(np.array(sent), times, seen)
        found.append((H * (k + 1), known.mean[0, 1], known.sd[0, 1]))
    times, mean, sd = np.array(found).T
    return times, mean, sd


def control_limits(figure: Figure) -> None:
    """A stroke that asks for more than the drone may be told, and what becomes of the rest."""
    sent, path = figure.subplots(1, 2)
    limit, far = 1.2, FAR
    t = H * np.arange(43)
    p, v = stroke(t, far)
    asked = np.diff(p + TAU * v) / H
    path.plot(t, 100 * p, color=GREY, linewidth=3, alpha=0.5, label="meant")
    sent.step(t, np.append(asked, asked[-1]), where="post", color=GREY, label="asked for")
    for name, owes, colour in (("cut", False, PINK), ("cut, and owed", True, BLUE)):
        commands = within(asked, limit, owes=owes)
        flown = fly(Axis(TAU), commands, H)[:, 0]
        sent.step(t, np.append(commands, commands[-1]), where="post", color=colour, label=name)
        path.plot(t, 100 * flown, color=colour, label=name)
        short = 100 * (p - flown)
        print(f"{name}: {short[24]:.1f} cm short at 0.8 s, {short[-1]:.1f} at {t[-1]:.1f} s")
    sent.set(xlabel="time, s", ylabel="command, m/s")
    path.set(xlabel="time, s", ylabel="place, cm")
    for axes in (sent, path):
        axes.legend(fontsize=8)


def within(asked: np.ndarray, limit: float, *, owes: bool) -> np.ndarray:
    """Return commands within a limit; what is cut is made up for later, or not."""
    owed, commands = 0.0, []
    for command in asked.tolist():
        wish = command + owed
        commands.append(min(max(wish, -limit), limit))
        owed = wish - commands[-1] if owes else 0.0
    return np.array(commands)


if __name__ == "__main__":
    main()
