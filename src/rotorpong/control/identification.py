"""What a drone's constants are, learnt while it flies: gain, lag and dead time of each axis.

For held commands u_m, sent at t_m after a hover, an axis of `plant` has the velocity

    v(t) = g sum_m (u_m - u_{m-1}) S((t - t_m - D) / tau)

with S the answer of G to a unit step at tau = 1. Navdata show y = v + b + noise, with a bias b of
each serve. Each frame's mean of y is one observation of theta = (g, tau, D, b), linearised about
what is known:

    H = dv/dtheta,  K = P H' / (r + H P H'),  theta += K (y - v),  P -= K H P

recursive least squares (Gauss-Newton, of the error of the output, which unlike a regression on
measured velocities is not biased by their noise). r is the variance of the mean, plus that of what
the noise of commands does to the velocity, plus that of what a linear model leaves of a transient:
a tenth of how far the velocity is from what is asked, for tilt and thrust have limits. Where
nothing moves, H is zero but for b, and nothing is learnt. A player begins every serve with the
prior, so that serves do not depend on their order; who carries knowledge on (`renewed`, `bench
control`) forgets some of it from serve to serve: P / forgetting, no more than the prior's.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.control.plant import Answer, Axis, Plant
from rotorpong.conventions import CAMERA_FROM_BODY_AXES, InputError
from rotorpong.drone import Navdata

GAIN_SD, LAG_SD = 0.05, 0.20  # relative, of what is known before
DEAD_TIME_SD = 0.02  # s
BIAS_SD = 0.03  # m/s, at least: what optical flow is off
FORGETTING = 0.9  # of a serve to the next
SMALLEST = 0.2  # of prior gain and lag, below which no estimate goes
PARTING = 1e-5  # of roots that coincide
NONLINEAR = 0.1  # of a transient
MOST_OFF = 4.0  # standard deviations: an observation beyond counts as one at


@dataclass(frozen=True, slots=True)
class Identification:
    """What is known of a drone's constants; gain, lag, dead time, bias of each axis."""

    plant: Plant
    mean: Float[ndarray, "3 4"]
    covariance: Float[ndarray, "3 4 4"]

    @classmethod
    def prior(cls, plant: Plant) -> "Identification":
        """Return what is known before anything was flown."""
        mean = np.array([[a.gain, a.lag, a.dead_time, 0.0] for a in plant.axes])
        bias = max(BIAS_SD, plant.velocity_bias)
        sd = np.array([[GAIN_SD * a.gain, LAG_SD * a.lag, DEAD_TIME_SD, bias] for a in plant.axes])
        return cls(plant, mean, np.stack([np.diag(row**2) for row in sd]))

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """The axes as far as they are known."""
        right, down, forward = (
            prior.scaled(lag, gain, dead_time)
            for prior, (gain, lag, dead_time, _) in zip(
                self.plant.axes, self.mean.tolist(), strict=True
            )
        )
        return right, down, forward

    @property
    def sd(self) -> Float[ndarray, "3 4"]:
        """Standard deviations of what is known."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    def renewed(self, forgetting: float = FORGETTING) -> "Identification":
        """Return what of this counts in the next serve.

        Raises:
            InputError: `forgetting` is not in (0, 1].
        """
        if not 0.0 < forgetting <= 1.0:
            raise InputError(f"forgetting {forgetting}: expected a number from 0 to 1, not 0")
        fresh = Identification.prior(self.plant)
        mean = np.column_stack([self.mean[:, :3], fresh.mean[:, 3]])
        known = self.covariance / forgetting
        known[:, 3, :], known[:, :, 3] = 0.0, 0.0
        known[:, 3, 3] = fresh.covariance[:, 3, 3]
        shrink = np.sqrt(np.minimum(1.0, fresh.sd**2 / np.diagonal(known, axis1=1, axis2=2)))
        return replace(self, mean=mean, covariance=known * shrink[:, :, None] * shrink[:, None, :])

    def updated(
        self,
        commands: Float[ndarray, "m 4"],
        times: Float[ndarray, "n"],
        velocities: Float[ndarray, "n 3"],
    ) -> "Identification":
        """Return what is known after one more observation, the mean of n measured velocities.

        Args:
            commands: time (s) and right, down, forward (m/s) of all that was sent in this serve,
                oldest first.
            times: s, at which the drone had those velocities.
            velocities: m/s, level camera axes.

        Raises:
            InputError: a number is not finite.
        """
        _require(commands, times, velocities)
        if not len(times):
            return self
        plant = self.plant
        noise = plant.velocity_white**2 / len(times) + plant.command_white**2
        noise += plant.command_offset**2
        mean, covariance = self.mean.copy(), self.covariance.copy()
        for i, prior in enumerate(plant.axes):
            predicted, slope = expected(prior, self.mean[i], commands[:, [0, 1 + i]], times)
            p_h = covariance[i] @ slope
            asked = self.mean[i, 0] * (commands[-1, 1 + i] if len(commands) else 0.0)
            left = NONLINEAR * (asked + self.mean[i, 3] - predicted)
            spread = noise + left**2 + slope @ p_h
            off = velocities[:, i].mean() - predicted
            most = MOST_OFF * math.sqrt(spread)
            mean[i] += p_h / spread * min(max(off, -most), most)
            updated = covariance[i] - np.outer(p_h, p_h) / spread
            covariance[i] = (updated + updated.T) / 2
        gains, lags = np.array([[a.gain, a.lag] for a in plant.axes]).T
        mean[:, 0] = np.maximum(mean[:, 0], SMALLEST * gains)
        mean[:, 1] = np.maximum(mean[:, 1], SMALLEST * lags)
        mean[:, 2] = np.maximum(mean[:, 2], 0.0)
        return replace(self, mean=mean, covariance=covariance)


def expected(
    shape: Axis,
    theta: Float[ndarray, "4"],
    commands: Float[ndarray, "m 2"],
    times: Float[ndarray, "n"],
) -> tuple[float, Float[ndarray, "4"]]:
    """Return the mean velocity expected at `times`, m/s, and its slope by theta.

    Args:
        shape: axis whose answer this is, at its own pace.
        theta: gain, lag (s), dead time (s), bias (m/s).
        commands: time (s) and command (m/s), oldest first; a hover before.
        times: s.
    """
    gain, lag, dead_time, bias = theta.tolist()
    steps = np.diff(commands[:, 1], prepend=0.0)
    since = np.maximum(times[:, None] - commands[:, 0] - dead_time, 0.0)
    answer, slope = step_answer(shape.answer_at(lag), since)
    reached, rate = (answer @ steps).mean(), (slope @ steps).mean()
    slower = -((slope * since) @ steps).mean() / lag
    return gain * reached + bias, np.array([reached, gain * slower, -gain * rate, 1.0])


def step_answer(
    answer: Answer, since: Float[ndarray, "n m"]
) -> tuple[Float[ndarray, "n m"], Float[ndarray, "n m"]]:
    """Return the velocity after a unit step, `since` (s) ago, and its rate (1/s).

    With N / D the answer, d the first coefficient of D and p_i its roots,

        S(t) = 1 + sum_i r_i exp(p_i t),   r_i = N(p_i) / (p_i d prod_(j != i) (p_i - p_j))

    Roots that coincide are parted by 1e-5 of their size.
    """
    numerator, denominator = answer
    poles = np.roots(denominator).astype(complex)
    poles *= 1.0 + PARTING * np.arange(len(poles))
    apart = poles[:, None] - poles
    np.fill_diagonal(apart, 1.0)
    shares = np.polyval(numerator, poles) / (poles * denominator[0] * apart.prod(axis=1))
    parts = shares * np.exp(poles * since[..., None])
    return 1.0 + parts.sum(axis=-1).real, (parts @ poles).real * (since > 0.0)


class Record:
    """The commands of one serve, and what navdata make of them."""

    def __init__(self, plant: Plant) -> None:
        """Begin with a hover."""
        self._plant = plant
        self._commands: list[Float[ndarray, "4"]] = []

    def add(self, time: float, velocity: Float[ndarray, "3"]) -> None:
        """Note what was sent at `time` (s): right, down, forward, m/s."""
        self._commands.append(np.append(time, velocity))

    def learnt(self, known: Identification, navdata: Navdata) -> Identification:
        """Return what is known after these navdata; they teach nothing before the first command."""
        if not self._commands:
            return known
        moved = navdata.velocity @ CAMERA_FROM_BODY_AXES.T
        times = navdata.times - self._plant.velocity_delay
        return known.updated(np.stack(self._commands), times, moved)


def _require(commands: ndarray, times: ndarray, velocities: ndarray) -> None:
    if not all(np.isfinite(numbers).all() for numbers in (commands, times, velocities)):
        raise InputError("commands, times or velocities: expected finite numbers")
