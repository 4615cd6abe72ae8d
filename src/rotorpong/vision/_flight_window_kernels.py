"""The fit of `flight_filter` to a window of sights, compiled, and a filter along the fit."""

import math

import numpy as np

from rotorpong.kernels import kernel
from rotorpong.vision._flight_filter_kernels import (
    FLOWN,
    INPUTS,
    LEVEL,
    MOVING,
    SIZE,
    TILT,
    carry,
    flow_slopes,
    inputs_of,
    look,
)

WINDOW_STEPS, LEAST_SHARE = 15, 1e-3
WINDOW_CONVERGED = 1e-3  # what another step would lower the cost by


@kernel
def linearise(sights, law, table, mean, errors, slopes):
    """Write what all sights of a flight miss, and the slopes of their sights; False if one cannot.

    Args:
        sights: (n, 25) time since the first; X/Z, Y/Z, angular radius; their covariance; pose.
        law: the air.
        table: (3,).
        mean: (16,) at the first sight.
        errors: (3 n,), written.
        slopes: (3 n, 16), written.
    """
    work, flow_s = np.empty((3, FLOWN)), np.empty((FLOWN, INPUTS))
    expected, look_s = np.empty(3), np.empty((3, SIZE))
    now, chain, onward = mean.copy(), np.eye(SIZE), np.eye(SIZE)
    for n in range(sights.shape[0]):
        dt = sights[n, 0] - (sights[n - 1, 0] if n > 0 else 0.0)
        if dt > 0.0:
            flow_slopes(inputs_of(now, table), dt, law, flow_s, work)
            now[:FLOWN] = work[0]
            onward[:FLOWN, :MOVING] = flow_s[:, :MOVING]
            chain = onward @ chain
        if not (np.isfinite(now).all() and look(now, sights[n, 13:], expected, look_s)):
            return False
        errors[3 * n : 3 * n + 3] = sights[n, 1:4] - expected
        slopes[3 * n : 3 * n + 3] = look_s @ chain
    return True


@kernel
def weights_of(sights, slopes, walk):
    """Return the inverse covariance (3 n, 3 n) of all sights.

    The gyro's attitude walks away from that of the first sight: sights i and j have in common
    what it walked until the earlier of them.
    """
    count = sights.shape[0]
    spread = np.zeros((3 * count, 3 * count))
    if walk == 0.0:
        for i in range(count):
            own = sights[i, 4:13].copy().reshape(3, 3)
            spread[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = np.linalg.inv(own)
        return np.asfortranarray(spread)
    for i in range(count):
        for j in range(count):
            shared = walk**2 * min(sights[i, 0], sights[j, 0])
            for a in range(3):
                for b in range(3):
                    x, y = slopes[3 * i + a, TILT:LEVEL], slopes[3 * j + b, TILT:LEVEL]
                    value = shared * (x[0] * y[0] + x[1] * y[1] + x[2] * y[2])
                    spread[3 * i + a, 3 * j + b] = value
        for a in range(3):
            for b in range(3):
                spread[3 * i + a, 3 * i + b] += sights[i, 4 + 3 * a + b]
    return np.linalg.inv(spread)


@kernel
def window(prior, root, sights, law, table, walk, mean, covariance):
    """Fit one flight to all sights by Gauss-Newton steps, in place; return twice the cost.

    A step that makes it worse is halved.

    Args:
        prior: (16,) at the first sight's time.
        root: (16, 16) inverse of the prior's covariance.
        sights: as `linearise` takes them.
        law: the air.
        table: (3,).
        walk: rad/sqrt(s), of the gyro's attitude.
        mean: (16,) first guess; the fit.
        covariance: (16, 16), written: that of the fit.
    """
    errors, slopes = np.empty(3 * sights.shape[0]), np.empty((3 * sights.shape[0], SIZE))
    if not linearise(sights, law, table, mean, errors, slopes):
        return math.inf
    weights = weights_of(sights, slopes, walk)
    away = prior - mean
    cost = away @ root @ away + errors @ weights @ errors
    for _ in range(WINDOW_STEPS):
        weighted = slopes.T @ weights
        normal, pull = root + weighted @ slopes, root @ away + weighted @ errors
        covariance[:] = np.linalg.inv(normal)
        shift = covariance @ pull
        gain, share, better = shift @ pull, 1.0, False
        after, new = mean, cost
        while share > LEAST_SHARE and not better:
            after = mean + share * shift
            if linearise(sights, law, table, after, errors, slopes):
                away = prior - after
                new = away @ root @ away + errors @ weights @ errors
                better = new <= cost + WINDOW_CONVERGED
            share *= 0.5
        if not better:
            return cost
        mean[:], cost = after, new
        if gain < WINDOW_CONVERGED:
            break
    return cost


@kernel
def follow(prior, sights, law, table, spreads, walks, mean, covariance, levels):
    """Filter all sights, linear about one flight, in place; False if one of them cannot be.

    Args:
        prior: (16,) at the first sight's time, whose covariance `covariance` is.
        sights: as `linearise` takes them.
        law: the air.
        table: (3,).
        spreads: (3,) standard deviations of those.
        walks: as `predict` takes them.
        mean: (16,) where the flight begins; what is known at the last sight.
        covariance: (16, 16) its covariance.
        levels: (n,), written: NIS of each sight.
    """
    expected, slopes = np.empty(3), np.empty((3, SIZE))
    away, onward = prior - mean, np.empty((SIZE, SIZE))
    for n in range(sights.shape[0]):
        dt = sights[n, 0] - (sights[n - 1, 0] if n > 0 else 0.0)
        if dt > 0.0:
            carry(mean, covariance, dt, law, table, spreads, walks, onward)
            away = onward @ away
        if not (np.isfinite(mean).all() and look(mean, sights[n, 13:], expected, slopes)):
            return False
        noise = np.empty((3, 3))
        for a in range(3):
            for b in range(3):
                noise[a, b] = sights[n, 4 + 3 * a + b]
        across = covariance @ slopes.T
        inverse = np.linalg.inv(slopes @ across + noise)
        error = sights[n, 1:4] - expected - slopes @ away
        levels[n] = error @ inverse @ error
        gain = across @ inverse
        away = away + gain @ error
        kept = np.eye(SIZE) - gain @ slopes
        covariance[:] = kept @ covariance @ kept.T + gain @ noise @ gain.T
    mean += away
    return True
