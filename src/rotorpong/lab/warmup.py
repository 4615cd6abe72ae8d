"""Compiling every kernel once, before anything is timed or worker processes start."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rotorpong.drone import HOVER
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, bounce, fly
from rotorpong.primitives import Dmp, State
from rotorpong.world.serves import crossing
from rotorpong.world.simulated_drone import SimulatedDrone

Step = Callable[[int, int], None]
STEPS = 4


def warm_up(progress: Step | None = None) -> None:
    """Run through every kernel; numba compiles what its cache does not hold (a minute at most).

    Args:
        progress: called with (steps done, steps).
    """
    tell = progress or (lambda done, steps: None)
    tell(0, STEPS)
    generators = trial_generators(0, "evaluate", 0)
    spec = Spec()
    serve = serve_source(spec.serves, 0)(0, generators.serve)
    crossing(serve)
    tell(1, STEPS)
    drone = SimulatedDrone(
        serve, spec.setting(), vehicle_rng=generators.vehicle, sensor_rng=generators.sensors
    )
    observation = drone.observe()
    drone.command(HOVER)
    drone.truth()
    tell(2, STEPS)
    if observation is not None:
        spec.make_eyes(drone).see(observation)
    _take_frame(replace(spec, camera="ardrone2_360p"))
    tell(3, STEPS)
    ball = bounce(Ball(np.zeros(3), np.array([1.0, 0.0, -1.0]), np.zeros(3)), UP, TABLE_SURFACE)
    fly(ball, Air(), 0.1)
    rest = State(np.zeros(3), np.zeros(3))
    Dmp(np.zeros((20, 3))).roll_out(rest, rest, 1.0, np.linspace(0.0, 1.0, 3))
    tell(STEPS, STEPS)


def _take_frame(spec: Spec) -> None:
    """Look at a few pixels of a frame of a full sensor."""
    generators = trial_generators(0, "evaluate", 0)
    serve = serve_source(spec.serves, 0)(0, generators.serve)
    drone = SimulatedDrone(
        serve, spec.setting(), vehicle_rng=generators.vehicle, sensor_rng=generators.sensors
    )
    observation = drone.observe()
    if observation is not None:
        observation.frame.region(0, 0, 2, 2)


UP = np.array([0.0, 0.0, 1.0])
