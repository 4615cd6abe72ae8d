"""Whether any player could have hit a serve.

The decision is the arrival of the third frame whose picture holds the ball's centre, at a drone
that was told to hover at each frame. A serve is called unreachable if at no tick the ball, on its
path over the empty court, can touch a blade anywhere within the bound of `physics.reach`: about
home before the decision, all that the vehicle could do after it. So no player whose first command
other than hover's follows that frame hits such a serve. Before the bound is drawn, which takes
many flights, four flights at the limits show that most balls pass well within reach.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.drone import HOVER, Observation
from rotorpong.physics.camera import in_picture
from rotorpong.physics.reach import Bound, fly_all, plate_bound, plate_crossings
from rotorpong.world.contact import TICK, advance
from rotorpong.world.racket import HOME_BLADE, Hull, Racket
from rotorpong.world.simulated_drone import LONGEST_SERVE, Instant, SimulatedDrone

FRAMES_TO_DECIDE = 3
HOVER_ROOM = 0.03  # m, how far a hovering blade is from home,
HOVER_DRIFT = 0.08  # m/s, and how that grows
LAST_LEG = 100  # ticks that a serve goes on after the ball touched the floor, at most
NOBODY = np.tile([0.0, 0.0, 99.0, 1.0, 0.0, 0.0, 0.0], (LAST_LEG + 1, 1))  # where no ball comes
LATER = 100  # ticks after the ball passed home within which it passes blades that moved back
ON_BLADE = 0.6  # of each semi-axis: certainly on the blade
FAR_BEHIND = 3.0  # m: no drone retreats further before the ball overtakes it

Path = Float[ndarray, "n 3"]  # the ball's centre at successive ticks, world


@dataclass(frozen=True, slots=True)
class Decision:
    """When a player may act, and what it must deal with."""

    instant: Instant | None  # None: there never was a third frame with the ball
    path: Path  # over the empty court, from the release on


def decide(drone: SimulatedDrone) -> Decision:
    """Let a fresh drone hover up to the decision."""
    path = free_path(drone.now)
    seen = 0
    while (observation := drone.observe()) is not None:
        seen += shows_ball(drone, observation)
        if seen == FRAMES_TO_DECIDE:
            return Decision(drone.now, path)
        drone.command(HOVER)
    return Decision(None, path)


def shows_ball(drone: SimulatedDrone, observation: Observation) -> bool:
    """Tell whether a frame's picture holds the ball's centre."""
    position, _ = drone.ball_in_camera(observation.frame_time)
    return bool(in_picture(drone.camera, position))


def free_path(instant: Instant) -> Path:
    """Return where the ball goes over the empty court, up to the end of any serve."""
    state, parts, landed = instant.ball, [instant.ball[None, :3]], False
    for _ in range(-(-(LONGEST_SERVE - instant.tick) // LAST_LEG)):
        states, contacts = advance(state, 0.0, NOBODY, instant.solids)
        parts.append(states[:, :3])
        if landed:
            break
        state, landed = states[-1], any(contact.solid == "floor" for contact in contacts)
    return np.concatenate(parts)


def is_reachable(drone: SimulatedDrone) -> bool:
    """Tell whether some admissible commands bring the blade onto the ball.

    Args:
        drone: of the serve, fresh; it is flown hovering up to the decision.
    """
    racket, vehicle = drone.now.solids.racket, drone.vehicle
    decision = decide(drone)
    instant, path = decision.instant, decision.path
    tick = len(path) if instant is None else min(instant.tick, len(path) - 1)
    if hovering_bound(racket, tick).touched_by(path[:tick]).any():
        return True
    if instant is None:
        return False
    rest = path[tick:]
    if _is_well_inside(drone, instant, rest):
        return True
    horizon = last_near(rest)
    bound = plate_bound(vehicle, instant.vehicle, horizon, blade_corners(racket))
    return bool(bound.touched_by(rest[: horizon + 1]).any())


def blade_corners(racket: Racket) -> Float[ndarray, "4 3"]:
    """Return the corners of the rectangle about the blade, body frame."""
    signs = np.array([[0, 1, 1], [0, 1, -1], [0, -1, 1], [0, -1, -1]])
    size = np.array([0.0, racket.half_width, racket.half_height])
    return np.array([racket.x, racket.y, racket.z]) + signs * size


def hovering_bound(racket: Racket, ticks: int) -> Bound:
    """Return where the blade of a hovering drone can be, from the release on."""
    size = max(racket.half_width, racket.half_height)
    room = (size + HOVER_ROOM + HOVER_DRIFT * TICK * np.arange(ticks))[:, None]
    return Bound(np.array(HOME_BLADE) - room, np.array(HOME_BLADE) + room)


def last_near(path: Path) -> int:
    """Return the last tick at which the ball is not yet far behind home."""
    ahead = np.flatnonzero(path[:, 0] > HOME_BLADE[0] - FAR_BEHIND)
    return max(1, int(ahead[-1])) if len(ahead) else 1


def _is_well_inside(drone: SimulatedDrone, instant: Instant, path: Path) -> bool:
    """Tell whether the ball passes between the blades of four simple flights."""
    passed = np.flatnonzero(path[:, 0] < HOME_BLADE[0])
    if not len(passed):
        return False
    ticks = min(int(passed[0]) + LATER, len(path) - 1)
    solids = instant.solids
    limits = drone.vehicle.limits
    signs = np.array([[0, 1, 1, 0], [0, 1, -1, 0], [0, -1, 1, 0], [0, -1, -1, 0]])
    track = fly_all(drone.vehicle, instant.vehicle, signs * limits, ticks)[1]
    ball, racket, hull = path[: ticks + 1], solids.racket, solids.hull
    found = plate_crossings(ball, track, blade_centre(racket), hull_size(hull))
    left, up = found.left, found.up  # nan compares false
    y, z = ON_BLADE * racket.half_width, ON_BLADE * racket.half_height
    return bool(
        max(left[0], left[1]) < y
        and min(left[2], left[3]) > -y
        and max(up[0], up[2]) < z
        and min(up[1], up[3]) > -z
    )


def blade_centre(racket: Racket) -> tuple[float, float, float]:
    """Return the blade's centre in the body frame."""
    return racket.x, racket.y, racket.z


def hull_size(hull: Hull) -> tuple[float, float]:
    """Return radius and half height."""
    return hull.radius, hull.half_height
