"""Eyes that know: the exact ball in the frame of the onboard camera.

Only the laboratory can hand them to a player. They answer for every frame that shows the ball's
centre inside the picture, and for no other.
"""

import numpy as np

from rotorpong.drone import BallEstimate, Observation
from rotorpong.physics.camera import in_picture
from rotorpong.world.simulated_drone import SimulatedDrone


class TruthEyes:
    """Eyes for one serve of one simulated drone."""

    def __init__(self, drone: SimulatedDrone) -> None:
        """See through the camera of `drone`."""
        self._drone = drone

    def see(self, observation: Observation) -> BallEstimate | None:
        """Return the exact state at the frame's time; `None` while the ball is out of the picture.

        The velocity is that of the ball relative to the camera's position, in the camera's axes,
        as differences of successive positions approach it when the camera does not turn.
        """
        position, velocity = self._drone.ball_in_camera(observation.frame_time)
        if not in_picture(self._drone.camera, position):
            return None
        return BallEstimate(observation.frame_time, position, velocity, np.zeros((6, 6)))
