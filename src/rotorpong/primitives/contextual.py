"""Primitives that depend on the situation, learnt from many demonstrations.

Each demonstration was given in a context c: a goal, the state of a ball, a weight. The weights of a
primitive are a smooth function of it, by kernel ridge regression with a free mean,

    theta(c) = m + sum_n alpha_n k(c, c_n),   alpha = (K_c + rho I)^-1 (Theta - mean)

K_c being the kernel matrix, centred; k(a, b) = a . b ("linear") or exp(-|a - b|^2 / (2 l^2))
("gaussian", the mean of a Gaussian process), on contexts with mean 0 and deviation 1. rho and l are
those of the least leave-one-out error, which needs no refit,

    error_n = (Theta - H Theta)_n / (1 - H_nn),   H = 1/N + K_c (K_c + rho I)^-1,

and is counted in metres of the motions, not in weights. Whatever the context, theta is a sum of the
demonstrations' weights, so that the goal is met as exactly as by each of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.primitives.dmp import Dmp
from rotorpong.primitives.documents import numbers, read_document, write_document
from rotorpong.primitives.shapes import shapes_of

FORMAT = "rotorpong-contextual-library"
VERSION = 1
FEWEST = 3  # demonstrations: one left out, two to tell how the motion changes
RIDGES = np.logspace(-6, 4, 41)  # relative to the mean of k(c_n, c_n); less would cost digits
LENGTHS = (0.5, 0.71, 1.0, 1.41, 2.0, 2.83, 4.0, 5.66, 8.0)  # l, in deviations of the contexts
SMALLEST_LEFT = 1e-9  # of 1 - H_nn, below which rounding errors would judge

Kind = Literal["linear", "gaussian"]
KINDS = ("linear", "gaussian")


@dataclass(frozen=True, slots=True)
class ContextualLibrary:
    """A primitive for every context."""

    kind: Kind
    mean: Float[ndarray, "c"]  # of the contexts
    deviation: Float[ndarray, "c"]
    contexts: Float[ndarray, "n c"]  # of the demonstrations, with mean 0 and deviation 1
    coefficients: Float[ndarray, "n basis d"]  # alpha
    offset: Float[ndarray, "basis d"]  # m
    length: float  # l; unused by "linear"
    ridge: float  # rho
    left_out_error: float  # m, root mean square over demonstrations, coordinates and time

    @classmethod
    def fit(
        cls,
        contexts: Float[ndarray, "n c"],
        primitives: Sequence[Dmp],
        *,
        kind: Kind = "gaussian",
    ) -> "ContextualLibrary":
        """Learn from demonstrations, each a context and the primitive fitted to it.

        Raises:
            InputError: fewer than 3, shapes that do not agree, a number that is not finite,
                contexts that are all the same, or an unknown kind.
        """
        _check(contexts, primitives, kind)
        mean, spread = contexts.mean(axis=0), contexts.std(axis=0)
        deviation = np.where(spread > 0.0, spread, 1.0)
        scaled = (contexts - mean) / deviation
        shapes = shapes_of(primitives)
        lengths = LENGTHS if kind == "gaussian" else (1.0,)
        fits = [_Smoother.best(_kernel(kind, scaled, scaled, ell), shapes) for ell in lengths]
        best = int(np.argmin([fit.error for fit in fits]))
        smoother, length = fits[best], lengths[best]
        theta = np.stack([dmp.forcing_gain * dmp.weights for dmp in primitives])
        alpha = np.tensordot(smoother.inverse(), theta - theta.mean(axis=0), axes=1)
        answer = np.tensordot(_kernel(kind, scaled, scaled, length), alpha, axes=1)
        offset = theta.mean(axis=0) - answer.mean(axis=0)
        error = float(np.sqrt(smoother.error / theta.shape[2]))
        return cls(kind, mean, deviation, scaled, alpha, offset, length, smoother.ridge, error)

    def primitive(self, context: Float[ndarray, "c"]) -> Dmp:
        """Return the primitive of a context.

        Raises:
            InputError: other dimensions, or a number that is not finite.
        """
        if np.shape(context) != self.mean.shape or not np.isfinite(context).all():
            raise InputError(f"context {context}: expected {len(self.mean)} finite numbers")
        scaled = ((context - self.mean) / self.deviation)[None]
        k = _kernel(self.kind, scaled, self.contexts, self.length)[0]
        return Dmp(self.offset + np.tensordot(k, self.coefficients, axes=1))

    def save(self, path: str | Path) -> None:
        """Write the library to `path`, whole or not at all; it is read bit for bit.

        Raises:
            InputError: the file cannot be written.
        """
        document: dict[str, Any] = {"format": FORMAT, "version": VERSION, "kind": self.kind}
        document |= {name: getattr(self, name).tolist() for name in ARRAYS}
        document |= {name: getattr(self, name) for name in SCALARS}
        write_document(path, document)

    @classmethod
    def load(cls, path: str | Path) -> "ContextualLibrary":
        """Read a library that `save` wrote.

        Raises:
            InputError: no such file, or one that is damaged or not a contextual library.
        """
        document = read_document(path, FORMAT, VERSION, what="contextual library of primitives")
        try:
            parts: dict[str, Any] = {"kind": document["kind"]}
            parts |= {name: numbers(document[name], dimensions=n) for name, n in ARRAYS.items()}
            parts |= {name: float(numbers(document[name], dimensions=0)) for name in SCALARS}
            _check_parts(parts)
            library = cls(**parts)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise InputError(f"{path}: damaged contextual library ({error})") from error
        return library


ARRAYS = {"mean": 1, "deviation": 1, "contexts": 2, "coefficients": 3, "offset": 2}  # and axes
SCALARS = ("length", "ridge", "left_out_error")


@dataclass(frozen=True, slots=True)
class _Smoother:
    """H of one kernel matrix and ridge, by the eigenvectors of K_c."""

    vectors: Float[ndarray, "n n"]
    values: Float[ndarray, "n"]
    ridge: float
    error: float  # mean square of what leaving one out does to its motion

    @classmethod
    def best(cls, kernel: Float[ndarray, "n n"], shapes: Float[ndarray, "n m"]) -> "_Smoother":
        n = len(kernel)
        centred = kernel - kernel.mean(axis=0) - kernel.mean(axis=1)[:, None] + kernel.mean()
        values, vectors = np.linalg.eigh(centred)
        values = np.maximum(values, 0.0)
        ridges = RIDGES * np.mean(np.diag(kernel))
        scores = vectors.T @ (shapes - shapes.mean(axis=0))
        errors = []
        for ridge in ridges:
            kept = values / (values + ridge)
            misses = vectors @ ((1.0 - kept)[:, None] * scores)
            left = 1.0 - 1.0 / n - vectors**2 @ kept
            judged = left.min() > SMALLEST_LEFT
            errors.append(np.mean(np.sum((misses.T / left) ** 2, axis=0)) if judged else np.inf)
        best = len(errors) - 1 - int(np.argmin(errors[::-1]))  # ties go to the smoother
        return cls(vectors, values, float(ridges[best]), float(errors[best]))

    def inverse(self) -> Float[ndarray, "n n"]:
        """Return (K_c + rho I)^-1."""
        return self.vectors / (self.values + self.ridge) @ self.vectors.T


def _kernel(
    kind: Kind, a: Float[ndarray, "n c"], b: Float[ndarray, "m c"], length: float
) -> Float[ndarray, "n m"]:
    if kind == "linear":
        return a @ b.T
    squares = np.sum((a[:, None] - b) ** 2, axis=2)
    return np.exp(-0.5 * squares / length**2)


def _check(contexts: Float[ndarray, "n c"], primitives: Sequence[Dmp], kind: Kind) -> None:
    if kind not in KINDS:
        raise InputError(f"kind {kind!r}: expected one of {', '.join(KINDS)}")
    if np.ndim(contexts) != 2 or len(contexts) != len(primitives):
        raise InputError(
            f"contexts of shape {np.shape(contexts)}: expected ({len(primitives)}, c), one per "
            f"primitive"
        )
    if len(primitives) < FEWEST:
        raise InputError(f"{len(primitives)} demonstrations: expected at least {FEWEST}")
    if not np.isfinite(contexts).all():
        raise InputError("contexts: expected finite numbers only")
    if not np.ptp(contexts, axis=0).any():
        raise InputError("contexts that are all the same: expected some that differ")


def _check_parts(parts: dict[str, Any]) -> None:
    n, c = parts["contexts"].shape
    right = (
        parts["kind"] in KINDS
        and parts["mean"].shape == parts["deviation"].shape == (c,)
        and parts["coefficients"].shape == (n, *parts["offset"].shape)
        and (parts["deviation"] > 0.0).all()
        and parts["length"] > 0.0
    )
    if not right:
        raise ValueError("parts that do not belong together")
