"""Commands that bring the blade onto a ball whose whole path is known.

A plan is one command for each coming frame. Plans are flown with the vehicle's own `advance` from
its true state, with the noise that is to come, and judged by the contact rules of the world, so a
plan that hits is known to hit. Three searches, from cheap to dear, until one does:

    direct      one command held; Newton's method in (left, up) for the place where the ball
                passes the blade's plane, differences for the slope, forward and yaw rate zero
    varied      the same from a table of forward speeds and yaw rates at once: the ball is met
                earlier or later, the blade swung sideways
    switched    three commands one after the other, drawn at random about the best so far and
                drawn closer (cross-entropy method): tilting at the last moment lifts the blade
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int64
from numpy import ndarray

from rotorpong.lab.reachable import blade_centre, free_path, hull_size
from rotorpong.physics.reach import plate_crossings, repeated
from rotorpong.physics.vehicle import Track, Vehicle
from rotorpong.world.contact import TICK, Solids, advance, drone_touches_court
from rotorpong.world.simulated_drone import FULL_FACE, Instant

NEWTON_STEPS = 3
NUDGE = 0.2  # share of the limits, for differences
FORWARD = (-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0)  # shares of the limits
YAW = (-1.0, 0.0, 1.0)
SAFE = 0.9  # of the blade's ellipse: what is aimed at needs no look at edges
DRAWS = 48
ROUNDS = 8
ELITE = 8
SEGMENTS = 3
BEHIND = 0.7  # m behind the centre of mass at which a ball is given up
FOUND_ENOUGH = 4  # best plans of a round that are judged by the contact rules
HULL_PENALTY = 3.0

Commands = Float[ndarray, "legs b 4"]


@dataclass(frozen=True, slots=True)
class Plan:
    """Commands at the coming frames, and whether they are known to hit."""

    ticks: Int64[ndarray, "legs"]  # when each is given
    commands: Float[ndarray, "legs 4"]
    hits: bool


@dataclass(frozen=True, slots=True)
class Problem:
    """A vehicle, a ball, and when commands can be given."""

    vehicle: Vehicle
    instant: Instant
    ticks: Int64[ndarray, "legs"]  # of the coming frames, the present one first
    path: Float[ndarray, "n 3"]  # of the ball, from now until nothing can happen any more

    @property
    def horizon(self) -> int:
        """Ticks to fly."""
        return len(self.path) - 1


def problem_of(vehicle: Vehicle, instant: Instant, arrivals: Int64[ndarray, "legs"]) -> Problem:
    """Return the problem of an instant; `arrivals` are the coming frames, the present one first."""
    path = free_path(instant)
    behind = instant.vehicle.position[0] - BEHIND
    gone = np.flatnonzero(path[:, 0] < behind)
    end = int(gone[0]) + 1 if len(gone) else len(path)
    path = path[: max(end, 2)]
    return Problem(vehicle, instant, arrivals[arrivals < instant.tick + len(path) - 1], path)


def search(problem: Problem, rng: np.random.Generator) -> Plan:
    """Return a plan that hits, or the one that comes closest."""
    best, best_score = _held(problem, np.zeros((1, 4))), np.inf
    for commands, scores in _candidates(problem, rng):
        order = np.argsort(scores)[:FOUND_ENOUGH]
        for row in order:
            if scores[row] < best_score:
                best, best_score = commands[:, row : row + 1], float(scores[row])
            if scores[row] < 1.3 and hits(problem, commands[:, row]):
                return Plan(problem.ticks, commands[:, row], hits=True)
    return Plan(problem.ticks, best[:, 0], hits=False)


def hits(problem: Problem, commands: Float[ndarray, "legs 4"]) -> bool:
    """Tell whether a plan hits by the world's own rules, leg by leg as the simulator plays it."""
    ball, solids = problem.instant.ball, problem.instant.solids
    track = fly(problem, commands[:, None])
    poses = np.concatenate([track.position[0], track.quaternion[0]], axis=1)
    ends = [*(problem.ticks[1:] - problem.instant.tick), problem.horizon]
    start = 0
    for end in ends:
        leg = poses[start : end + 1]
        states, contacts = advance(ball, start * TICK, leg, solids)
        for contact in contacts:
            if contact.solid == "blade" and contact.facing >= FULL_FACE:
                return True
            if contact.solid == "hull":
                return False
        if drone_touches_court(leg, solids.hull) or any(c.solid == "floor" for c in contacts):
            return False
        ball, start = states[-1], end
    return False


def fly(problem: Problem, commands: Commands) -> Track:
    """Fly b plans at once from the present state, with the noise to come."""
    state = repeated(problem.instant.vehicle, commands.shape[1])
    ends = [*(problem.ticks[1:] - problem.instant.tick), problem.horizon]
    start, parts = 0, []
    for leg, end in enumerate(ends):
        state, track = problem.vehicle.advance(
            state, commands[leg], ticks=int(end - start), new_command=True
        )
        skip = 0 if leg == 0 else 1
        parts.append([getattr(track, name)[:, skip:] for name in Track.__slots__])
        start = end
    return Track(*(np.concatenate(column, axis=1) for column in zip(*parts, strict=True)))


def _candidates(
    problem: Problem, rng: np.random.Generator
) -> Iterator[tuple[Commands, Float[ndarray, "b"]]]:
    limits = problem.vehicle.limits
    yield from _newton(problem, np.zeros((1, 4)))
    table = np.array(list(itertools.product(FORWARD, (0.0,), (0.0,), YAW))) * limits
    for commands, scores in _newton(problem, table):
        yield commands, scores
        best = commands[0, np.argmin(scores)]
    yield from _switched(problem, best, rng)


def _held(problem: Problem, commands: Float[ndarray, "b 4"]) -> Commands:
    """Return plans that give one command again and again."""
    return np.broadcast_to(commands, (len(problem.ticks), *commands.shape)).copy()


def _newton(
    problem: Problem, start: Float[ndarray, "b 4"]
) -> Iterator[tuple[Commands, Float[ndarray, "b"]]]:
    """Solve (left, up) of held commands so that the ball passes the blade's centre."""
    limits, guess, b = problem.vehicle.limits, start.copy(), len(start)
    inward = np.ones((b, 2))
    for _ in range(NEWTON_STEPS):
        nudged = np.repeat(guess[None], 3, axis=0)
        inward = np.where(guess[:, 1:3] > 0.5 * limits[1:3], -1.0, 1.0)
        nudged[1, :, 1] += NUDGE * limits[1] * inward[:, 0]
        nudged[2, :, 2] += NUDGE * limits[2] * inward[:, 1]
        commands = _held(problem, nudged.reshape(-1, 4))
        offsets, scores = _misses(problem, commands)
        yield commands, scores
        offsets = offsets.reshape(3, b, 2)
        steps = NUDGE * limits[1:3] * inward
        slopes = np.stack(
            [(offsets[1 + axis] - offsets[0]) / steps[:, axis, None] for axis in (0, 1)], axis=-1
        )
        guess[:, 1:3] = guess[:, 1:3] - _solved(slopes, offsets[0])
        guess = np.clip(guess, -limits, limits)
    commands = _held(problem, guess)
    yield commands, _misses(problem, commands)[1]


def _solved(slopes: Float[ndarray, "b 2 2"], offsets: Float[ndarray, "b 2"]) -> ndarray:
    """Return slopes^-1 offsets; zero where there is no slope."""
    a, b, c, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0], slopes[:, 1, 1]
    determinant = a * d - b * c
    usable = np.isfinite(determinant) & (np.abs(determinant) > 1e-9)
    inverse = np.where(usable, 1.0 / np.where(usable, determinant, 1.0), 0.0)
    y, z = offsets.T
    step = np.stack([(d * y - b * z) * inverse, (a * z - c * y) * inverse], axis=-1)
    return np.where(np.isfinite(step), step, 0.0)


def _misses(
    problem: Problem, commands: Commands
) -> tuple[Float[ndarray, "b 2"], Float[ndarray, "b"]]:
    """Return where the ball passes the blades (m left and up), and how far out in semi-axes."""
    solids = problem.instant.solids
    track = fly(problem, commands)
    found = plate_crossings(
        problem.path, track, blade_centre(solids.racket), hull_size(solids.hull)
    )
    return np.stack([found.left, found.up], axis=-1), _scores(found, solids)


def _scores(found: ndarray, solids: Solids) -> Float[ndarray, "b"]:
    racket = solids.racket
    out = np.hypot(found.left / racket.half_width, found.up / racket.half_height)
    touched = HULL_PENALTY * np.clip(-found.hull_gap / 0.02, 0.0, 1.0)
    return np.where(np.isfinite(out), np.nan_to_num(out) + np.nan_to_num(touched), 1e6)


def _switched(
    problem: Problem, best: Float[ndarray, "4"], rng: np.random.Generator
) -> Iterator[tuple[Commands, Float[ndarray, "b"]]]:
    """Draw sequences of three commands about the best so far, and closer about the better ones."""
    limits, legs = problem.vehicle.limits, len(problem.ticks)
    mean = np.concatenate([np.tile(best / limits, SEGMENTS), [0.33, 0.67]])
    spread = np.concatenate([np.full(4 * SEGMENTS, 0.8), [0.25, 0.25]])
    for _ in range(ROUNDS):
        draws = mean + spread * rng.standard_normal((DRAWS, len(mean)))
        draws[0] = mean
        draws = np.clip(draws, -1.0, 1.0)
        commands = _sequences(draws, limits, legs)
        scores = _misses(problem, commands)[1]
        yield commands, scores
        elite = draws[np.argsort(scores)[:ELITE]]
        mean = elite.mean(axis=0)
        spread = 0.7 * elite.std(axis=0) + 0.3 * spread * 0.7 + 0.02


def _sequences(draws: Float[ndarray, "b m"], limits: Float[ndarray, "4"], legs: int) -> Commands:
    levels = draws[:, : 4 * SEGMENTS].reshape(-1, SEGMENTS, 4) * limits
    turns = np.sort(np.abs(draws[:, 4 * SEGMENTS :]), axis=1) * legs
    segment = (np.arange(legs)[:, None, None] >= turns[None]).sum(axis=2)
    return levels[np.arange(len(draws))[None], segment]
