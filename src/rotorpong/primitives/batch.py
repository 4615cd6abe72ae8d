"""Many primitives towards many goals in many durations, at once.

    s_km(x) = g_m(x) + eta_k Phi(x) theta_k,   x = 0 ... 1 in equal steps

What a primitive adds at these fractions is the same for every goal and duration, so it is looked up
once per library; the target of a goal is the same for every primitive, so it is evaluated once per
goal. What is left is one sum per number.

Axes: k primitives, g goals, durations of each if there are several, n instants, d coordinates. In
memory the instants come last, so that a coordinate's samples are neighbours.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.primitives._batch_kernels import fill_motions, find_peaks
from rotorpong.primitives._dmp_kernels import sample_motion
from rotorpong.primitives.dmp import Dmp, State
from rotorpong.primitives.library import Library
from rotorpong.primitives.mixing import require_alike
from rotorpong.primitives.quintic import quintic_coefficients

DERIVATIVES = (0, 1, 2)


@dataclass(frozen=True, slots=True)
class States:
    """Many states, one per goal."""

    position: Float[ndarray, "g d"]  # m
    velocity: Float[ndarray, "g d"]  # m/s


@dataclass(frozen=True, slots=True)
class Motions:
    """Many trajectories, sampled at the same fractions of their durations."""

    fractions: Float[ndarray, "n"]  # of the duration
    durations: Float[ndarray, "*goals"]  # s; times are fractions * duration
    position: Float[ndarray, "k *goals n d"]  # m
    velocity: Float[ndarray, "k *goals n d"] | None = None  # m/s
    acceleration: Float[ndarray, "k *goals n d"] | None = None  # m/s^2


@dataclass(frozen=True, slots=True)
class Peaks:
    """The fastest and the hardest instant among the samples of each motion, by norm."""

    speed: Float[ndarray, "k *goals"]  # m/s
    acceleration: Float[ndarray, "k *goals"] | None = None  # m/s^2


@dataclass(frozen=True, slots=True)
class Batch:
    """What K primitives add to their targets at n fractions of a duration."""

    fractions: Float[ndarray, "n"]
    answers: Float[ndarray, "3 k d n"]  # eta Phi theta and its derivatives in the fraction

    @classmethod
    def of(cls, primitives: Library | Sequence[Dmp], *, samples: int = 240) -> "Batch":
        """Look up the primitives at `samples` equal steps, both ends included.

        Raises:
            InputError: no primitives, or of different shapes, or fewer than 2 samples.
        """
        if samples < 2:
            raise InputError(f"samples {samples}: expected at least 2, the ends")
        dmps = primitives.primitives if isinstance(primitives, Library) else tuple(primitives)
        require_alike(dmps)
        fractions = np.linspace(0.0, 1.0, samples)
        answers = np.stack([_answers(dmp, fractions) for dmp in dmps], axis=1)
        return cls(fractions, np.ascontiguousarray(answers.swapaxes(-1, -2)))

    def roll_out(
        self,
        starts: State | States,
        goals: State | States,
        durations: Float[ndarray, "*goals"],
        *,
        derivatives: int = 1,
        out: Motions | None = None,
    ) -> Motions:
        """Return the motion of every primitive to every goal in its durations.

        Args:
            starts: one for all goals, or one per goal.
            goals: one for all durations, or one per goal.
            durations: s; (g,) one per goal, or (g, m) several for each.
            derivatives: 0 for positions, 1 with velocities, 2 with accelerations.
            out: motions of an earlier call of the same shape: they are written over.

        Raises:
            InputError: shapes that do not agree, a duration that is not positive, a number that is
                not finite, other derivatives.
        """
        if derivatives not in DERIVATIVES:
            raise InputError(f"derivatives {derivatives!r}: expected one of 0, 1, 2")
        targets, taus = self._targets(starts, goals, durations)
        shape = (self.answers.shape[1], *durations.shape, *self.answers.shape[2:])
        arrays = _memory(shape, derivatives, out)
        for order, array in enumerate(arrays):
            flat = array.reshape(shape[0], len(taus), *shape[-2:])
            fill_motions(*self._terms(targets, taus, order), flat)
        return Motions(self.fractions, durations, *(array.swapaxes(-1, -2) for array in arrays))

    def peaks(
        self,
        starts: State | States,
        goals: State | States,
        durations: Float[ndarray, "*goals"],
        *,
        accelerations: bool = False,
    ) -> Peaks:
        """Return how fast each motion gets at its samples, without keeping the motions.

        Arguments and errors are those of `roll_out`. Between samples a motion may be faster:
        `rotorpong.primitives.limits` finds the peak itself.
        """
        targets, taus = self._targets(starts, goals, durations)
        shape = (self.answers.shape[1], *durations.shape)
        found = np.empty((1 + accelerations, shape[0], len(taus)))
        for order, row in enumerate(found, start=1):
            find_peaks(*self._terms(targets, taus, order), row)
        return Peaks(*(row.reshape(shape) for row in found))

    def _targets(
        self, starts: State | States, goals: State | States, durations: Float[ndarray, "*goals"]
    ) -> tuple[Float[ndarray, "6 m d"], Float[ndarray, "m"]]:
        """Return the coefficients of every target, and the durations, in one row."""
        if np.ndim(durations) not in (1, 2):
            raise InputError(
                f"durations of shape {np.shape(durations)}: expected (goals,) or (goals, several)"
            )
        if not (np.isfinite(durations) & (durations > 0.0)).all():
            raise InputError("durations: expected positive numbers of seconds only")
        d = self.answers.shape[2]
        taus = np.ravel(durations)
        several = len(taus) // max(len(durations), 1)
        ends = np.zeros((4, len(taus), d))
        for i, (name, given) in enumerate((("starts", starts), ("goals", goals))):
            if isinstance(given, State) and given.acceleration is not None:
                raise InputError(f"{name} with an acceleration: expected none in a batch")
            for j, array in enumerate((given.position, given.velocity)):
                ends[2 * i + j] = np.repeat(_per_goal(name, array, len(durations), d), several, 0)
        if not np.isfinite(ends).all():
            raise InputError("starts and goals: expected finite numbers only")
        rest, tau = np.zeros((len(taus), d)), taus[:, None]
        start, end = (np.stack([ends[i], ends[i + 1] * tau, rest]) for i in (0, 2))
        return quintic_coefficients(start, end), taus

    def _terms(
        self, targets: Float[ndarray, "6 m d"], taus: Float[ndarray, "m"], order: int
    ) -> tuple[ndarray, ndarray, ndarray, ndarray]:
        """Return target, scale, fractions and answers of a derivative in time."""
        scales = taus ** -float(order)
        terms = targets
        for _ in range(order):
            terms = terms[1:] * np.arange(1.0, len(terms))[:, None, None]
        padded = np.zeros_like(targets)
        padded[: len(terms)] = terms * scales[:, None]
        layout = np.ascontiguousarray(padded.swapaxes(0, 1))
        return layout, scales, self.fractions, self.answers[order]


def _answers(dmp: Dmp, fractions: Float[ndarray, "n"]) -> Float[ndarray, "3 n d"]:
    states = np.empty((3, len(fractions), dmp.weights.shape[1]))
    sample_motion(np.zeros((6, states.shape[2])), dmp.answer(), fractions, *states)
    return states


def _per_goal(name: str, array: ndarray, goals: int, dimensions: int) -> Float[ndarray, "g d"]:
    if array.shape not in ((dimensions,), (goals, dimensions)):
        raise InputError(
            f"{name} of shape {array.shape}: expected ({dimensions},) or ({goals}, {dimensions}), "
            f"as durations and primitives have"
        )
    return np.broadcast_to(array, (goals, dimensions))


def _memory(shape: tuple[int, ...], derivatives: int, out: Motions | None) -> list[ndarray]:
    """Return an array for each derivative, of the motions given or new."""
    if out is None:
        return [np.empty(shape) for _ in range(derivatives + 1)]
    arrays = []
    for given in (out.position, out.velocity, out.acceleration)[: derivatives + 1]:
        memory = None if given is None else given.swapaxes(-1, -2)
        if memory is None or memory.shape != shape or not memory.flags.c_contiguous:
            raise InputError(f"out: expected the motions of an earlier call of shape {shape}")
        arrays.append(memory)
    return arrays
