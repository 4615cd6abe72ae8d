"""What the tracker's eyes know before a serve: the kind of serve, and how good the drone's gyro is.

A player may know this: that balls are thrown from the other side of the table, how much spin they
are given, and the data sheet of its own drone. It is that of the nominal drone, also where every
trial meets another (`--randomize`).
"""

from collections.abc import Mapping
from dataclasses import replace

from rotorpong.physics.camera import Camera
from rotorpong.vision.colour import ORANGE, Colour
from rotorpong.vision.flight_filter import (
    ARDRONE2_ATTITUDE,
    HUMAN_PRIOR,
    TUM_ATTITUDE,
    AttitudeQuality,
    Prior,
)
from rotorpong.vision.own_motion import OdometryQuality
from rotorpong.vision.tracker import TrackerEyes
from rotorpong.world.racket import HOME_BODY

THROW = replace(HUMAN_PRIOR, velocity=(-6.5, 0.0, 2.3), velocity_sd=(1.0, 1.0, 1.3), spin_sd=22.0)
"""400 throws of the kind `human` (seed 777) leave with (-6.8, 0.0, 2.8) m/s, sd (0.5, 0.6, 0.8),
spin sd 20; slower and rounder here, by judgement: the first sight is later, throwers differ."""
PRIORS: Mapping[str, Prior] = {
    "human": THROW,
    "constant": THROW,
    "hard": replace(THROW, spin_sd=65.0),
    "lob": replace(THROW, velocity=(-6.7, 0.0, 4.3), velocity_sd=(1.0, 1.0, 1.5)),
}
MEASURED_PRIOR = replace(HUMAN_PRIOR, spin_sd=100.0, velocity_sd=(4.0, 2.0, 4.0))
"""Of serves from files, which may be anybody's."""
ATTITUDES: Mapping[str, AttitudeQuality] = {"tum_gazebo": TUM_ATTITUDE}
ODOMETRIES: Mapping[str, OdometryQuality] = {
    "tum_gazebo": OdometryQuality(
        rise_sd=2.0, sonar_sd=0.001, drag=0.0, drag_sd=0.01, thrust_sd=0.01
    ),
    "ardrone2": OdometryQuality(flow_delay=0.04, drag=0.58, drag_sd=0.15, thrust_sd=0.05),
}
"""By their data sheets (`physics.cascade`, `physics.ardrone2`). The simulator's sonar is exact; its
thrust was seen to swing by 2 to 3 m/s^2 at 50 Hz, which 200 Hz hardly resolve."""


def tracker_eyes(camera: Camera, vehicle: str, serves: str, colour: Colour = ORANGE) -> TrackerEyes:
    """Return fresh eyes for one serve.

    Args:
        camera: what they take the drone's camera for.
        vehicle: name of the drone; of one that is not known, a good gyro is believed.
        serves: kind of serve, or a file.
        colour: of the ball.
    """
    attitude = ATTITUDES.get(vehicle, ARDRONE2_ATTITUDE)
    odometry = ODOMETRIES.get(vehicle, OdometryQuality())
    prior = replace(PRIORS.get(serves, MEASURED_PRIOR), attitude=attitude)
    return TrackerEyes(camera, home=HOME_BODY, prior=prior, odometry=odometry, colours=(colour,))
