"""How near the ball is to the solids, compiled: proofs that for a while nothing can be touched.

A gap changes no faster than ball and solid move, and drag and Magnus force make no ball faster: so
a gap now, over how fast it can close, is a time in which nothing of it need be looked at. What is
passed over changes no result.
"""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.kernels import inlined_kernel, kernel
from rotorpong.world._solid_kernels import (
    FLOOR,
    HALF_POST,
    NET,
    START,
    TABLE,
    blade_gap,
    body_point,
    court_gap,
    hull_gap,
    least_blade_gap,
    pose_between,
)
from rotorpong.world.court import NET_HEIGHT

HORIZON = 64  # ticks that are looked ahead at most
SLACK = 1e-9  # m, more than rounding makes of a gap


@inlined_kernel
def ball_travel(vx, vy, vz, duration):
    """Return more than a ball of this velocity can move in a step, m."""
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    return 1.001 * (speed + GRAVITY * duration) * duration


@inlined_kernel
def court_is_near(x, z, travel):
    """Tell whether a ball can touch table, net or floor before it has moved further than that."""
    reach = BALL_RADIUS + travel
    return z <= reach or (abs(x) <= HALF_POST + reach and z <= NET_HEIGHT + reach)


@kernel
def drone_reach(scene):
    """Return how far from the centre of mass a touching ball's centre can be, m."""
    racket, hull = scene.racket, scene.hull
    centre = math.sqrt(racket.x**2 + racket.y**2 + racket.z**2)
    blade = centre + max(racket.half_width, racket.half_height)
    return max(blade, math.sqrt(hull.radius**2 + hull.half_height**2)) + BALL_RADIUS


@kernel
def drone_travel(track, i, reach):
    """Return more than any point of the drone moves in tick i, m."""
    j, way, turn, dot = min(i + 1, track.shape[0] - 1), 0.0, 0.0, 0.0
    for k in range(3):
        way += (track[j, k] - track[i, k]) ** 2
    for k in range(3, 7):
        dot += track[i, k] * track[j, k]
    sign = math.copysign(1.0, dot)
    for k in range(3, 7):  # squared chord of unit quaternions, 2 sin(angle / 4)
        turn += (track[j, k] - sign * track[i, k]) ** 2
    return 1.001 * math.sqrt(way) + 2.5 * reach * math.sqrt(turn) + 1e-12


@kernel
def drone_is_near(work, travel, track, i, reach):
    """Tell whether the ball at START can touch the drone in tick i."""
    if track.shape[0] == 0:
        return False
    dx, dy = work[START, 0] - track[i, 0], work[START, 1] - track[i, 1]
    dz = work[START, 2] - track[i, 2]
    distance = dx * dx + dy * dy + dz * dz
    if distance > 9.0 * (reach + travel) ** 2 + 1.0:  # a drone at 1 km/s gets no further in a tick
        return False
    return distance <= (reach + travel + drone_travel(track, i, reach)) ** 2


@kernel
def ticks_off_court(work, pace):
    """Return for how many ticks the ball at START can touch neither table nor net nor floor."""
    x, y, z = work[START, 0], work[START, 1], work[START, 2]
    gap = min(court_gap(TABLE, x, y, z), court_gap(NET, x, y, z))
    return whole_ticks(min(gap, court_gap(FLOOR, x, y, z)), pace)


@inlined_kernel
def box_of(track):
    """Return the box about the places of a track: its lowest corner, its highest."""
    low_x, low_y, low_z = np.inf, np.inf, np.inf
    high_x, high_y, high_z = -np.inf, -np.inf, -np.inf
    for i in range(track.shape[0]):
        x, y, z = track[i, 0], track[i, 1], track[i, 2]
        low_x, high_x = x if x < low_x else low_x, x if x > high_x else high_x
        low_y, high_y = y if y < low_y else low_y, y if y > high_y else high_y
        low_z, high_z = z if z < low_z else low_z, z if z > high_z else high_z
    return low_x, low_y, low_z, high_x, high_y, high_z


@inlined_kernel
def box_distance(box, x, y, z):
    """Return the distance of a place to a box, 0 inside."""
    dx = max(box[0] - x, x - box[3], 0.0)
    dy = max(box[1] - y, y - box[4], 0.0)
    dz = max(box[2] - z, z - box[5], 0.0)
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@kernel
def fastest_travel(track, first, reach):
    """Return more than any point of the drone moves in each tick from `first` on, m."""
    most = 0.0
    for i in range(first, track.shape[0] - 1):
        most = max(most, drone_travel(track, i, reach))
    return most


@kernel
def ticks_off_drone(work, track, i, pace, scene):
    """Return for how many ticks from i on the ball at START cannot touch the drone.

    Args:
        work: scratch.
        track: poses.
        i: tick.
        pace: how fast the gap can close, m per tick.
        scene: parameters.
    """
    pose_between(track, i, 0.0, work)
    x, y, z = body_point(work[START, 0], work[START, 1], work[START, 2], work)
    gap = least_blade_gap(x, y, z, scene.racket)
    if gap <= 8.0 * pace:  # it is worth while to know it better
        gap = blade_gap(x, y, z, scene.racket)
    return whole_ticks(min(gap, hull_gap(x, y, z, scene.hull)), pace)


@inlined_kernel
def whole_ticks(gap, pace):
    """Return for how many ticks a gap stays open that closes no faster than `pace`; 0 for nan."""
    if gap - SLACK >= pace:
        return int(min((gap - SLACK) / pace, HORIZON))
    return 0
