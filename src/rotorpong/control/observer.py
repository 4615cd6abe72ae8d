"""Where a drone is and will be: navdata and the commands in flight, weighed by their noise.

A Kalman filter for each axis, over z = (p, v, v', w, b): the state of `plant`, an offset w that
commands meet, and the bias b of the measured velocity, both constant over a serve.

    z(t + e) = F z(t) + Gamma u,   Q = q h / e Gamma Gamma',   y = v + b + noise

u is the command that acts then, one dead time after it was sent; each message brings it noise of
variance q, so over a stretch e of an interval h its mean has variance q h / e. y is the mean of the
velocities that came with a frame, at their mean time. The state at a later instant is that at the
last measurement carried on through the commands on their way: a Smith predictor whose correction
is weighed instead of delayed. Position is reckoned from the start of the serve; what w and b cannot
be told apart by stays in it. Level camera axes, as they were at the first navdata.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control.plant import Axis, Plant
from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.drone import Navdata

STILL_SD = 0.02  # m/s, m/s^2: how still a hover is that begins a serve
MESSAGE_INTERVAL = 1.0 / 30.0  # s, h


@dataclass(frozen=True, slots=True)
class Belief:
    """What is known of one axis at an instant."""

    time: float  # s
    mean: Float[ndarray, "m"]  # p, v, (v',) w, b
    covariance: Float[ndarray, "m m"]

    @classmethod
    def at_rest(cls, axis: Axis, plant: Plant, time: float) -> "Belief":
        """Return what is known of a hover."""
        n = axis.order
        sd = np.zeros(n + 2)
        sd[1:n] = STILL_SD
        sd[n:] = plant.command_offset / axis.gain, plant.velocity_bias
        return cls(time, np.zeros(n + 2), np.diag(sd**2))

    def later(self, axis: Axis, command: float, elapsed: float, white: float) -> "Belief":
        """Return what is known `elapsed` (s) later, under a command with this noise (m/s, sd)."""
        n = axis.order
        phi, gamma = axis.transition(elapsed)
        flow = np.eye(n + 2)
        flow[:n, :n], flow[:n, n] = phi, gamma
        noise = (white / axis.gain) ** 2
        mean = flow @ self.mean
        mean[:n] += gamma * command
        spread = flow @ self.covariance @ flow.T
        spread[:n, :n] += noise * MESSAGE_INTERVAL / elapsed * np.outer(gamma, gamma)
        return Belief(self.time + elapsed, mean, spread)

    def seen(self, axis: Axis, velocity: float, noise_sd: float) -> "Belief":
        """Return what is known after a velocity was measured, m/s."""
        row = np.zeros(len(self.mean))
        row[[1, axis.order + 1]] = 1.0
        p_h = self.covariance @ row
        gain = p_h / (row @ p_h + noise_sd**2)
        keep = np.eye(len(row)) - np.outer(gain, row)
        covariance = keep @ self.covariance @ keep.T + noise_sd**2 * np.outer(gain, gain)
        return Belief(self.time, self.mean + gain * (velocity - row @ self.mean), covariance)


class Observer:
    """Keeps what is known of one serve."""

    def __init__(self, plant: Plant) -> None:
        """Begin with a hover."""
        self._plant = plant
        self._beliefs: tuple[Belief, ...] = ()
        self._times: list[float] = []
        self._commands: list[Float[ndarray, "3"]] = []
        self._first_heading: float | None = None
        self.turned = 0.0  # rad, heading since the first navdata

    @property
    def is_begun(self) -> bool:
        """Tell whether anything was measured."""
        return bool(self._beliefs)

    def sent(self, time: float, velocity: Float[ndarray, "3"]) -> None:
        """Take in what was sent at `time` (s), m/s, in the observer's axes."""
        self._times.append(time)
        self._commands.append(velocity)

    def sense(self, navdata: Navdata, axes: tuple[Axis, Axis, Axis]) -> None:
        """Take in what was measured since the last call, of a drone that answers as `axes` say."""
        if not len(navdata.times):
            return
        headings = np.unwrap(navdata.attitude[:, 2])
        if self._first_heading is None:
            self._first_heading = float(headings[0])
        self.turned = float(np.angle(np.exp(1j * (headings[-1] - self._first_heading))))
        velocity = turn(self.turned) @ CAMERA_FROM_BODY_AXES @ navdata.velocity.mean(axis=0)
        time = float(navdata.times.mean()) - self._plant.velocity_delay
        if not self._beliefs:
            self._beliefs = tuple(Belief.at_rest(axis, self._plant, time) for axis in axes)
        noise = self._plant.velocity_white / np.sqrt(len(navdata.times))
        self._beliefs = tuple(
            self._carried(i, axis, belief, time).seen(axis, float(velocity[i]), noise)
            for i, (axis, belief) in enumerate(zip(axes, self._beliefs, strict=True))
        )

    def at(self, times: Float[ndarray, "3"], axes: tuple[Axis, Axis, Axis]) -> tuple[Belief, ...]:
        """Return what is known of each axis at its time (s), not before the last measurement."""
        return tuple(
            self._carried(i, axes[i], self._beliefs[i], time)
            for i, time in enumerate(times.tolist())
        )

    def _carried(self, i: int, axis: Axis, belief: Belief, time: float) -> Belief:
        """Carry an axis on through the commands that act until then."""
        acts = np.array(self._times) + axis.dead_time
        changes = acts[(acts > belief.time) & (acts < time)].tolist()
        white = self._plant.command_white
        for until in (*changes, time):
            if until - belief.time > 1e-9:
                k = int(np.searchsorted(acts, belief.time + 1e-9, side="right")) - 1
                command = float(self._commands[k][i]) if k >= 0 else 0.0
                belief = belief.later(axis, command, until - belief.time, white)
        return belief


def turn(angle: float) -> Float[ndarray, "3 3"]:
    """Return what takes vectors in axes turned counter-clockwise by `angle` (rad) to those before.

    Both are level camera axes.
    """
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
