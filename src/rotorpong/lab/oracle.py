"""The oracle: what could be hit by somebody who knows everything, but not before the others.

It knows the ball's exact path, the vehicle's true constants and state, and all noise to come, and
searches commands that hit (`oracle_search`). It may act as late as everybody who sees: until the
third frame whose picture holds the ball has arrived, `Gate` turns each of its commands to hover.
Only the laboratory can build it: it is no player of `rotorpong.play`.
"""

import numpy as np
from jaxtyping import Int64
from numpy import ndarray

from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, Drone, Eyes, Observation, VelocityCommand, Verdict
from rotorpong.lab.oracle_search import Plan, Problem, plan_of, problem_of, search
from rotorpong.lab.reachable import FRAMES_TO_DECIDE, shows_ball
from rotorpong.world.contact import TICK
from rotorpong.world.simulated_drone import LONGEST_SERVE, SimulatedDrone

MOST_SEARCHES = 3  # of a serve that no plan hits


class Gate:
    """A drone that hovers until the third frame with the ball in the picture has arrived."""

    def __init__(self, drone: SimulatedDrone) -> None:
        """Stand before `drone`."""
        self._drone = drone
        self._seen = 0

    def observe(self) -> Observation | None:
        """Wait for the next frame."""
        observation = self._drone.observe()
        if observation is not None:
            self._seen += shows_ball(self._drone, observation)
        return observation

    def command(self, velocity: VelocityCommand) -> VelocityCommand:
        """Fly at `velocity`, or hover while the gate is shut; return what was sent."""
        return self._drone.command(velocity if self.is_open else HOVER)

    @property
    def is_open(self) -> bool:
        """Whether commands pass."""
        return self._seen >= FRAMES_TO_DECIDE

    @property
    def drone(self) -> SimulatedDrone:
        """The truth."""
        return self._drone


class Oracle:
    """Plays one serve after another; keeps nothing."""

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Play one serve behind a gate.

        Raises:
            InputError: the drone is no simulated one behind a gate.
        """
        if not isinstance(drone, Gate):
            raise InputError(f"the oracle flies a simulated drone behind a Gate, not {drone!r}")
        plan, frame, searches = None, 0, 0
        while drone.observe() is not None:
            if not drone.is_open:
                drone.command(HOVER)
                continue
            plan = None if plan is None else _checked(plan, frame, drone.drone)
            if plan is None or (not plan.hits and searches < MOST_SEARCHES):
                plan, frame, searches = search(_problem(drone.drone), rng), 0, searches + 1
            if frame in plan.frames:
                command = plan.commands[plan.frames.index(frame)]
                drone.command(VelocityCommand(*command.tolist()))
            frame += 1

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing: it knows."""


def arrivals(tick: int, frames_per_second: float) -> Int64[ndarray, "n"]:
    """Return when the coming frames are expected, the present one first."""
    period = 1.0 / (frames_per_second * TICK)
    count = max(1, int((LONGEST_SERVE - tick) / period) + 1)
    return tick + np.rint(np.arange(count) * period).astype(np.int64)


def _problem(drone: SimulatedDrone) -> Problem:
    now = drone.now
    return problem_of(drone.vehicle, now, arrivals(now.tick, drone.camera.frames_per_second))


def _checked(plan: Plan, frame: int, drone: SimulatedDrone) -> Plan | None:
    """Return a plan unless it was to hit and no longer does.

    A frame may come a tick before or after it was expected; then the rest is flown anew.
    """
    if not plan.hits or frame not in plan.frames:
        return plan
    leg = plan.frames.index(frame)
    if plan.ticks[leg] == drone.now.tick:
        return plan
    problem = _problem(drone)
    frames = tuple(f - frame for f in plan.frames[leg:])
    if frames[-1] >= len(problem.arrivals):
        return None
    return plan if plan_of(problem, frames, plan.commands[leg:]).hits else None
