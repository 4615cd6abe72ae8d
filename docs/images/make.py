"""Make the pictures of README and docs: `python docs/images/make.py`."""

from pathlib import Path

import cv2

from rotorpong.drone import HOVER
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.world.simulated_drone import SimulatedDrone

HERE = Path(__file__).parent
TRIAL, FRAME = 3, 16  # a serve with the ball well in view, and when


def main() -> None:
    """Render what the drone sees of one serve through the camera of the AR.Drone 2.0."""
    spec = Spec(camera="ardrone2_720p", seed=1)
    generators = trial_generators(spec.seed, "evaluate", TRIAL)
    serve = serve_source(spec.serves, spec.seed)(TRIAL, generators.serve)
    drone = SimulatedDrone(
        serve, spec.setting(), vehicle_rng=generators.vehicle, sensor_rng=generators.sensors
    )
    for _ in range(FRAME):
        observation = drone.observe()
        drone.command(HOVER)
    if observation is None:
        raise SystemExit("the serve was over too early: choose another trial or frame")
    smallest = [cv2.IMWRITE_PNG_COMPRESSION, 9]
    cv2.imwrite(str(HERE / "onboard.png"), observation.frame.picture, smallest)


if __name__ == "__main__":
    main()
