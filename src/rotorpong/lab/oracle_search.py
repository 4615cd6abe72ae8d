"""Commands that bring the blade onto a ball whose whole path is known.

A plan is one command, or three given at three of the coming frames. Plans are flown with the
vehicle's own `advance` from its true state, with the noise that is to come, and judged by the
contact rules of the world, so a plan that hits is known to hit. Three searches, from cheap to dear,
until one does:

    direct      one command; Newton's method in (left, up) for the place where the ball passes the
                blade's plane, differences for the slope, forward and yaw rate zero
    varied      the same from a table of forward speeds and yaw rates at once: the ball is met
                earlier or later, the blade swung sideways
    switched    three commands one after the other, drawn at random about the best so far and
                closer about the better ones (cross-entropy method), for several pairs of frames:
                tilting at the last moment lifts the blade
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float, Int64
from numpy import ndarray

from rotorpong.lab.reachable import blade_centre, free_path, hull_size
from rotorpong.physics.reach import Crossings, plate_crossings, repeated
from rotorpong.physics.vehicle import Track, Vehicle
from rotorpong.world.contact import TICK, Solids, advance, drone_touches_court
from rotorpong.world.judging import FULL_FACE
from rotorpong.world.simulated_drone import Instant

NEWTON_STEPS = 3
NUDGE = 0.2  # share of the limits, for differences
FORWARD = (-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0)  # shares of the limits
YAW = (-1.0, 0.0, 1.0)
SWITCHES = ((0.5, 0.8), (0.35, 0.65), (0.7, 0.88), (0.2, 0.5), (0.6, 0.75))  # of the time left
DRAWS = 32
ROUNDS = 5  # for each pair of switches
ELITE = 6
BEHIND = 0.7  # m behind the centre of mass at which a ball is given up
JUDGED = 3  # plans of a batch, the best first, that the contact rules judge
PROMISING = 1.3  # semi-axes off the blade's centre up to which they do
HULL_PENALTY = 3.0  # semi-axes, for a ball that touched the hull on its way
NO_CROSSING = 1e6

Frames = tuple[int, ...]  # which of the coming frames, 0 is the present one
Commands = Float[ndarray, "legs b 4"]


@dataclass(frozen=True, slots=True)
class Plan:
    """Commands at some of the coming frames, and whether they are known to hit."""

    frames: Frames
    ticks: tuple[int, ...]  # when they are expected
    commands: Float[ndarray, "legs 4"]
    hits: bool


@dataclass(frozen=True, slots=True)
class Problem:
    """A vehicle, a ball, and when commands can be given."""

    vehicle: Vehicle
    instant: Instant
    arrivals: Int64[ndarray, "frames"]  # ticks of the coming frames, the present one first
    path: Float[ndarray, "n 3"]  # of the ball, from now until nothing can happen any more

    @property
    def end(self) -> int:
        """The last tick to fly to."""
        return self.instant.tick + len(self.path) - 1


@dataclass(frozen=True, slots=True)
class Trials:
    """Plans of one batch, flown."""

    frames: Frames
    commands: Commands
    offsets: Float[ndarray, "b 2"]  # m left and up of the blade's centre, where the ball passes
    scores: Float[ndarray, "b"]  # how far out that is, in semi-axes


def problem_of(vehicle: Vehicle, instant: Instant, arrivals: Int64[ndarray, "frames"]) -> Problem:
    """Return the problem of an instant; `arrivals` are the coming frames, the present one first."""
    path = free_path(instant)
    gone = np.flatnonzero(path[:, 0] < instant.vehicle.position[0] - BEHIND)
    path = path[: max(int(gone[0]) + 1 if len(gone) else len(path), 2)]
    return Problem(vehicle, instant, arrivals[arrivals < instant.tick + len(path) - 1], path)


def search(problem: Problem, rng: np.random.Generator) -> Plan:
    """Return a plan that hits, or the one that comes closest."""
    best = plan_of(problem, (0,), np.zeros((1, 4)))
    best_score = np.inf
    for trials in _searches(problem, rng):
        for row in np.argsort(trials.scores)[:JUDGED]:
            plan = plan_of(problem, trials.frames, trials.commands[:, row])
            if trials.scores[row] < PROMISING and plan.hits:
                return plan
            if trials.scores[row] < best_score:
                best, best_score = plan, float(trials.scores[row])
    return best


def plan_of(problem: Problem, frames: Frames, commands: Float[ndarray, "legs 4"]) -> Plan:
    """Return commands as a plan, judged by the contact rules."""
    ticks = tuple(int(problem.arrivals[frame]) for frame in frames)
    return Plan(frames, ticks, commands, hits=_hits(problem, frames, commands))


def _hits(problem: Problem, frames: Frames, commands: Float[ndarray, "legs 4"]) -> bool:
    """Tell whether a plan hits by the world's own rules."""
    solids = problem.instant.solids
    track = fly(problem, frames, commands[:, None])
    poses = np.concatenate([track.position[0], track.quaternion[0]], axis=1)
    contacts = advance(problem.instant.ball, problem.instant.tick * TICK, poses, solids)[1]
    last = next((c for c in contacts if c.solid in ("blade", "hull", "floor")), None)
    while last is not None and last.solid == "blade" and last.facing < FULL_FACE:
        later = (c for c in contacts if c.time > last.time and c.solid in ("blade", "hull"))
        last = next(later, None)
    if last is None or last.solid != "blade":
        return False
    flown = round(last.time / TICK) - problem.instant.tick + 1
    return not drone_touches_court(poses[:flown], solids.hull)


def fly(problem: Problem, frames: Frames, commands: Commands) -> Track:
    """Fly b plans at once from the present state, with the noise to come."""
    state = repeated(problem.instant.vehicle, commands.shape[1])
    ticks = [int(problem.arrivals[frame]) for frame in frames]
    parts: list[Track] = []
    for leg, (start, end) in enumerate(itertools.pairwise([*ticks, problem.end])):
        state, track = problem.vehicle.advance(
            state, commands[leg], ticks=end - start, new_command=True
        )
        parts.append(track)
    return _joined(parts)


def _joined(parts: list[Track]) -> Track:
    """Return tracks that follow on one another as one; each starts where the last one ended."""
    columns: dict[str, ndarray | None] = {}
    for field in fields(Track):
        values = [getattr(part, field.name) for part in parts]
        rest = [value[:, 1:] for value in values[1:] if value is not None]
        known = values[0] is not None
        columns[field.name] = np.concatenate([values[0], *rest], axis=1) if known else None
    return Track(**columns)  # pyright: ignore[reportArgumentType]


def _searches(problem: Problem, rng: np.random.Generator) -> Iterator[Trials]:
    yield from _newton(problem, np.zeros((1, 4)))
    table = np.array(list(itertools.product(FORWARD, (0.0,), (0.0,), YAW)))
    best, best_score = np.zeros(4), np.inf
    for trials in _newton(problem, table * problem.vehicle.limits):
        yield trials
        row = int(np.argmin(trials.scores))
        if trials.scores[row] < best_score:
            best, best_score = trials.commands[0, row], trials.scores[row]
    for switches in SWITCHES:
        yield from _switched(problem, _frames_at(problem, switches), best, rng)


def _newton(problem: Problem, start: Float[ndarray, "b 4"]) -> Iterator[Trials]:
    """Solve (left, up) of held commands so that the ball passes the blade's centre."""
    limits, guess = problem.vehicle.limits, start.copy()
    for _ in range(NEWTON_STEPS):
        steps = np.where(guess > 0.5 * limits, -NUDGE, NUDGE) * limits
        nudged = np.repeat(guess[None], 3, axis=0)
        nudged[1, :, 1] += steps[:, 1]
        nudged[2, :, 2] += steps[:, 2]
        trials = _trials(problem, (0,), nudged.reshape(1, -1, 4))
        yield trials
        here, left, up = trials.offsets.reshape(3, -1, 2)
        slopes = np.stack([(left - here) / steps[:, 1:2], (up - here) / steps[:, 2:3]], axis=-1)
        guess[:, 1:3] -= _solved(slopes, here)
        guess = np.clip(guess, -limits, limits)
    yield _trials(problem, (0,), guess[None])


def _solved(slopes: Float[ndarray, "b 2 2"], offsets: Float[ndarray, "b 2"]) -> ndarray:
    """Return slopes^-1 offsets; zero where there is no slope."""
    a, b, c, d = slopes[:, 0, 0], slopes[:, 0, 1], slopes[:, 1, 0], slopes[:, 1, 1]
    determinant = a * d - b * c
    usable = np.isfinite(determinant) & (np.abs(determinant) > 1e-9)
    inverse = np.where(usable, 1.0 / np.where(usable, determinant, 1.0), 0.0)
    y, z = offsets.T
    step = np.stack([(d * y - b * z) * inverse, (a * z - c * y) * inverse], axis=-1)
    return np.where(np.isfinite(step), step, 0.0)


def _switched(
    problem: Problem, frames: Frames, best: Float[ndarray, "4"], rng: np.random.Generator
) -> Iterator[Trials]:
    """Draw sequences of commands about the best so far, and closer about the better ones."""
    limits = problem.vehicle.limits
    mean = np.tile(best / limits, (len(frames), 1))
    spread = np.full_like(mean, 0.7)
    for _ in range(ROUNDS):
        draws = np.clip(mean + spread * rng.standard_normal((DRAWS, *mean.shape)), -1.0, 1.0)
        trials = _trials(problem, frames, np.swapaxes(draws, 0, 1) * limits)
        yield trials
        elite = draws[np.argsort(trials.scores)[:ELITE]]
        mean = elite.mean(axis=0)
        spread = 0.8 * elite.std(axis=0) + 0.05


def _frames_at(problem: Problem, switches: tuple[float, float]) -> Frames:
    last = len(problem.arrivals) - 1
    frames = {0, *(min(round(share * last), last) for share in switches)}
    return tuple(sorted(frames))


def _trials(problem: Problem, frames: Frames, commands: Commands) -> Trials:
    solids = problem.instant.solids
    track = fly(problem, frames, commands)
    centre, hull = blade_centre(solids.racket), hull_size(solids.hull)
    found = plate_crossings(problem.path, track, centre, hull)
    offsets = np.stack([found.left, found.up], axis=-1)
    return Trials(frames, commands, offsets, _scores(found, solids))


def _scores(found: Crossings, solids: Solids) -> Float[ndarray, "b"]:
    out = np.hypot(found.left / solids.racket.half_width, found.up / solids.racket.half_height)
    touched = HULL_PENALTY * np.clip(-found.hull_gap / 0.02, 0.0, 1.0)
    return np.where(np.isfinite(out), np.nan_to_num(out + touched), NO_CROSSING)
