"""What the tracker's eyes know before a serve: the kind of serve, and how good the drone's gyro is.

A player may know this: that balls are thrown from the other side of the table, how much spin they
are given, and the data sheet of its own drone. It is that of the nominal drone, also where every
trial meets another (`--randomize`).
"""

from collections.abc import Mapping
from dataclasses import replace

from rotorpong.physics.camera import Camera
from rotorpong.vision.flight_filter import (
    ARDRONE2_ATTITUDE,
    HUMAN_PRIOR,
    TUM_ATTITUDE,
    AttitudeQuality,
    Prior,
)
from rotorpong.vision.tracker import TrackerEyes
from rotorpong.world.racket import HOME_BODY

PRIORS: Mapping[str, Prior] = {
    "human": HUMAN_PRIOR,
    "constant": HUMAN_PRIOR,
    "hard": replace(HUMAN_PRIOR, spin_sd=65.0),
    "lob": replace(HUMAN_PRIOR, velocity=(-6.0, 0.0, 3.0), velocity_sd=(3.0, 1.5, 4.0)),
}
MEASURED_PRIOR = replace(HUMAN_PRIOR, spin_sd=100.0, velocity_sd=(4.0, 2.0, 4.0))
"""Of serves from files, which may be anybody's."""
ATTITUDES: Mapping[str, AttitudeQuality] = {"tum_gazebo": TUM_ATTITUDE}


def tracker_eyes(camera: Camera, vehicle: str, serves: str, colour: str = "orange") -> TrackerEyes:
    """Return fresh eyes for one serve.

    Args:
        camera: what they take the drone's camera for.
        vehicle: name of the drone; of one that is not known, a good gyro is believed.
        serves: kind of serve, or a file.
        colour: of the ball, by name.
    """
    attitude = ATTITUDES.get(vehicle, ARDRONE2_ATTITUDE)
    prior = PRIORS.get(serves, MEASURED_PRIOR)
    known = replace(prior, attitude=attitude)
    return TrackerEyes(camera, home=HOME_BODY, prior=known, colours=(colour,))
