"""Dynamic motor primitives with a moving target, solved in closed form.

    tau dz/dt = -alpha_z z                                                  Eq. (3a)
    tau^2 s'' = alpha_s (beta_s (g - s) + tau (g' - s')) + tau^2 g'' + eta u  Eq. (4)
    g(t) = sum_i b_i t^i, i = 0..5                                          Eq. (5)
    u = sum_k theta_k psi_k(z) z

tau is the duration of the motion, t real time since its start, g the quintic from the start's to
the goal's position and velocity, with the start's acceleration (0 unless given) and none at the
goal. As g starts where the robot is, e = s - g obeys a linear equation that knows neither goal nor
duration, so Eq. (4) is exactly

    s(t) = g(t) + eta Phi(t / tau) theta,    s'(t) = g'(t) + eta / tau Phi'(t / tau) theta

with Phi of `rotorpong.primitives.basis`. `integrate_dmp` solves Eq. (4) step by step and is kept as
the tested reference. Any frame, SI units, d coordinates side by side; (n, d) for n instants.

As Phi'' theta is not zero at the ends, the motion's acceleration there is not that of g. A state
that has an acceleration means the motion's own: g is then laid so that s leaves with it (a measured
one, say), or arrives with it (none, say).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.integrate import solve_ivp

from rotorpong.conventions import InputError
from rotorpong.primitives._dmp_kernels import sample_motion
from rotorpong.primitives.basis import (
    DAMPING,
    PHASE_DECAY,
    STIFFNESS,
    forcing_features,
    response_table,
)
from rotorpong.primitives.quintic import (
    quintic_coefficients,
    quintic_curvature,
    quintic_slope,
    quintic_value,
)

TIME_TOLERANCE = 1e-9  # s, how far beyond the ends a time may lie and still mean the end
REFERENCE_TOLERANCE = 1e-12  # relative and absolute, of the reference integrator


@dataclass(frozen=True, slots=True)
class State:
    """Where a robot is and how it moves."""

    position: Float[ndarray, "d"]  # m
    velocity: Float[ndarray, "d"]  # m/s
    acceleration: Float[ndarray, "d"] | None = None  # m/s^2; None if it may be any


@dataclass(frozen=True, slots=True)
class Motion:
    """A trajectory, sampled."""

    times: Float[ndarray, "n"]  # s since the start of the motion
    position: Float[ndarray, "n d"]  # m
    velocity: Float[ndarray, "n d"]  # m/s
    acceleration: Float[ndarray, "n d"] | None = None  # m/s^2; what is measured may have none


@dataclass(frozen=True, slots=True)
class Dmp:
    """A primitive: the shape of a motion, free of its start, goal and duration."""

    weights: Float[ndarray, "basis d"]  # theta
    forcing_gain: float | Float[ndarray, "d"] = 1.0  # eta, of all coordinates or of each
    ends: Motion | None = None  # first and last state of the demonstration, as the fit saw them

    def roll_out(
        self,
        start: State,
        goal: State,
        duration: float,
        times: Float[ndarray, "n"],
        *,
        start_acceleration: Float[ndarray, "d"] | None = None,
    ) -> Motion:
        """Return the motion from `start` to `goal`, by the closed form.

        Args:
            start: state at time 0.
            goal: state at time `duration`; met exactly if the weights came from
                `fit_dmp(method="position")` or mixtures of such.
            duration: tau, s.
            times: s, within [0, duration], in any order.
            start_acceleration: of the moving target at time 0, m/s^2; none by default.

        Raises:
            InputError: a time lies outside the motion, the duration is not positive, a number is
                not finite or the dimensions differ.
        """
        target = moving_target(self, start, goal, duration, start_acceleration)
        instants = _instants(times, duration)
        x = np.clip(instants / duration, 0.0, 1.0)
        position, slope, curvature = np.empty((3, len(x), target.shape[1]))
        sample_motion(target, self.answer(), x, position, slope, curvature)
        slope /= duration
        curvature /= duration**2
        return Motion(instants, position, slope, curvature)

    def answer(self) -> Float[ndarray, "6 pieces d"]:
        """Return eta Phi theta: the coefficients of a quintic on each of equal pieces of [0, 1]."""
        return response_table(len(self.weights)) @ (self.forcing_gain * self.weights)


def integrate_dmp(
    dmp: Dmp,
    start: State,
    goal: State,
    duration: float,
    times: Float[ndarray, "n"],
    *,
    start_acceleration: Float[ndarray, "d"] | None = None,
) -> Motion:
    """Solve Eqs. (3a) and (4) step by step in real time, by DOP853: the reference of `roll_out`.

    Arguments and errors are those of `Dmp.roll_out`.
    """
    target = moving_target(dmp, start, goal, duration, start_acceleration)
    instants = _instants(times, duration)
    stops, order = np.unique(np.clip(instants, 0.0, duration), return_inverse=True)
    d = target.shape[1]
    if not len(stops):
        return Motion(instants, *np.empty((3, 0, d)))

    def rates(time: float, state: Float[ndarray, "m"]) -> Float[ndarray, "m"]:
        z, s, v = state[0], state[1 : d + 1], state[d + 1 :]
        x = np.array(time / duration)
        g, g_slope = quintic_value(target, x), quintic_slope(target, x)
        u = forcing_features(state[:1], len(dmp.weights))[0] @ dmp.weights
        pull = STIFFNESS * (DAMPING * (g - s) + g_slope - duration * v)
        push = quintic_curvature(target, x) + dmp.forcing_gain * u
        return np.concatenate([[-PHASE_DECAY * z / duration], v, (pull + push) / duration**2])

    begin = np.concatenate([[1.0], start.position, start.velocity])
    solution = solve_ivp(
        rates,
        (0.0, float(duration)),
        begin,
        method="DOP853",
        t_eval=stops,
        rtol=REFERENCE_TOLERANCE,
        atol=REFERENCE_TOLERANCE,
    )
    states = solution.y.T[order]
    pairs = zip(stops, solution.y.T, strict=True)
    accelerations = np.array([rates(*pair)[d + 1 :] for pair in pairs])
    return Motion(instants, states[:, 1 : d + 1], states[:, d + 1 :], accelerations[order])


def moving_target(
    dmp: Dmp,
    start: State,
    goal: State,
    duration: float,
    start_acceleration: Float[ndarray, "d"] | None = None,
) -> Float[ndarray, "6 d"]:
    """Return the coefficients of g as a polynomial in x = t / duration, Eq. (5).

    Raises:
        InputError: the duration is not positive, a number is not finite, dimensions differ, or the
            start's acceleration is given twice.
    """
    if not (np.isfinite(duration) and duration > 0.0):
        raise InputError(f"duration {duration} s: expected a positive number of seconds")
    if start_acceleration is not None and start.acceleration is not None:
        raise InputError("start_acceleration: expected none, as the start has an acceleration")
    rest = np.zeros(dmp.weights.shape[1])
    first, last = (
        rest if state.acceleration is None else state.acceleration for state in (start, goal)
    )
    first = first if start_acceleration is None else start_acceleration
    vectors = (start.position, start.velocity, first, goal.position, goal.velocity, last)
    start_end = finite_vectors(vectors, len(rest)).reshape(2, 3, len(rest))
    start_end = start_end * np.array([[1.0], [duration], [duration**2]])
    own = [state.acceleration is not None for state in (start, goal)]
    if any(own):
        start_end[own, 2] -= _end_curvatures(dmp)[own]
    return quintic_coefficients(start_end[0], start_end[1])


def finite_vectors(
    vectors: Sequence[Float[ndarray, "_"]], dimensions: int
) -> Float[ndarray, "n d"]:
    """Return vectors of start (position, velocity, acceleration) and goal as one array.

    Raises:
        InputError: one has other dimensions, or a number is not finite.
    """
    for vector in vectors:
        if np.shape(vector) != (dimensions,):
            raise InputError(f"state {vector}: expected {dimensions} numbers, as the primitive has")
    ends = np.array(vectors, dtype=float)
    if not np.isfinite(ends).all():
        raise InputError(f"start {ends[:3]} and goal {ends[3:5]}: expected finite numbers")
    return ends


def _end_curvatures(dmp: Dmp) -> Float[ndarray, "2 d"]:
    """Return eta Phi'' theta at both ends."""
    answer = dmp.answer()
    first = quintic_curvature(answer[:, 0], np.array(0.0))
    last = quintic_curvature(answer[:, -1], np.array(1.0))
    return np.stack([first, last]) * answer.shape[1] ** 2


def _instants(times: Float[ndarray, "n"], duration: float) -> Float[ndarray, "n"]:
    instants = np.asarray(times, dtype=float)
    if instants.ndim != 1:
        raise InputError(f"times of shape {instants.shape}: expected (n,)")
    inside = (instants >= -TIME_TOLERANCE) & (instants <= duration + TIME_TOLERANCE)
    if not inside.all():
        outside = instants[np.argmin(inside)]
        raise InputError(f"time {outside} s: expected 0 to {duration} s, the motion's duration")
    return instants
