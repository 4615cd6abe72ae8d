"""A scripted pilot: a program that flies demonstrations as a person at the controls would.

It sees only what a person sees, the onboard picture and the instruments, 0.2 s late, and its hands
are imprecise: the sticks move at most every 0.1 s, in steps of 0.1 m/s, off by a tenth. From its
last sights it judges by straight lines when the ball will arrive and how far to the right, and by
gravity and a bounce on the table how far up, and steers so that the blade is there. It is no expert
human pilot and is called `scripted` wherever it appears.
"""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.drone import HOVER, BallEstimate, Drone, Eyes, VelocityCommand, Verdict

REACTION = 0.2  # s from seeing to moving
STICK_PERIOD = 0.1  # s between two movements of the sticks
STICK_STEP = 0.1  # m/s
STICK_ERROR = 0.1  # relative
FEWEST_SIGHTS = 4
MEMORY = 0.25  # s of sights that a judgement rests on
FASTEST = np.array([2.0, 0.5])  # m/s right and down, what the sticks give
LAG = 0.35  # s that a pilot knows the drone takes to answer
BOUNCE = 0.85  # of vertical speed, as a player feels it
HEIGHT_OVER_TABLE = 0.20  # m, of the camera at home
BLADE = np.array([0.0, -0.15])  # m right and down of the camera


class ScriptedPilot:
    """Implements Player; never learns."""

    def __init__(self) -> None:
        self.commands: list[tuple[float, VelocityCommand]] = []

    def play(self, drone: Drone, eyes: Eyes, rng: np.random.Generator) -> None:
        """Fly one serve; `commands` then holds what was sent and when."""
        self.commands = []
        sights: list[BallEstimate] = []
        moved, stick = -math.inf, HOVER
        while (observation := drone.observe()) is not None:
            now = observation.arrival_time
            sight = eyes.see(observation)
            if sight is not None:
                sights.append(sight)
            if now - moved >= STICK_PERIOD:
                stick, moved = _stick(sights, now, rng), now
            self.commands.append((now, drone.command(stick)))

    def learn(self, verdict: Verdict) -> None:
        """Learn nothing."""


def _stick(sights: list[BallEstimate], now: float, rng: np.random.Generator) -> VelocityCommand:
    seen = [s for s in sights if now - REACTION - MEMORY <= s.time <= now - REACTION]
    error = 1.0 + STICK_ERROR * rng.normal(size=2)
    if len(seen) < FEWEST_SIGHTS:
        return HOVER
    times = np.array([sight.time - now for sight in seen])
    places = np.stack([sight.position for sight in seen])
    arrival, offset = _judge(times, places)
    if arrival <= 0.0:
        return HOVER
    wanted = offset / max(arrival - LAG, 0.15)
    right, down = np.clip(STICK_STEP * np.round(wanted * error / STICK_STEP), -FASTEST, FASTEST)
    return VelocityCommand(left=float(-right), up=float(-down))


def _judge(
    times: Float[ndarray, "n"], places: Float[ndarray, "n 3"]
) -> tuple[float, Float[ndarray, "2"]]:
    """Return in how long the ball arrives and how far right and down of the blade it will be."""
    depth_rate, depth = np.polyfit(times, places[:, 2], 1)
    if depth_rate >= 0.0:
        return -1.0, np.zeros(2)
    arrival = -depth / depth_rate
    right_rate, right = np.polyfit(times, places[:, 0], 1)
    fall = 0.5 * GRAVITY * times**2
    down_rate, down = np.polyfit(times, places[:, 1] - fall, 1)
    lowest = HEIGHT_OVER_TABLE - BALL_RADIUS
    arrived = _fall(down, down_rate, arrival, lowest)
    return arrival, np.array([right + right_rate * arrival, arrived]) - BLADE


def _fall(down: float, rate: float, time: float, lowest: float) -> float:
    """Return how far down a ball is after `time`, bouncing once at `lowest`."""
    root = rate * rate + 2.0 * GRAVITY * (lowest - down)
    landing = (-rate + math.sqrt(root)) / GRAVITY if root > 0.0 else math.inf
    if not 0.0 < landing < time:
        return down + rate * time + 0.5 * GRAVITY * time**2
    speed = BOUNCE * (rate + GRAVITY * landing)
    rest = time - landing
    return lowest - speed * rest + 0.5 * GRAVITY * rest**2
