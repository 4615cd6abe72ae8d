"""A motion in flight, whose goal and arrival can change at any time.

A flight goes in legs; a leg begins at the start or where the goal changed, at the phase x_0, and
ends at the arrival, after R seconds. With q the fraction of the leg and x the clock of the phase,

    x = x_0 + (1 - x_0) q,   dx/dt = (1 - x_0) / R = 1 / tau
    s = g(q) + eta Phi(x) theta + h(x)

tau is the duration that the whole motion would have at this pace; in the first leg x_0 = 0, h = 0.
e = s - g obeys Eq. (4) in x, e'' + alpha_s e' + alpha_s beta_s e = eta u, whatever the clock does.

When only the goal changes, the quintic g is laid anew from its own present state to the new goal,
and e goes on untouched. When the arrival changes too, the clock changes pace from 1/tau to 1/tau_2,
and with it de/dt = e' / tau would jump. A solution of the homogeneous equation keeps it:

    h(x) = (A + (B + a A) (x - x_0)) exp(-a (x - x_0)),   a = alpha_s / 2
    A = h(x_0),   B = h'(x_0) + (e' tau_2 / tau - e'),    both before the change

that is c (x - x_0) exp(-alpha_s (x - x_0) / 2) at the first change. What is left of h at the end is
subtracted from the goal of g, and the new leg's g'' is such that s'' goes on, too: so position,
velocity and acceleration of s are continuous, s solves Eq. (4) on every leg, and it meets the last
goal as exactly as `Dmp.roll_out` does.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.primitives._dmp_kernels import sample_motion
from rotorpong.primitives.basis import STIFFNESS
from rotorpong.primitives.dmp import (
    TIME_TOLERANCE,
    Dmp,
    Motion,
    State,
    finite_vectors,
    moving_target,
)
from rotorpong.primitives.quintic import (
    quintic_coefficients,
    quintic_curvature,
    quintic_slope,
    quintic_value,
)

DECAY = STIFFNESS / 2  # a: both roots of the critically damped equation


@dataclass(frozen=True, slots=True)
class Flight:
    """The present leg of a motion; what lies before it is forgotten."""

    dmp: Dmp
    since: float  # s, when the leg began
    arrival: float  # s, when the goal is met
    phase_clock: float  # x_0, at the beginning of the leg
    target: Float[ndarray, "6 d"]  # coefficients of g in q
    answer: Float[ndarray, "6 pieces d"]  # eta Phi theta, of the whole motion
    echo: Float[ndarray, "2 d"]  # h and dh/dx at the beginning of the leg

    @classmethod
    def begin(
        cls,
        dmp: Dmp,
        start: State,
        goal: State,
        duration: float,
        *,
        since: float = 0.0,
        start_acceleration: Float[ndarray, "d"] | None = None,
    ) -> "Flight":
        """Return the motion that `dmp.roll_out` samples, beginning at `since` (s).

        Raises:
            InputError: as `Dmp.roll_out`, or `since` is not finite.
        """
        if not np.isfinite(since):
            raise InputError(f"since {since} s: expected a finite number")
        target = moving_target(dmp, start, goal, duration, start_acceleration)
        nothing = np.zeros((2, target.shape[1]))
        end = float(since) + float(duration)
        return cls(dmp, float(since), end, 0.0, target, dmp.answer(), nothing)

    @property
    def pace(self) -> float:
        """The rate of the phase's clock, dx/dt = 1 / tau, 1/s."""
        return (1.0 - self.phase_clock) / (self.arrival - self.since)

    def at(self, times: Float[ndarray, "n"]) -> Motion:
        """Return the motion at `times` (s), from the beginning of the leg to the arrival.

        Raises:
            InputError: a time lies outside the leg.
        """
        instants = self._instants(times)
        q = np.clip((instants - self.since) / (self.arrival - self.since), 0.0, 1.0)
        return Motion(instants, *self._states(q))

    def regoal(self, time: float, goal: State, arrival: float | None = None) -> "Flight":
        """Return the flight that turns to another goal, without a jump.

        Args:
            time: s, now: within the leg, before its end.
            goal: state at the new arrival; it may be the old one.
            arrival: s, after `time`; the old one by default.

        Raises:
            InputError: the time lies outside the leg or the motion is over, the arrival is not
                after it, a number is not finite or dimensions differ.
        """
        arrival = self.arrival if arrival is None else float(arrival)
        if not (self.since - TIME_TOLERANCE <= time < self.arrival - TIME_TOLERANCE):
            raise InputError(
                f"time {time} s: expected one from {self.since} s to before {self.arrival} s"
            )
        if not (np.isfinite(arrival) and arrival > time + TIME_TOLERANCE):
            raise InputError(f"arrival {arrival} s: expected a time after {time} s")
        last = goal.velocity if goal.acceleration is None else goal.acceleration
        finite_vectors((goal.position, goal.velocity, last), self.target.shape[1])
        q = np.array([max(time - self.since, 0.0) / (self.arrival - self.since)])
        turned = replace(
            self,
            since=float(time),
            arrival=arrival,
            phase_clock=self.phase_clock + (1.0 - self.phase_clock) * float(q[0]),
        )
        turned = replace(turned, echo=self._echo_of(turned, q))
        return replace(turned, target=turned._target_from(self._states(q)[:, 0], goal))

    def _instants(self, times: Float[ndarray, "n"]) -> Float[ndarray, "n"]:
        instants = np.asarray(times, dtype=float)
        if instants.ndim != 1:
            raise InputError(f"times of shape {instants.shape}: expected (n,)")
        early, late = self.since - TIME_TOLERANCE, self.arrival + TIME_TOLERANCE
        inside = (instants >= early) & (instants <= late)
        if not inside.all():
            outside = instants[np.argmin(inside)]
            raise InputError(
                f"time {outside} s: expected one from {self.since} s to {self.arrival} s"
            )
        return instants

    def _states(self, q: Float[ndarray, "n"]) -> Float[ndarray, "3 n d"]:
        """Return s and its derivatives in time."""
        left, pace, column = self.arrival - self.since, self.pace, q[:, None]
        lag = self._answer_at(q) + self._echo_at(q)
        return np.stack(
            [
                quintic_value(self.target, column) + lag[0],
                quintic_slope(self.target, column) / left + pace * lag[1],
                quintic_curvature(self.target, column) / left**2 + pace**2 * lag[2],
            ]
        )

    def _answer_at(self, q: Float[ndarray, "n"]) -> Float[ndarray, "3 n d"]:
        """Return eta Phi theta and its derivatives in x."""
        x = np.clip(self.phase_clock + (1.0 - self.phase_clock) * q, 0.0, 1.0)
        states = np.empty((3, len(q), self.target.shape[1]))
        sample_motion(np.zeros_like(self.target), self.answer, x, *states)
        return states

    def _echo_at(self, q: Float[ndarray, "n"]) -> Float[ndarray, "3 n d"]:
        """Return h and its derivatives in x."""
        a, b = self.echo
        c = b + DECAY * a
        y = (1.0 - self.phase_clock) * q[:, None]
        fade = np.exp(-DECAY * y)
        slope = b - DECAY * c * y
        return np.stack([(a + c * y) * fade, slope * fade, -DECAY * (c + slope) * fade])

    def _echo_of(self, turned: "Flight", q: Float[ndarray, "1"]) -> Float[ndarray, "2 d"]:
        """Return h and dh/dx with which the turned flight keeps the rate of e."""
        slope = self._answer_at(q)[1, 0]
        h, h_slope, _ = self._echo_at(q)[:, 0]
        faster = self.pace / turned.pace
        return np.stack([h, h_slope + (slope + h_slope) * (faster - 1.0)])

    def _target_from(self, state: Float[ndarray, "3 d"], goal: State) -> Float[ndarray, "6 d"]:
        """Return g of this leg: from the motion's state less e and h, to the goal less h."""
        ends = np.array([0.0, 1.0])
        answer = self._answer_at(ends)
        answer[:2, 1] = 0.0  # where it is not zero, the primitive misses its goal by itself
        last = goal.acceleration
        if last is None:
            answer[2, 1], last = 0.0, np.zeros_like(goal.position)
        lag = answer + self._echo_at(ends)
        left = self.arrival - self.since
        in_leg = left ** np.arange(3.0)[:, None]
        in_clock = (left * self.pace) ** np.arange(3.0)[:, None]
        end = np.stack([goal.position, goal.velocity, last])
        return quintic_coefficients(
            state * in_leg - lag[:, 0] * in_clock, end * in_leg - lag[:, 1] * in_clock
        )
