"""Commands and flights for the tests of vehicles."""

import numpy as np
from scipy.spatial.transform import Rotation

FORWARD, LEFT, UP, YAW = range(4)
HOME = np.array([-1.9, 0.0, 0.2])


def rng(seed=0):
    return np.random.default_rng(seed)


def command(axis=FORWARD, size=0.0):
    return np.eye(4)[axis] * size


def body_axes(quaternion):
    return Rotation.from_quat(quaternion, scalar_first=True)


def flight(drone, state, portions, orders):
    """Send one order for each group of portions; return the last state and all tracks."""
    tracks = []
    for group, order in zip(portions, orders, strict=True):
        for i, ticks in enumerate(group):
            state, track = drone.advance(state, order, ticks=ticks, new_command=i == 0)
            tracks.append(track)
    return state, tracks


def joined(tracks, name):
    """Return all instants after the first of tracks that follow each other, time first."""
    return np.concatenate([np.moveaxis(getattr(track, name), -2, 0)[1:] for track in tracks])
